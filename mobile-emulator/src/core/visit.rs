//! Driving to a point without an order: somebody else sent it there, or it came by itself.

use super::Core;
use crate::error::Refusal;
use crate::floor::before;
use crate::ledger::Purpose;
use crate::motion::Manner;
use crate::route;

impl Core {
    /// Drives up to a point of its map and tells `MR_ARRIVED` there. It does not enter the point's zone.
    pub(crate) fn visit(&mut self, point: &str) -> Result<(), Refusal> {
        let no = |reason: String| Refusal::NoVisit {
            point: point.chars().take(80).collect(),
            reason,
        };
        if self.down_until.is_some() {
            return Err(Refusal::Down);
        }
        if let Some(mission) = &self.mission {
            return Err(no(format!("it works on order {}", mission.order.order)));
        }
        let Some(place) = self.plan.places.get(point) else {
            return Err(no("it is not on the robot's map".to_owned()));
        };
        let from = self.motion.believed();
        let to = before(place.pose, from, self.plan.standoff_mm);
        self.at_point = None;
        let legs = route::legs(&self.plan, from, &[], to).map_err(no)?;
        self.set_out(legs, to, Purpose::Visit, Manner::Driving)
            .map_err(no)?;
        self.visits = Some(point.to_owned());
        self.pump();
        Ok(())
    }
}
