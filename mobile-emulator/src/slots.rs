//! The load slots, and what lies in them.

use api::SlotLoadBody;

use crate::error::{Refusal, id};

/// Slots in the order of the configuration. A load is in one slot, and a slot holds one load.
#[derive(Clone, Debug, Default)]
pub(crate) struct Slots(Vec<SlotLoadBody>);

impl Slots {
    pub(crate) fn new(slots: Vec<SlotLoadBody>) -> Self {
        Self(slots)
    }

    pub(crate) fn list(&self) -> &[SlotLoadBody] {
        &self.0
    }

    /// Puts a load into an empty slot.
    pub(crate) fn put(&mut self, slot: &str, load: &str) -> Result<(), Refusal> {
        let load = id("load", load)?;
        let _found = self.find(slot)?;
        if let Some(elsewhere) = self.0.iter().find(|one| one.load.as_deref() == Some(load)) {
            return Err(Refusal::LoadElsewhere {
                load: load.to_owned(),
                slot: elsewhere.slot.clone(),
            });
        }
        let found = self.find(slot)?;
        if let Some(load) = &found.load {
            return Err(Refusal::SlotTaken {
                slot: slot.to_owned(),
                load: load.clone(),
            });
        }
        found.load = Some(load.to_owned());
        Ok(())
    }

    /// Takes what lies in a slot.
    pub(crate) fn take(&mut self, slot: &str) -> Result<String, Refusal> {
        self.find(slot)?.load.take().ok_or(Refusal::SlotEmpty {
            slot: slot.to_owned(),
        })
    }

    /// Whether there is such a slot.
    pub(crate) fn check(&mut self, slot: &str) -> Result<(), Refusal> {
        self.find(slot).map(drop)
    }

    fn find(&mut self, slot: &str) -> Result<&mut SlotLoadBody, Refusal> {
        let known: Vec<&str> = self.0.iter().map(|one| one.slot.as_str()).collect();
        let unknown = Refusal::UnknownSlot {
            slot: slot.chars().take(80).collect(),
            known: known.join(", "),
        };
        self.0
            .iter_mut()
            .find(|one| one.slot == slot)
            .ok_or(unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two() -> Slots {
        Slots::new(
            ["a", "b"]
                .map(|slot| SlotLoadBody {
                    slot: slot.to_owned(),
                    load: None,
                })
                .to_vec(),
        )
    }

    #[test]
    fn a_load_is_in_one_slot_and_a_slot_holds_one_load() {
        let mut slots = two();
        slots.put("a", "box").unwrap();
        assert!(matches!(
            slots.put("b", "box"),
            Err(Refusal::LoadElsewhere { .. })
        ));
        assert!(matches!(
            slots.put("a", "other"),
            Err(Refusal::SlotTaken { .. })
        ));
        assert_eq!(slots.take("a").unwrap(), "box");
        assert!(matches!(slots.take("a"), Err(Refusal::SlotEmpty { .. })));
        slots.put("b", "box").unwrap();
    }

    #[test]
    fn an_unknown_slot_is_named_with_those_that_are() {
        let refused = two().put("c", "box").unwrap_err().to_string();
        assert_eq!(refused, "there is no slot `c`; there are: a, b");
    }
}
