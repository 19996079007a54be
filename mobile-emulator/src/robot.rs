//! The handle of a running robot.

use std::net::{SocketAddr, TcpListener as StdListener};
use std::time::Duration;

use api::{FloorPoseBody, OutboxMessage, SlotLoadBody};
use jiff::Timestamp;
use tokio::sync::{mpsc, oneshot, watch};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::cell::CellAddress;
use crate::clock::Clock;
use crate::config::{MobileConfig, ViewSection};
use crate::core::Core;
use crate::driver::{Command, Driver, Lines};
use crate::error::{Refusal, RobotStopped, StartError};
use crate::fault::Fault;
use crate::ledger::LedgerEntry;
use crate::state::State;
use crate::view;

/// How long a shutdown waits for clients of the view.
const SHUTDOWN: Duration = Duration::from_secs(2);

/// A virtual mobile robot that runs in tasks of its own. Dropping it stops it without waiting.
#[derive(Debug)]
pub struct MobileRobot {
    id: String,
    lines: Lines,
    view: Option<SocketAddr>,
    stop: CancellationToken,
    tracker: TaskTracker,
}

impl MobileRobot {
    /// Checks the configuration, opens the view, and switches the robot on.
    ///
    /// # Errors
    /// A key that does not fit, or an address that cannot be opened; nothing runs then.
    ///
    /// # Panics
    /// Outside of a tokio runtime with I/O and time.
    pub fn start(
        config: &MobileConfig,
        clock: Clock,
        cell: &CellAddress,
    ) -> Result<Self, StartError> {
        let epoch = if clock.is_stepped() {
            // The same history each time, down to the time stamps.
            Timestamp::constant(1_767_225_600, 0)
        } else {
            Timestamp::now()
        };
        let by_clock = if clock.is_stepped() {
            1
        } else {
            u64::try_from(epoch.as_second()).unwrap_or(1)
        };
        let core = Core::try_new(config, epoch, config.boot.unwrap_or(by_clock))?;
        let view = config.view.as_ref().map(open_view).transpose()?;
        let stop = CancellationToken::new();
        let tracker = TaskTracker::new();
        let robot = cell.robot(&config.id);
        let (driver, lines) =
            Driver::prepare(core, clock, robot, config.link.clone(), stop.clone());
        let view = view.map(|(listener, address)| {
            let exposed = !address.ip().is_loopback();
            let served = view::serve(
                listener,
                lines.commands.clone(),
                exposed,
                stop.clone(),
                tracker.clone(),
            );
            let _task = tracker.spawn(served);
            address
        });
        let _task = tracker.spawn(driver.run(tracker.clone()));
        Ok(Self {
            id: config.id.clone(),
            lines,
            view,
            stop,
            tracker,
        })
    }

    /// The robot's id.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Where its page and state view are.
    #[must_use]
    pub fn view_address(&self) -> Option<SocketAddr> {
        self.view
    }

    /// A snapshot.
    ///
    /// # Errors
    /// The robot stopped.
    pub async fn state(&self) -> Result<State, RobotStopped> {
        self.ask(Command::State).await
    }

    /// Snapshots as they come.
    #[must_use]
    pub fn subscribe(&self) -> watch::Receiver<State> {
        self.lines.state.clone()
    }

    /// The whole ledger that is kept, oldest first.
    ///
    /// # Errors
    /// The robot stopped.
    pub async fn ledger(&self) -> Result<Vec<LedgerEntry>, RobotStopped> {
        self.ledger_after(0).await
    }

    /// Ledger entries above a number, oldest first.
    ///
    /// # Errors
    /// The robot stopped.
    pub async fn ledger_after(&self, after: u64) -> Result<Vec<LedgerEntry>, RobotStopped> {
        let page = self.ask(|answer| Command::Ledger { after, answer }).await?;
        Ok(page.entries)
    }

    /// Where it truly is, whatever it tells.
    ///
    /// # Errors
    /// The robot stopped.
    pub async fn pose(&self) -> Result<FloorPoseBody, RobotStopped> {
        Ok(self.state().await?.pose)
    }

    /// What truly lies in its slots, in the order of the configuration.
    ///
    /// # Errors
    /// The robot stopped.
    pub async fn slots(&self) -> Result<Vec<SlotLoadBody>, RobotStopped> {
        Ok(self.state().await?.slots)
    }

    /// Puts a load into an empty slot, as an arm does. The robot tells `LOAD_CHANGED`.
    ///
    /// # Errors
    /// No such slot, a slot that is taken, a load that lies in another one, an id that is none; or it stopped.
    pub async fn put(&self, slot: &str, load: &str) -> Result<(), Refusal> {
        let (slot, load) = (slot.to_owned(), load.to_owned());
        self.ask(|answer| Command::Put { slot, load, answer })
            .await?
    }

    /// Takes the load that lies in a slot, as an arm does. The robot tells `LOAD_CHANGED`.
    ///
    /// # Errors
    /// No such slot, or an empty one; or it stopped.
    pub async fn take(&self, slot: &str) -> Result<String, Refusal> {
        let slot = slot.to_owned();
        self.ask(|answer| Command::Take { slot, answer }).await?
    }

    /// Sends it up to a point of its map, without an order of the cell. There it tells `MR_ARRIVED`.
    ///
    /// # Errors
    /// It works on an order, does not know the point or a way there, has no power; or it stopped.
    pub async fn visit(&self, point: &str) -> Result<(), Refusal> {
        let point = point.to_owned();
        self.ask(|answer| Command::Visit { point, answer }).await?
    }

    /// Makes something go wrong. The number of the fault; 0 if it already happened.
    ///
    /// # Errors
    /// A value out of its range, too many faults, a slot that does not fit; or it stopped.
    pub async fn set_fault(&self, fault: Fault) -> Result<u64, Refusal> {
        self.ask(|answer| Command::SetFault { fault, answer })
            .await?
    }

    /// Ends all faults that last or wait for their moment. How many there were.
    ///
    /// # Errors
    /// The robot stopped.
    pub async fn clear_faults(&self) -> Result<usize, RobotStopped> {
        self.ask(Command::ClearFaults).await
    }

    /// Hands it a message, as the cell's push does.
    ///
    /// # Errors
    /// Not the next message of a robot that also polls; no power; or it stopped.
    pub async fn push(&self, message: OutboxMessage) -> Result<(), Refusal> {
        let message = Box::new(message);
        self.ask(|answer| Command::Push { message, answer }).await?
    }

    /// Stops the robot and waits until its view is closed.
    pub async fn shutdown(self) {
        self.stop.cancel();
        let _first = self.tracker.close();
        if tokio::time::timeout(SHUTDOWN, self.tracker.wait())
            .await
            .is_err()
        {
            tracing::warn!(
                "A client of the view holds its connection, the robot stops without it."
            );
        }
    }

    async fn ask<T>(
        &self,
        command: impl FnOnce(oneshot::Sender<T>) -> Command,
    ) -> Result<T, RobotStopped> {
        ask(&self.lines.commands, command).await
    }
}

impl Drop for MobileRobot {
    fn drop(&mut self) {
        self.stop.cancel();
    }
}

/// Puts a question to the driver and waits for the answer.
pub(crate) async fn ask<T>(
    commands: &mpsc::Sender<Command>,
    command: impl FnOnce(oneshot::Sender<T>) -> Command,
) -> Result<T, RobotStopped> {
    let (sender, answer) = oneshot::channel();
    commands
        .send(command(sender))
        .await
        .map_err(|_| RobotStopped)?;
    answer.await.map_err(|_| RobotStopped)
}

fn open_view(section: &ViewSection) -> Result<(tokio::net::TcpListener, SocketAddr), StartError> {
    let address = section.address;
    if !address.ip().is_loopback() {
        if !section.expose_to_network {
            return Err(StartError::NotLoopback { ip: address.ip() });
        }
        tracing::warn!(
            %address,
            "The view can be reached from other machines. Anybody who connects can change the robot.",
        );
    }
    let open = || {
        let listener = StdListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let address = listener.local_addr()?;
        Ok((listener, address))
    };
    open().map_err(|source| StartError::View { address, source })
}
