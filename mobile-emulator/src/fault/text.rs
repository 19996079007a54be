//! A fault as JSON: flat, with errors that name the key that does not fit.

use serde::de::Error as _;
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value};
use serde_path_to_error::Track;

use super::Fault;

/// The key that names the fault.
const TAG: &str = "fault";

/// Serde's internal tag forgets which key did not fit; here an error names it.
impl<'de> Deserialize<'de> for Fault {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut keys = Map::deserialize(deserializer)?;
        let Some(Value::String(name)) = keys.remove(TAG) else {
            return Err(D::Error::custom(
                "fault: missing, or no text; it names the fault, e.g. \"LATE\"",
            ));
        };
        let nested = Value::Object(Map::from_iter([(name.clone(), Value::Object(keys))]));
        let mut track = Track::new();
        let tracked = serde_path_to_error::Deserializer::new(nested, &mut track);
        Fault::deserialize(tracked).map_err(|error| {
            let path = track.path().to_string();
            match path
                .strip_prefix(&name)
                .and_then(|key| key.strip_prefix('.'))
            {
                Some(key) => D::Error::custom(format!("{key}: {error}")),
                None => match error.to_string().strip_prefix("unknown variant ") {
                    Some(known) => D::Error::custom(format!("{TAG}: there is no {known}")),
                    None => D::Error::custom(error),
                },
            }
        })
    }
}

impl Serialize for Fault {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let nested = Fault::serialize(self, serde_json::value::Serializer);
        let Value::Object(nested) = nested.map_err(S::Error::custom)? else {
            return Err(S::Error::custom("a fault is an object"));
        };
        let mut flat = Map::new();
        for (name, keys) in nested {
            let _first = flat.insert(TAG.to_owned(), Value::String(name));
            if let Value::Object(keys) = keys {
                flat.extend(keys);
            }
        }
        flat.serialize(serializer)
    }
}
