//! Arguments that are more than a number or a word.

use std::net::{IpAddr, SocketAddr};

use anyhow::{Context, anyhow, bail};
use karel_emulator::config::InterpolationPeriod;
use karel_emulator::{Clock, FaultBody, from_json};
use kinematics::PendantJoints;

pub(super) fn parse_clock(text: &str) -> anyhow::Result<Clock> {
    if text.eq_ignore_ascii_case("max") {
        return Ok(Clock::unhurried());
    }
    let scale = text.parse().ok().and_then(Clock::scaled);
    scale.ok_or_else(|| {
        anyhow!("the time scale is {text}, it must be above 0 and at most 1000, or max")
    })
}

/// What one `--set` sets.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Presets(pub(super) Vec<(String, String)>);

pub(super) fn parse_presets(text: &str) -> Result<Presets, String> {
    let Some(path) = text.strip_prefix('@') else {
        return parse_preset(text).map(|preset| Presets(vec![preset]));
    };
    let lines =
        std::fs::read_to_string(path).map_err(|error| format!("reading {path}: {error}"))?;
    let mut presets = Vec::new();
    for (number, line) in (1..).zip(lines.lines()) {
        let line = line.trim();
        if !line.is_empty() && !line.starts_with("--") {
            let preset = parse_preset(line).map_err(|error| format!("{path}:{number}: {error}"))?;
            presets.push(preset);
        }
    }
    Ok(Presets(presets))
}

fn parse_preset(text: &str) -> Result<(String, String), String> {
    let (item, value) = text
        .split_once('=')
        .ok_or_else(|| format!("{text:?} is not ITEM=VALUE, such as R[1]=5"))?;
    Ok((item.trim().to_owned(), value.trim().to_owned()))
}

pub(super) fn parse_fault(text: &str) -> Result<FaultBody, String> {
    from_json(text.as_bytes(), "the fault").map_err(|error| error.to_string())
}

pub(super) fn parse_port_map(text: &str) -> Result<(u16, u16), String> {
    let (program, host) = text
        .split_once('=')
        .ok_or_else(|| format!("{text:?} is not PORT=HOST, such as 59002=0"))?;
    let number = |part: &str| {
        part.trim()
            .parse::<u16>()
            .map_err(|_| format!("{part:?} is not a port, 0 to 65535"))
    };
    match (number(program)?, number(host)?) {
        (0, _) => Err("a program cannot listen on port 0".to_owned()),
        pair => Ok(pair),
    }
}

pub(super) fn parse_period(text: &str) -> Result<InterpolationPeriod, String> {
    let period = text.parse().ok().and_then(InterpolationPeriod::from_millis);
    period.ok_or_else(|| format!("{text:?} is not a whole number of milliseconds, 1 to 64"))
}

pub(super) fn parse_host(text: &str) -> Result<(String, IpAddr), String> {
    let (name, address) = text.split_once('=').unwrap_or((text, text));
    let address = address.trim().parse();
    let address = address.map_err(|_| format!("{text:?} is not ADDRESS or NAME=ADDRESS"))?;
    Ok((name.trim().to_owned(), address))
}

pub(super) fn parse_panel(text: &str) -> anyhow::Result<Option<SocketAddr>> {
    if text.eq_ignore_ascii_case("off") {
        return Ok(None);
    }
    let address = text
        .parse()
        .with_context(|| format!("reading the panel's address {text:?}, such as 127.0.0.1:8081"))?;
    Ok(Some(address))
}

pub(super) fn parse_joints(text: &str) -> anyhow::Result<PendantJoints> {
    let values: Vec<f64> = text
        .split(',')
        .map(|part| {
            part.trim()
                .parse()
                .with_context(|| format!("{part:?} is not an angle"))
        })
        .collect::<Result<_, _>>()?;
    let Ok(joints) = <[f64; 6]>::try_from(values) else {
        bail!("{text:?} are not six joints in degrees, separated by commas");
    };
    PendantJoints::try_from_degrees(joints).context("reading the home joints")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_scales_are_numbers_up_to_a_thousand_or_max() {
        for good in ["1", "0.5", "1000", "max"] {
            assert!(parse_clock(good).is_ok(), "{good}");
        }
        for wrong in ["0", "-1", "1001", "nan", "fast", ""] {
            assert!(parse_clock(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn port_maps_are_two_ports() {
        assert_eq!(parse_port_map("59002=0"), Ok((59002, 0)));
        assert_eq!(parse_port_map("1=2"), Ok((1, 2)));
        for wrong in ["59002", "0=1", "a=1", "1=b", "70000=1", "="] {
            assert!(parse_port_map(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn an_interpolation_period_is_1_to_64_ms() {
        assert_eq!(parse_period("4").unwrap().millis().to_string(), "4");
        for wrong in ["0", "65", "-8", "8.5", "ms", ""] {
            assert!(parse_period(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn joints_are_six_finite_angles() {
        assert!(parse_joints("0,0,0,0,-90,0").is_ok());
        for wrong in ["0,0", "0,0,0,0,0,x", "0,0,0,0,0,nan", ""] {
            assert!(parse_joints(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_panel_is_an_address_or_off() {
        assert_eq!(parse_panel("OFF").unwrap(), None);
        assert!(parse_panel("127.0.0.1:0").unwrap().is_some());
        assert!(parse_panel("nowhere").is_err());
    }
}
