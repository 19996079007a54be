//! Date and time.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    machine::{cell::Cell, fault::Fault},
    value::Text,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "CNV_STR_TIME", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: str_time },
    Builtin { name: "CNV_TIME_STR", params: &[Param::Integer, Param::OutText], required: 2, returns: Returns::Nothing, code: time_str },
    Builtin { name: "GET_USEC_SUB", params: &[Param::Integer, Param::Integer], required: 2, returns: Returns::Integer, code: get_usec_sub },
    Builtin { name: "GET_USEC_TIM", params: &[], required: 0, returns: Returns::Integer, code: get_usec_tim },
    Builtin { name: "GET_TIME", params: &[Param::OutInteger], required: 1, returns: Returns::Nothing, code: get_time },
];

const MONTHS: [&str; 12] = [
    "JAN", "FEB", "MAR", "APR", "MAY", "JUN", "JUL", "AUG", "SEP", "OCT", "NOV", "DEC",
];

/// Date and time in one number: seconds/2 in 5 bits, minutes in 6, hours in 5, day in 5, month in
/// 4, years since 1980 in 7.
///
/// ASSUMPTION: this crate has no calendar; the controller's clock starts at 1980-01-01 00:00 when it
/// is switched on.
fn get_time(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let seconds = context.host.now().as_secs();
    let (minutes, hours, days) = (seconds / 60 % 60, seconds / 3600 % 24, seconds / 86_400);
    // Beyond a month nobody looks; the day stays the last.
    let day = 1 + days.min(30);
    let date = (day << 16) | (1 << 21);
    let packed = date | (hours << 11) | (minutes << 5) | (seconds % 60 / 2);
    context.put(0, Cell::Integer(i32::try_from(packed).unwrap_or(i32::MAX)));
    Ok(Outcome::Done)
}

/// Microseconds since power-on.
///
/// ASSUMPTION: in 32 bits, which begin again after 71 minutes.
fn get_usec_tim(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let micros = context.host.now().as_micros() & u128::from(u32::MAX);
    let micros = u32::try_from(micros).unwrap_or(0).cast_signed();
    Ok(Outcome::Value(Cell::Integer(micros)))
}

/// `GET_USEC_SUB(us2, us1)`: what went by from `us1` to `us2`, also beyond the end of the 32 bits.
fn get_usec_sub(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let passed = context.integer(0).wrapping_sub(context.integer(1));
    Ok(Outcome::Value(Cell::Integer(passed)))
}

/// A packed time as `DD-MMM-YY HH:MM`.
///
/// ASSUMPTION: days and months out of range are shown as `00` and `???`; years count from 1980 and
/// are shown with two digits.
fn time_str(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let packed = context.integer(0).cast_unsigned();
    let (minute, hour) = (packed >> 5 & 0x3f, packed >> 11 & 0x1f);
    let (day, month, year) = (packed >> 16 & 0x1f, packed >> 21 & 0xf, packed >> 25);
    let name = (month as usize).checked_sub(1);
    let name = name.and_then(|index| MONTHS.get(index)).unwrap_or(&"???");
    let year = (80 + year) % 100;
    let text = format!("{day:02}-{name}-{year:02} {hour:02}:{minute:02}");
    context.put_text(1, Text::from(text.as_str()));
    Ok(Outcome::Done)
}

/// `DD-MMM-YY HH:MM` as a packed time; what is none leaves the variable without a value.
fn str_time(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let text = context.text(0).to_string_lossless();
    let packed = parse(text.trim());
    context.put(1, packed.map_or(Cell::Uninit, Cell::Integer));
    Ok(Outcome::Done)
}

fn parse(text: &str) -> Option<i32> {
    let (date, time) = text.split_once(' ')?;
    let mut date = date.split('-');
    let (day, month, year) = (date.next()?, date.next()?, date.next()?);
    let month = month.to_ascii_uppercase();
    let month = MONTHS.iter().position(|known| *known == month)? + 1;
    let day: u32 = day.parse().ok().filter(|day| (1..=31).contains(day))?;
    let year: u32 = year.parse().ok().filter(|year| *year < 100)?;
    let mut time = time.trim().split(':');
    let hour: u32 = time.next()?.parse().ok().filter(|hour| *hour < 24)?;
    let minute: u32 = time.next()?.parse().ok().filter(|minute| *minute < 60)?;
    if date.next().is_some() || time.nth(1).is_some() {
        return None;
    }
    let year = (year + 20) % 100;
    let month = u32::try_from(month).ok()?;
    let packed = year << 25 | month << 21 | day << 16 | hour << 11 | minute << 5;
    Some(packed.cast_signed())
}
