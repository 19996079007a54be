//! Resource claims: all or none, always in the same order.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use uuid::Uuid;

/// Something only one job can use. The order of the variants is the order of claiming.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(tag = "resource", content = "id", rename_all = "snake_case")]
pub enum Resource {
    /// A load handling point.
    Point(String),
    /// An arm.
    Arm(String),
    /// A fixed place.
    Place(String),
    /// A mobile robot.
    MobileRobot(String),
    /// A load.
    Load(String),
}

/// Who has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(tag = "holder", content = "id", rename_all = "snake_case")]
pub enum Holder {
    /// A job.
    Job(Uuid),
    /// A session: a point stays occupied while the mobile robot is there, even if the job is over.
    Session(Uuid),
}

/// Who has what.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Vec<(Resource, Holder)>", into = "Vec<(Resource, Holder)>")]
pub(crate) struct Claims(pub BTreeMap<Resource, Holder>);

impl From<Vec<(Resource, Holder)>> for Claims {
    fn from(all: Vec<(Resource, Holder)>) -> Self {
        Self(all.into_iter().collect())
    }
}

impl From<Claims> for Vec<(Resource, Holder)> {
    fn from(Claims(all): Claims) -> Self {
        all.into_iter().collect()
    }
}

impl Claims {
    pub(crate) fn is_free(&self, resource: &Resource) -> bool {
        !self.0.contains_key(resource)
    }

    pub(crate) fn claim(&mut self, by: Holder, resources: &[Resource]) {
        for resource in resources {
            let _before = self.0.insert(resource.clone(), by);
        }
    }

    pub(crate) fn release(&mut self, by: Holder, resources: Option<&[Resource]>) {
        self.0.retain(|resource, holder| {
            *holder != by || resources.is_some_and(|some| !some.contains(resource))
        });
    }
}
