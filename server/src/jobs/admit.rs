//! Whether the ways of a new job may be gone: no approach and no retreat leads through a keep-out zone, through the
//! hand-over zone of another place, or out of the arm's work area.

use api::{ProblemCode, Violation};
use workflow::{NewJob, PlaceRef};

use crate::problem::Problem;
use crate::setup::SetupBook;
use crate::setup::ways::ForbiddenWay;
use crate::wire_bodies::shown;

/// Refuses a job none of whose arms may go where it would have to.
///
/// What is not in the set-up, not taught, or out of reach is said elsewhere.
///
/// # Errors
/// `zone-violation` with every place whose ways lead where they may not.
pub(crate) async fn admit(setup: &SetupBook, job: &NewJob) -> Result<(), Problem> {
    let kept = setup.current();
    let Some(point) = kept.setup.point(&job.point) else {
        return Ok(());
    };
    let places = places_of(job);
    let named = |arm: &&String| job.arm.as_ref().is_none_or(|named| named == *arm);
    let mut forbidden = Vec::new();
    for arm in point.arms.iter().filter(named) {
        let taught = |place: &PlaceRef| kept.setup.taught_at(arm, place);
        if places
            .iter()
            .any(|place| place.must_be && taught(&place.place).is_none())
        {
            continue;
        }
        let known: Vec<_> = places
            .iter()
            .filter_map(|place| Some((&place.item, taught(&place.place)?)))
            .collect();
        let indices = known.iter().map(|(_, index)| *index).collect();
        kept.look_at_ways(indices).await;
        let found: Vec<_> = known
            .iter()
            .filter_map(|(item, index)| {
                let way = kept.forbidden_way(*index)?;
                let place = &kept.setup.taught.get(*index)?.place;
                Some(violation(item, arm, place, way))
            })
            .collect();
        if found.is_empty() {
            return Ok(());
        }
        forbidden.extend(found);
    }
    let Some(first) = forbidden.first() else {
        return Ok(());
    };
    let detail = format!("{}: {}", first.item, first.message);
    Err(
        Problem::not_sent(ProblemCode::ZoneViolation, detail)
            .violations(forbidden)
            .hint("`cellctl cell check` looks at every taught pose; another approach, or another place, may lead around it."),
    )
}

/// A place that a job goes to.
struct Goal {
    /// Where in the body it is named.
    item: String,
    place: PlaceRef,
    /// An alternate need not be taught.
    must_be: bool,
}

fn places_of(job: &NewJob) -> Vec<Goal> {
    let mut places = Vec::new();
    for (index, item) in job.items.iter().enumerate() {
        let mut goes_to = |field: &str, place, must_be| {
            let item = format!("params.items[{index}].{field}");
            places.push(Goal {
                item,
                place,
                must_be,
            });
        };
        let slot = PlaceRef::MobileRobot {
            point: job.point.clone(),
            slot: item.mr_slot.clone(),
        };
        goes_to("mr_slot", slot, true);
        goes_to("place", PlaceRef::fixed(item.place.clone()), true);
        for (number, other) in item.alternates.iter().enumerate() {
            let field = format!("alternates[{number}]");
            goes_to(&field, PlaceRef::fixed(other.clone()), false);
        }
    }
    places
}

/// How far outside of what is allowed, in millimeters: at least 0 would be.
fn violation(item: &str, arm: &str, place: &str, way: &ForbiddenWay) -> Violation {
    Violation {
        item: item.to_owned(),
        message: format!("{arm} at `{place}`: {way}"),
        value: Some(shown(way.zone.at.gap.0)),
        min: Some(0.0),
        ..Violation::default()
    }
}
