use workflow::{Cell, Holder, Resource as Claimed};

use crate::setup::Resource;

/// What of the cell's work keeps a part of the set-up as it is: nobody moves a pose, a zone or a tool under an arm that
/// works with it.
pub(super) fn in_use(cell: &Cell, part: &Resource) -> Option<String> {
    let claims = cell.claims();
    let claim = claims.iter().find(|claim| keeps(&claim.resource, part))?;
    let (Holder::Job(id) | Holder::Session(id)) = claim.by;
    let by = match claim.by {
        Holder::Job(_) => "job",
        Holder::Session(_) => "session",
    };
    Some(match &claim.resource {
        Claimed::Arm(arm) => format!("{by} {id} works with arm `{arm}`"),
        Claimed::Point(point) => format!("{by} {id} has point `{point}`"),
        Claimed::Place(place) => format!("{by} {id} has place `{place}`"),
        Claimed::MobileRobot(robot) => format!("{by} {id} has mobile robot `{robot}`"),
        Claimed::Load(load) => format!("{by} {id} has load `{load}`"),
    })
}

fn keeps(claimed: &Claimed, part: &Resource) -> bool {
    match part {
        Resource::Arm(arm) | Resource::Tool { arm, .. } | Resource::TaughtPose { arm, .. } => {
            matches!(claimed, Claimed::Arm(id) if id == arm)
        }
        // A zone is in the way of every arm.
        Resource::Zone(_) => matches!(claimed, Claimed::Arm(_)),
        Resource::Station(station) => matches!(claimed, Claimed::Point(point)
            if point.split_once('/').is_some_and(|(id, _)| id == station)),
        Resource::Place(place) => matches!(claimed, Claimed::Place(id) if id == place),
        Resource::MobileRobot(robot) => matches!(claimed, Claimed::MobileRobot(id) if id == robot),
        Resource::Load(load) => matches!(claimed, Claimed::Load(id) if id == load),
        // Asked about when a step begins, and no step is undone by another answer.
        Resource::Header
        | Resource::Timers
        | Resource::Destination(_)
        | Resource::Route(_)
        | Resource::Trigger(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_job_has_is_kept_as_it_is_and_nothing_else() {
        let arm = Claimed::Arm("r1".into());
        let pose = |arm: &str| Resource::TaughtPose {
            arm: arm.into(),
            place: "rack/a".into(),
        };
        let tool = Resource::Tool {
            arm: "r1".into(),
            number: 1,
        };
        for (claimed, part, kept) in [
            (&arm, Resource::Arm("r1".into()), true),
            (&arm, Resource::Arm("r2".into()), false),
            (&arm, tool, true),
            (&arm, pose("r1"), true),
            (&arm, pose("r2"), false),
            (&arm, Resource::Zone("door".into()), true),
            (&arm, Resource::Timers, false),
            (
                &Claimed::Point("dock/left".into()),
                Resource::Station("dock".into()),
                true,
            ),
            (
                &Claimed::Point("dock/left".into()),
                Resource::Station("doc".into()),
                false,
            ),
            (
                &Claimed::Place("rack/a".into()),
                Resource::Place("rack/a".into()),
                true,
            ),
        ] {
            assert_eq!(keeps(claimed, &part), kept, "{claimed:?} {part}");
        }
        let idle = Cell::new(workflow::Setup::default());
        assert_eq!(in_use(&idle, &pose("r1")), None);
    }
}
