//! A controller whose time is in our hands, and clients that never wait for ever.

use std::net::SocketAddr;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context as _, Result, anyhow, bail};
use karel_emulator::alarms::Alarm;
use karel_emulator::controller::ValueBody;
use karel_emulator::{
    Clock, ControlAccess, Controller, ControllerConfig, PeerLabels, ProgramSource, State, Stepper,
    VirtualController,
};
use kinematics::ArmModel;
use tokio::io::AsyncWriteExt as _;
use tokio::net::TcpStream;

/// Longer than any observation takes; reached only when something is broken.
const PATIENCE: Duration = Duration::from_mins(1);

/// Controller time that passes at once while a client is waited for.
const STEP: Duration = Duration::from_millis(16);

/// A driver's files: programs, and everything that they may include.
#[derive(Debug, Default, Clone)]
pub(crate) struct Files {
    pub(crate) programs: Vec<ProgramSource>,
    pub(crate) includes: Vec<ProgramSource>,
}

impl Files {
    /// `folder` has these programs; its other sources, and those of its folders, may be included.
    pub(crate) fn read(folder: &Path, programs: &[&str]) -> Result<Self> {
        let mut files = Self::default();
        for name in programs {
            let path = folder.join(name);
            let text =
                std::fs::read(&path).with_context(|| format!("reading {}", path.display()))?;
            files.programs.push(ProgramSource::new(*name, text));
        }
        files.include(folder, "")?;
        Ok(files)
    }

    fn include(&mut self, folder: &Path, prefix: &str) -> Result<()> {
        let reading = || format!("reading {}", folder.display());
        for entry in std::fs::read_dir(folder).with_context(reading)? {
            let entry = entry.with_context(reading)?;
            let name = entry.file_name().to_string_lossy().to_ascii_lowercase();
            let path = entry.path();
            if path.is_dir() && prefix.is_empty() {
                self.include(&path, &format!("{name}/"))?;
            } else if path
                .extension()
                .is_some_and(|end| end.eq_ignore_ascii_case("kl"))
            {
                let text = std::fs::read(&path).with_context(reading)?;
                let name = format!("{prefix}{name}");
                self.includes.push(ProgramSource::new(name, text));
            }
        }
        Ok(())
    }

    /// Appends what `other` has.
    pub(crate) fn and(mut self, other: Self) -> Self {
        self.programs.extend(other.programs);
        self.includes.extend(other.includes);
        self
    }

    /// A controller with them; each of `ports` on any free port.
    pub(crate) fn controller(&self, run: &[&str], ports: &[u16]) -> Result<ControllerConfig> {
        let model = ArmModel::builtin("fanuc-m20ia").context("there is no such arm")?;
        let mut config = ControllerConfig::new("conformance", model);
        config.programs.clone_from(&self.programs);
        config.includes.clone_from(&self.includes);
        config.run = run.iter().map(|name| (*name).to_owned()).collect();
        config.control = ControlAccess::Control;
        for &port in ports {
            config = config.with_port(port, 0);
        }
        Ok(config)
    }
}

/// A running controller.
pub(crate) struct Rig {
    pub(crate) controller: VirtualController,
    stepper: Stepper,
}

impl Rig {
    pub(crate) async fn start(config: &ControllerConfig) -> Result<Self> {
        let (clock, stepper) = Clock::stepped();
        let controller = VirtualController::start(config, clock, PeerLabels::new())?;
        let rig = Self {
            controller,
            stepper,
        };
        rig.pass(0.1).await?;
        Ok(rig)
    }

    /// Lets controller time pass.
    pub(crate) async fn pass(&self, seconds: f64) -> Result<()> {
        let by = Duration::from_secs_f64(seconds);
        let _now = self.stepper.advance(by).await?;
        Ok(())
    }

    /// Lets controller time pass until `future` is done.
    pub(crate) async fn drive<T>(&self, future: impl Future<Output = T>) -> Result<T> {
        let passing = async {
            loop {
                if let Err(error) = self.stepper.advance(STEP).await {
                    return error;
                }
                // A client is another task or another process: it gets its turn.
                tokio::time::sleep(Duration::from_millis(1)).await;
            }
        };
        tokio::select! {
            biased;
            done = future => Ok(done),
            stopped = passing => Err(stopped.into()),
            () = tokio::time::sleep(PATIENCE) => Err(anyhow!("this takes longer than {PATIENCE:?}")),
        }
    }

    /// Where a port of a program is.
    pub(crate) async fn port(&self, port: u16) -> Result<SocketAddr> {
        let address = self.drive(self.controller.address_of_port(port)).await?;
        Ok(address?)
    }

    /// Connects to a port of a program.
    pub(crate) async fn connect(&self, port: u16) -> Result<Client<'_>> {
        let address = self.port(port).await?;
        let stream = self.drive(TcpStream::connect(address)).await??;
        stream.set_nodelay(true)?;
        Ok(Client { stream, rig: self })
    }

    pub(crate) async fn state(&self) -> Result<State> {
        Ok(self.controller.state().await?)
    }

    /// Lets at most `seconds` pass until the state is as wanted; whether it became so.
    pub(crate) async fn until(
        &self,
        seconds: f64,
        mut wanted: impl FnMut(&State) -> bool,
    ) -> Result<bool> {
        let end = self.state().await?.time_s + seconds;
        loop {
            let state = self.state().await?;
            if wanted(&state) {
                return Ok(true);
            }
            if state.time_s >= end {
                return Ok(false);
            }
            self.pass(0.016).await?;
        }
    }

    /// Looks at the controller, or changes something.
    pub(crate) async fn with<T: Send + 'static>(
        &self,
        visitor: impl FnOnce(&mut Controller) -> T + Send + 'static,
    ) -> Result<T> {
        Ok(self.controller.with(visitor).await?)
    }

    /// A variable by its path, as text; `uninitialized` if it has no value.
    pub(crate) async fn variable(&self, path: &str) -> Result<String> {
        let owned = path.to_owned();
        let value = self.with(move |core| core.variable(&owned)).await?;
        Ok(in_words(value?))
    }

    /// A register, such as `R[81]`.
    pub(crate) async fn register(&self, name: &str) -> Result<String> {
        let owned = name.to_owned();
        let value = self.with(move |core| core.register(&owned)).await?;
        Ok(in_words(value?))
    }

    pub(crate) async fn set(&self, item: &str, value: &str) -> Result<()> {
        let (item, value) = (item.to_owned(), value.to_owned());
        let set = self.with(move |core| core.set_item(&item, &value)).await?;
        Ok(set?)
    }

    /// Where a task is: the lines of its call stack, innermost first, as `PROGRAM,line`.
    pub(crate) async fn stack(&self, task: &str) -> Result<Vec<String>> {
        let owned = task.to_owned();
        let seen = self.with(move |core| core.task(&owned)).await??;
        let calls = seen.view.calls.iter();
        Ok(calls
            .map(|site| format!("{},{}", site.program, site.line))
            .collect())
    }

    /// What became of a task, in words.
    pub(crate) async fn task(&self, name: &str) -> Result<String> {
        let state = self.state().await?;
        // A program that was started again is two tasks; the last one counts.
        let mut tasks = state.tasks.iter().rev();
        let task = tasks
            .find(|task| task.name.eq_ignore_ascii_case(name))
            .with_context(|| format!("there is no task {name}"))?;
        let word = format!("{:?}", task.state).to_ascii_lowercase();
        Ok(match &task.detail {
            Some(detail) => format!("{word}: {detail}"),
            None => word,
        })
    }

    /// The headlines of all alarms, oldest first.
    pub(crate) async fn alarms(&self) -> Result<Vec<String>> {
        let alarms = self.controller.alarms().await?;
        Ok(alarms.iter().map(Alarm::headline).collect())
    }

    /// Whether there was an alarm whose headline starts so.
    pub(crate) async fn had_alarm(&self, start: &str) -> Result<bool> {
        let alarms = self.alarms().await?;
        Ok(alarms.iter().any(|headline| headline.starts_with(start)))
    }

    pub(crate) async fn screen_has(&self, text: &str) -> Result<bool> {
        let screen = self.controller.screen().await?;
        Ok(screen.iter().any(|line| line.contains(text)))
    }

    /// How many motions were started.
    pub(crate) async fn started(&self) -> Result<usize> {
        let ledger = self.controller.ledger().await?;
        let started = ledger
            .iter()
            .filter(|entry| entry.event == karel_emulator::LedgerEvent::Started);
        Ok(started.count())
    }

    pub(crate) async fn stop(self) {
        self.controller.shutdown().await;
    }
}

fn in_words(value: Option<ValueBody>) -> String {
    match value {
        None => "uninitialized".to_owned(),
        Some(ValueBody::Boolean(value)) => value.to_string(),
        Some(ValueBody::Integer(value)) => value.to_string(),
        Some(ValueBody::Real(value)) => value.to_string(),
        Some(ValueBody::Text(value)) => value,
        Some(ValueBody::Pose(p)) => format!(
            "({:.3}, {:.3}, {:.3}, {:.3}, {:.3}, {:.3})",
            p.x_mm, p.y_mm, p.z_mm, p.w_deg, p.p_deg, p.r_deg
        ),
        Some(ValueBody::Joints(joints)) => {
            let joints: Vec<String> = joints
                .joints_deg
                .iter()
                .map(|joint| format!("{joint:.3}"))
                .collect();
            format!("[{}]", joints.join(", "))
        }
    }
}

/// What a client finds on its connection.
#[derive(Debug, PartialEq)]
pub(crate) enum Found {
    Bytes(Vec<u8>),
    /// The controller closed.
    End,
    /// Nothing, and the connection is open.
    Silence,
}

impl Found {
    pub(crate) fn text(&self) -> String {
        match self {
            Self::Bytes(bytes) => String::from_utf8_lossy(bytes).into_owned(),
            Self::End => "end of connection".to_owned(),
            Self::Silence => "silence, connection open".to_owned(),
        }
    }
}

/// A TCP client that lets controller time pass while it waits.
pub(crate) struct Client<'a> {
    stream: TcpStream,
    rig: &'a Rig,
}

impl Client<'_> {
    pub(crate) async fn send(&mut self, bytes: &[u8]) -> Result<()> {
        Ok(self.stream.write_all(bytes).await?)
    }

    /// What comes next in at most so many seconds of controller time.
    pub(crate) async fn next(&mut self, seconds: f64) -> Result<Found> {
        let end = self.rig.state().await?.time_s + seconds;
        loop {
            let mut bytes = vec![0; 65_536];
            match self.stream.try_read(&mut bytes) {
                Ok(0) => return Ok(Found::End),
                Ok(count) => {
                    bytes.truncate(count);
                    return Ok(Found::Bytes(bytes));
                }
                Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {}
                Err(error) if error.kind() == std::io::ErrorKind::ConnectionReset => {
                    return Ok(Found::End);
                }
                Err(error) => return Err(error.into()),
            }
            if self.rig.state().await?.time_s >= end {
                return Ok(Found::Silence);
            }
            self.rig.pass(0.016).await?;
            // What the kernel has for this client becomes visible when the runtime has looked.
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    }

    /// A request, and what was sent back at once.
    pub(crate) async fn ask(&mut self, request: &str) -> Result<String> {
        self.send(request.as_bytes()).await?;
        Ok(self.next(120.0).await?.text())
    }

    /// Everything until the controller closes.
    pub(crate) async fn rest(&mut self) -> Result<Vec<u8>> {
        let mut all = Vec::new();
        loop {
            match self.next(120.0).await? {
                Found::Bytes(bytes) => all.extend(bytes),
                Found::End => return Ok(all),
                Found::Silence => bail!("the controller does not close the connection"),
            }
        }
    }
}
