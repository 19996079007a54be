//! The handle of a running controller.

use std::net::{SocketAddr, TcpListener as StdListener};
use std::time::Duration;

use tokio::sync::{mpsc, oneshot, watch};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::alarms::{Alarm, Severity};
use crate::clock::Clock;
use crate::config::{ControlAccess, ControllerConfig, Exposure};
use crate::controller::{CmosMemory, Controller, OperateError, Operation};
use crate::driver::{Command, Driver, Lines, Visit};
use crate::error::{ControllerStopped, StartError};
use crate::faults::{FaultBody, FaultError};
use crate::hardware::operator::OperatingMode;
use crate::labels::PeerLabels;
use crate::ledger::LedgerEntry;
use crate::panel;
use crate::ports::SetInputError;
use crate::state::State;

/// How long a shutdown waits for clients of the panel.
const SHUTDOWN: Duration = Duration::from_secs(2);

/// A virtual controller that runs in tasks of its own. Dropping it stops it without waiting.
#[derive(Debug)]
pub struct VirtualController {
    lines: Lines,
    panel: Option<SocketAddr>,
    stop: CancellationToken,
    tracker: TaskTracker,
}

impl VirtualController {
    /// Loads the programs, reserves the ports, opens the panel, and switches the controller on.
    ///
    /// # Errors
    /// Anything that is wrong with the configuration, a program, or a port; nothing runs then.
    ///
    /// # Panics
    /// Outside of a tokio runtime with I/O and time.
    pub fn start(
        config: &ControllerConfig,
        clock: Clock,
        labels: PeerLabels,
    ) -> Result<Self, StartError> {
        check_exposure(config)?;
        let stop = CancellationToken::new();
        let tracker = TaskTracker::new();
        let (driver, lines) =
            Driver::prepare(config, clock, labels, tracker.clone(), stop.clone())?;
        let panel = config.panel.map(open_panel).transpose()?;
        let panel = match panel {
            None => None,
            Some((listener, address)) => {
                let served = panel::serve(
                    listener,
                    panel::Visitors {
                        commands: lines.commands.clone(),
                        states: lines.state.clone(),
                        access: config.control,
                    },
                    stop.clone(),
                    tracker.clone(),
                );
                let _task = tracker.spawn(served);
                Some(address)
            }
        };
        let _task = tracker.spawn(driver.run());
        let _first = tracker.close();
        Ok(Self {
            lines,
            panel,
            stop,
            tracker,
        })
    }

    /// Where a port of the program is on this machine. Waits until a program has opened it.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn address_of_port(&self, port: u16) -> Result<SocketAddr, ControllerStopped> {
        let mut addresses = self.lines.addresses.clone();
        let found = addresses
            .wait_for(|addresses| addresses.contains_key(&port))
            .await;
        found
            .ok()
            .and_then(|addresses| addresses.get(&port).copied())
            .ok_or(ControllerStopped)
    }

    /// Why a port that a program wants cannot be opened. Waits until that happens.
    ///
    /// The program sees a failed `MSG_CONNECT` and may try again. A port of the port map cannot fail so: it is
    /// reserved at the start.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn port_failure(&self) -> Result<String, ControllerStopped> {
        let mut failure = self.lines.port_failure.clone();
        let reason = failure.wait_for(Option::is_some).await;
        reason
            .ok()
            .and_then(|reason| reason.clone())
            .ok_or(ControllerStopped)
    }

    /// Where the panel is.
    #[must_use]
    pub fn panel_address(&self) -> Option<SocketAddr> {
        self.panel
    }

    /// The panel's routes, for a server of the caller's own or for none at all. It answers only who asks with a loopback
    /// name as `Host`.
    pub fn panel_router(&self, access: ControlAccess) -> axum::Router {
        panel::router(panel::Visitors {
            commands: self.lines.commands.clone(),
            states: self.lines.state.clone(),
            access,
        })
    }

    /// A snapshot.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn state(&self) -> Result<State, ControllerStopped> {
        self.ask(Command::State).await
    }

    /// The whole ledger that is kept, oldest first.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn ledger(&self) -> Result<Vec<LedgerEntry>, ControllerStopped> {
        self.ledger_after(0).await
    }

    /// Ledger entries above a number, oldest first.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn ledger_after(&self, after: u64) -> Result<Vec<LedgerEntry>, ControllerStopped> {
        let page = self.ask(|answer| Command::Ledger { after, answer }).await?;
        Ok(page.entries)
    }

    /// The alarms, oldest first.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn alarms(&self) -> Result<Vec<Alarm>, ControllerStopped> {
        Ok(self.ask(Command::Alarms).await?.entries)
    }

    /// The last lines of the pendant's USER screen.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn screen(&self) -> Result<Vec<String>, ControllerStopped> {
        self.ask(Command::Screen).await
    }

    /// The registers: `R[n]`, `SR[n]`, `PR[n]`.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn registers(&self) -> Result<karel::Registers, ControllerStopped> {
        self.ask(Command::Registers).await
    }

    /// Sets an input, as the world outside does.
    ///
    /// # Errors
    /// Not an input, no such port, a value that it cannot have, or the controller stopped.
    pub async fn set_input(
        &self,
        port: karel::Port,
        number: u16,
        value: karel::PortValue,
    ) -> Result<(), SetInputError> {
        self.ask(|answer| Command::SetInput {
            port,
            number,
            value,
            answer,
        })
        .await?
    }

    /// ABORT ALL: every task ends, the arm brakes, connections close.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn abort_all(&self) -> Result<(), ControllerStopped> {
        self.ask(Command::AbortAll).await
    }

    /// Switches the power off and on: connections end, the arm brakes, programs start anew.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn power_cycle(&self, memory: CmosMemory) -> Result<(), ControllerStopped> {
        self.ask(|answer| Command::PowerCycle { memory, answer })
            .await
    }

    /// RESET: no alarm is active any more.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn reset(&self) -> Result<(), ControllerStopped> {
        let operation = Operation::Reset;
        // Nothing can be wrong with a RESET.
        let _done = self
            .ask(|answer| Command::Operate { operation, answer })
            .await?;
        Ok(())
    }

    /// Does what an operator does, or breaks something.
    ///
    /// # Errors
    /// What is asked for is not possible now, nothing has changed; or the controller stopped.
    pub async fn operate(&self, operation: Operation) -> Result<(), OperateError> {
        self.ask(|answer| Command::Operate { operation, answer })
            .await?
    }

    /// Turns the mode switch; leaving AUTO pauses what moves.
    ///
    /// # Errors
    /// The controller stopped; so with the others that cannot be refused.
    pub async fn set_mode(&self, mode: OperatingMode) -> Result<(), OperateError> {
        self.operate(Operation::SetMode(mode)).await
    }

    /// Enables or disables the teach pendant; enabling it pauses what moves.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn set_pendant(&self, enabled: bool) -> Result<(), OperateError> {
        self.operate(Operation::SetPendant(enabled)).await
    }

    /// Presses or releases the emergency stop; after the release, a [`Self::reset`] is due.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn emergency_stop(&self, pressed: bool) -> Result<(), OperateError> {
        self.operate(Operation::EmergencyStop(pressed)).await
    }

    /// HOLD: the arm brakes on its path and waits.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn hold(&self) -> Result<(), OperateError> {
        self.operate(Operation::Hold).await
    }

    /// CYCLE START: what is paused goes on.
    ///
    /// # Errors
    /// An alarm, the mode or the pendant forbids it; or the controller stopped.
    pub async fn cycle_start(&self) -> Result<(), OperateError> {
        self.operate(Operation::CycleStart).await
    }

    /// Raises an alarm such as `SRVO`, 50.
    ///
    /// # Errors
    /// No such facility, a number above 999, or the controller stopped.
    pub async fn raise_alarm(
        &self,
        facility: &str,
        number: u16,
        severity: Severity,
    ) -> Result<(), OperateError> {
        let (facility, text) = (facility.to_owned(), "Raised from outside".to_owned());
        self.operate(Operation::RaiseAlarm {
            facility,
            number,
            text,
            severity,
        })
        .await
    }

    /// Sets the general override, 0 to 100 percent.
    ///
    /// # Errors
    /// No percentage, or the controller stopped.
    pub async fn set_override(&self, percent: i32) -> Result<(), OperateError> {
        self.operate(Operation::SetOverride(percent)).await
    }

    /// Lets `visitor` look at the controller, or change something, between two moments: variables, registers, ports,
    /// tasks, faults, the trace.
    ///
    /// # Errors
    /// The controller stopped.
    pub async fn with<T: Send + 'static>(
        &self,
        visitor: impl FnOnce(&mut Controller) -> T + Send + 'static,
    ) -> Result<T, ControllerStopped> {
        visit(&self.lines.commands, |driver| visitor(&mut driver.core)).await
    }

    /// Injects a fault; its number.
    ///
    /// # Errors
    /// What is wrong with it, nothing has changed; or the controller stopped.
    pub async fn inject(&self, fault: FaultBody) -> Result<u64, FaultError> {
        self.with(|core| core.inject(fault)).await?
    }

    /// Snapshots as they come: at each event of the controller, not at each moment of a motion.
    #[must_use]
    pub fn subscribe(&self) -> watch::Receiver<State> {
        self.lines.state.clone()
    }

    /// Stops the controller and waits until its ports are closed.
    pub async fn shutdown(self) {
        self.stop.cancel();
        if tokio::time::timeout(SHUTDOWN, self.tracker.wait())
            .await
            .is_err()
        {
            tracing::warn!(
                "A client of the panel holds its connection, the controller stops without it."
            );
        }
    }

    async fn ask<T>(
        &self,
        command: impl FnOnce(oneshot::Sender<T>) -> Command,
    ) -> Result<T, ControllerStopped> {
        ask(&self.lines.commands, command).await
    }
}

impl Drop for VirtualController {
    fn drop(&mut self) {
        self.stop.cancel();
    }
}

/// Lets `visitor` look at the driver, or change something, between two moments.
pub(crate) async fn visit<T: Send + 'static>(
    commands: &mpsc::Sender<Command>,
    visitor: impl FnOnce(&mut Driver) -> T + Send + 'static,
) -> Result<T, ControllerStopped> {
    ask(commands, |answer| {
        Command::Visit(Visit(Box::new(move |driver| {
            // Whoever asked may have gone.
            let _gone = answer.send(visitor(driver)).map_err(drop);
        })))
    })
    .await
}

/// Puts a question to the driver and waits for the answer.
pub(crate) async fn ask<T>(
    commands: &mpsc::Sender<Command>,
    command: impl FnOnce(oneshot::Sender<T>) -> Command,
) -> Result<T, ControllerStopped> {
    let (sender, answer) = oneshot::channel();
    commands
        .send(command(sender))
        .await
        .map_err(|_| ControllerStopped)?;
    answer.await.map_err(|_| ControllerStopped)
}

fn check_exposure(config: &ControllerConfig) -> Result<(), StartError> {
    if let Some(panel) = config.panel
        && !panel.ip().is_loopback()
    {
        return Err(StartError::NotLoopback { ip: panel.ip() });
    }
    if config.ip.is_loopback() {
        return Ok(());
    }
    match config.exposure {
        Exposure::Loopback => Err(StartError::NotLoopback { ip: config.ip }),
        Exposure::AnyAddress => {
            tracing::warn!(
                controller = %config.name, ip = %config.ip,
                "The controller can be reached from other machines. It moves the arm for anybody who connects.",
            );
            Ok(())
        }
    }
}

fn open_panel(address: SocketAddr) -> Result<(tokio::net::TcpListener, SocketAddr), StartError> {
    let open = || {
        let listener = StdListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let address = listener.local_addr()?;
        Ok((listener, address))
    };
    open().map_err(|source| StartError::Panel { address, source })
}
