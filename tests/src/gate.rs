use tokio::sync::watch;

/// Holds tasks back until the test opens it. Clones are the same gate; once open it stays open.
#[derive(Clone, Debug)]
pub struct Gate(watch::Sender<bool>);

impl Gate {
    /// A closed gate.
    #[must_use]
    pub fn new() -> Self {
        Self(watch::Sender::new(false))
    }

    /// Lets everyone pass, now and later.
    pub fn open(&self) {
        let _ = self.0.send_replace(true);
    }

    /// Waits until the gate is open.
    pub async fn pass(&self) {
        let mut state = self.0.subscribe();
        // This gate holds a sender itself, so the channel cannot close.
        let _ = state.wait_for(|open| *open).await;
    }
}

impl Default for Gate {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn an_open_gate_stays_open_for_every_clone() {
        let gate = Gate::new();
        let other = gate.clone();
        let waiting = tokio::spawn(async move { other.pass().await });
        gate.open();
        waiting.await.unwrap();
        gate.pass().await;
    }
}
