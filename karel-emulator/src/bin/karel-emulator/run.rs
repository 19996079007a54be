//! `karel-emulator run`: a controller until it is interrupted.

use std::io::IsTerminal;
use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, anyhow};
use karel::{ByteOrder, Program};
use karel_emulator::config::{
    ControllerConfig, Exposure, InterpolationPeriod, ProgramSource, SecondClient,
};
use karel_emulator::devices;
use karel_emulator::{
    Clock, ControlAccess, ControllerOption, FaultBody, Fidelity, PeerLabels, ProgramSelection,
    RemoteStart, VirtualController,
};
use kinematics::ArmModel;
use tokio::signal::unix::{SignalKind, signal};

mod arguments;
mod idle;
mod words;

use crate::includes::Folder;
use arguments::{
    Presets, parse_clock, parse_fault, parse_host, parse_joints, parse_panel, parse_period,
    parse_port_map, parse_presets,
};
pub(crate) use words::GenerationWord;
use words::{FidelityWord, MissingOption, Second, SelectionWord};

/// Run KAREL programs on a virtual controller.
///
/// It runs until it is interrupted, even when its programs have ended, so that its state can be looked at. With
/// --until-idle it ends as soon as nothing more will happen without somebody outside, and its exit code says whether a
/// task was aborted or an alarm is active: that is what a test in CI wants. What programs write to the USER screen goes
/// to the standard output then.
#[derive(Debug, clap::Args)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a switch of its own, and its name is on the command line"
)]
pub(crate) struct Run {
    /// KAREL sources, or listings (`.ls`) of TP programs, to load.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Program to start as a task; can be given several times. The first that is loaded if none is given.
    #[arg(long = "program", value_name = "NAME")]
    programs: Vec<String>,
    /// Open the program's port PORT as HOST of this machine, 0 for any free port; can be given several times.
    #[arg(long = "port-map", value_name = "PORT=HOST", value_parser = parse_port_map)]
    port_map: Vec<(u16, u16)>,
    /// Look for `%INCLUDE` files in this folder, too; can be given several times.
    #[arg(long = "include", value_name = "FOLDER")]
    includes: Vec<PathBuf>,
    /// Address of the panel, always loopback, or `off`. [default: 127.0.0.1:8081, with --until-idle off]
    #[arg(long, value_name = "ADDRESS|off")]
    panel: Option<String>,
    /// The panel can look and not touch: no control interface.
    #[arg(long)]
    look_only: bool,
    /// Controller seconds in a second, up to 1000; or `max`: time jumps to whatever is due next, for programs that talk
    /// to nobody. [default: 1, with --until-idle max]
    #[arg(long, value_name = "N|max")]
    time_scale: Option<String>,
    /// End as soon as nothing more will happen without somebody outside. Exit code 1 if a task was aborted by an error,
    /// an alarm is active, or that does not happen in time.
    #[arg(long)]
    until_idle: bool,
    /// With --until-idle: give up after so many seconds of controller time.
    #[arg(
        long,
        default_value_t = 300.0,
        value_name = "SECONDS",
        allow_hyphen_values = true,
        requires = "until_idle"
    )]
    limit: f64,
    /// What random faults are drawn from: the same seed and the same inputs give the same run.
    #[arg(long, default_value_t = 0, value_name = "NUMBER")]
    seed: u64,
    /// Set this before the first statement runs, such as `R[1]=5`, `DIN[3]=ON`, `[PROG]VAR=true`; can be given several
    /// times. `@FILE` has one ITEM=VALUE a line; empty lines and those that begin with `--` are skipped.
    #[arg(long = "set", value_name = "ITEM=VALUE|@FILE", value_parser = parse_presets)]
    presets: Vec<Presets>,
    /// A fault from the start, as JSON: `{"fault": {"delay": {"ms": 50}}, "times": 3}`; can be given several times.
    #[arg(long = "fault", value_name = "JSON", value_parser = parse_fault)]
    faults: Vec<FaultBody>,
    /// An option that the controller was delivered without; can be given several times.
    #[arg(long = "missing-option", value_enum, value_name = "OPTION")]
    missing_options: Vec<MissingOption>,
    /// With --until-idle: write what the arm did to this file, one JSON object a line.
    #[arg(long, value_name = "FILE", requires = "until_idle")]
    ledger: Option<PathBuf>,
    /// With --until-idle: write the executed lines to this file, the last 10000 of them.
    #[arg(long, value_name = "FILE", requires = "until_idle")]
    trace: Option<PathBuf>,
    /// The arm.
    #[arg(long, default_value = "fanuc-m20ia")]
    model: String,
    /// Joints at power-on in degrees, as the pendant shows them: j1,j2,j3,j4,j5,j6. The home of the arm if not given.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    home: Option<String>,
    /// Address that the program's ports are opened on.
    #[arg(long, default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    ip: IpAddr,
    /// Permit an --ip that other machines can reach. Anybody who connects can move the simulated arm.
    #[arg(long)]
    expose_to_network: bool,
    /// What happens to a second client while the first is served.
    #[arg(long, value_enum, default_value_t = Second::Backlog)]
    second_client: Second,
    /// Folder with a folder for each device, RD, MC and so on: its files are there at power-on, and what programs
    /// write is kept in it.
    #[arg(long = "files", value_name = "FOLDER")]
    folder: Option<PathBuf>,
    /// Permit programs to connect to HOST, an address or a name with its address; can be given several times. This
    /// machine is always permitted.
    #[arg(long = "allow-host", value_name = "HOST[=ADDRESS]", value_parser = parse_host)]
    hosts: Vec<(String, IpAddr)>,
    /// Write binary files with the lowest byte first, as the vendor's simulator does.
    #[arg(long)]
    little_endian: bool,
    /// How much the controller says about itself: `faithful` is as silent as a real one, `kind` explains why a client
    /// hangs, a number is none, a pose is out of reach, and disconnects the clients of a task that an error has ended.
    #[arg(long, value_enum, default_value_t = FidelityWord::Faithful)]
    fidelity: FidelityWord,
    /// The generation of the controller: `v7` (R-30iA: KAREL moves the arm, strings of 128), `v9` (R-30iB Plus: MOVE is
    /// not translated), or `any`, which accepts both.
    #[arg(long, value_enum, default_value_t = GenerationWord::Any)]
    generation: GenerationWord,
    /// The period in which the controller interpolates, 1 to 64 ms: a DELAY lasts a whole number of these, and programs
    /// see where the arm was at the last one.
    #[arg(long, default_value = "8", value_name = "MS", value_parser = parse_period)]
    interpolation_ms: InterpolationPeriod,
    /// Let signals start programs: `rsr` (UI[9] to UI[16] start RSR0001 to RSR0008, one after the other) or `pns` (they
    /// are a number, UI[17] chooses PNS0001 to PNS0255, UI[18] going off starts it). UI[1], UI[2], UI[3] and UI[8] are on.
    #[arg(long, value_enum, value_name = "HOW")]
    remote_start: Option<SelectionWord>,
    /// With --remote-start: added to the number that the signals mean.
    #[arg(
        long,
        default_value_t = 0,
        value_name = "NUMBER",
        requires = "remote_start"
    )]
    base_number: u16,
    /// What to log on standard error, such as `info` or `karel_emulator=debug`.
    ///
    /// [default: info, with --until-idle warn]
    #[arg(long, env = "KAREL_EMULATOR_LOG", value_name = "FILTER")]
    log: Option<String>,
}

impl Run {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        let usual = if self.until_idle { "warn" } else { "info" };
        let log = self.log.as_deref().unwrap_or(usual);
        let filter = tracing_subscriber::EnvFilter::try_new(log)
            .with_context(|| format!("reading the log filter {log:?}"))?;
        tracing_subscriber::fmt()
            .with_env_filter(filter)
            .with_writer(std::io::stderr)
            .with_ansi(use_color())
            .init();
        let mut config = self.config()?;
        let usual = if self.until_idle { "max" } else { "1" };
        let clock = parse_clock(self.time_scale.as_deref().unwrap_or(usual))?;
        let runtime = tokio::runtime::Runtime::new().context("starting the runtime")?;
        if self.until_idle {
            return runtime.block_on(self.until_idle(&mut config, clock));
        }
        runtime.block_on(serve(&config, clock))?;
        Ok(ExitCode::SUCCESS)
    }

    fn config(&self) -> anyhow::Result<ControllerConfig> {
        let model = ArmModel::builtin(&self.model).ok_or_else(|| {
            anyhow!(
                "there is no arm {:?}; there are: {}",
                self.model,
                ArmModel::builtin_names().join(", ")
            )
        })?;
        let mut config = ControllerConfig::new("emulator", model);
        for path in &self.files {
            let text =
                std::fs::read(path).with_context(|| format!("reading {}", path.display()))?;
            let name = path.display().to_string();
            let folder = Folder::of(path).and(&self.includes);
            // What is wrong with the program is reported when the controller loads it.
            let _looked_at = Program::from_file(&text, &name, &folder);
            config.includes.extend(folder.into_taken());
            config.programs.push(ProgramSource::new(name, text));
        }
        config.run.clone_from(&self.programs);
        config.port_map = self.port_map.iter().copied().collect();
        if let Some(home) = &self.home {
            config.start_joints = parse_joints(home)?;
        }
        config.ip = self.ip;
        if self.expose_to_network {
            config.exposure = Exposure::AnyAddress;
        }
        config.second_client = match self.second_client {
            Second::Backlog => SecondClient::Backlog,
            Second::Refuse => SecondClient::Refuse,
        };
        let usual = if self.until_idle {
            "off"
        } else {
            "127.0.0.1:8081"
        };
        config.panel = parse_panel(self.panel.as_deref().unwrap_or(usual))?;
        if !self.look_only {
            config.control = ControlAccess::Control;
        }
        config.fidelity = match self.fidelity {
            FidelityWord::Faithful => Fidelity::Faithful,
            FidelityWord::Kind => Fidelity::Kind,
        };
        config.generation = self.generation.into();
        config.interpolation_period = self.interpolation_ms;
        config.remote_start = self.remote_start.map(|selection| RemoteStart {
            selection: match selection {
                SelectionWord::Rsr => ProgramSelection::Rsr,
                SelectionWord::Pns => ProgramSelection::Pns,
            },
            base: self.base_number,
        });
        config.seed = self.seed;
        config.presets = self.presets.iter().flat_map(|set| set.0.clone()).collect();
        config.faults.clone_from(&self.faults);
        let option = |option: &MissingOption| match option {
            MissingOption::R632 => ControllerOption::R632,
            MissingOption::R648 => ControllerOption::R648,
        };
        config.missing_options = self.missing_options.iter().map(option).collect();
        if let Some(path) = &self.folder {
            let reading = || format!("reading the folder {}", path.display());
            let folder = devices::Folder::try_new(path).with_context(reading)?;
            config.files = folder.read().with_context(reading)?;
            config.folder = Some(folder);
        }
        for (name, address) in &self.hosts {
            config.hosts.permit(name, *address);
        }
        if self.little_endian {
            config.byte_order = ByteOrder::Little;
        }
        Ok(config)
    }
}

/// Colors are for a terminal, and only if its owner likes them.
fn use_color() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
}

async fn serve(config: &ControllerConfig, clock: Clock) -> anyhow::Result<()> {
    let mut interrupt = signal(SignalKind::interrupt()).context("listening for interrupts")?;
    let mut terminate = signal(SignalKind::terminate()).context("listening for termination")?;
    let controller = VirtualController::start(config, clock, PeerLabels::new())
        .context("the controller does not start")?;
    if let Some(address) = controller.panel_address() {
        tracing::info!("The panel is at http://{address}/.");
    }
    let ended = tokio::select! {
        _ = interrupt.recv() => Ok(()),
        _ = terminate.recv() => Ok(()),
        // Nobody could connect: whoever started this wants to know, and not a program that tries for ever.
        Ok(reason) = controller.port_failure() => Err(anyhow!(
            "{reason}. Is another controller running? --port-map chooses another port"
        )),
    };
    controller.shutdown().await;
    ended
}
