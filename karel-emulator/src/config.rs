//! What a virtual controller is made of.

use std::collections::{BTreeMap, BTreeSet};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use karel::ByteOrder;
use kinematics::{ArmModel, PendantJoints};

use crate::controller::RemoteStart;
use crate::devices::{FileName, Folder};
use crate::faults::{ControllerOption, FaultBody};
use crate::fidelity::{ControllerGeneration, Fidelity};
use crate::gripper::{GripperConfig, SharedWorkpieces, Workpieces};
use crate::hardware::safety::StopCategory;
use crate::ports::PortCounts;

/// A program's source text: KAREL, or the listing of a TP program if the name ends with `.ls`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProgramSource {
    /// File name for messages, such as `sock_server.kl`.
    pub name: String,
    /// The source, Latin-1 bytes.
    pub text: Vec<u8>,
}

impl ProgramSource {
    /// A program from its file name and source.
    pub fn new(name: impl Into<String>, text: impl Into<Vec<u8>>) -> Self {
        Self {
            name: name.into(),
            text: text.into(),
        }
    }
}

/// What happens to a second client while the first is served.
///
/// ASSUMPTION: real controllers are reported to do either, depending on the system version.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SecondClient {
    /// The port stays open while the task lives; the second client waits in the kernel's backlog for its turn.
    #[default]
    Backlog,
    /// The port is open only while the program waits for a client; the second client is refused.
    Refuse,
}

/// Whether the controller may be reached from other machines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Exposure {
    /// Loopback addresses only.
    #[default]
    Loopback,
    /// Any address: this is an unauthenticated motion server, and the log says so.
    AnyAddress,
}

/// Hosts that programs may connect to: this machine, and those that are listed. Nothing is looked up elsewhere.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Hosts(BTreeMap<String, IpAddr>);

impl Hosts {
    /// Permits a host by the name or address that programs have for it.
    pub fn permit(&mut self, name: &str, address: IpAddr) {
        let _before = self.0.insert(name.trim().to_ascii_lowercase(), address);
    }

    /// The address of a host that programs may connect to.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<IpAddr> {
        let name = name.trim().to_ascii_lowercase();
        if let Some(address) = self.0.get(&name) {
            return Some(*address);
        }
        if name == "localhost" {
            return Some(IpAddr::V4(Ipv4Addr::LOCALHOST));
        }
        name.parse().ok().filter(IpAddr::is_loopback)
    }
}

/// Gets the bytes that programs write to the USER screen, as they come. It must not wait.
#[derive(Clone)]
pub struct ScreenSink(pub Arc<Written>);

/// Called with the bytes of one WRITE.
type Written = dyn Fn(&[u8]) + Send + Sync;

impl std::fmt::Debug for ScreenSink {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("ScreenSink")
    }
}

/// What the panel lets its visitors do. They have no names: whoever reaches the loopback address is one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ControlAccess {
    /// Look and not touch.
    #[default]
    LookOnly,
    /// The control interface: programs, variables, I/O, the operator's keys, time, faults.
    Control,
}

/// Bounds of one controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Source bytes of one program.
    pub program_bytes: usize,
    /// Loaded programs.
    pub programs: usize,
    /// Entries of the ledger; older ones are dropped and counted.
    pub ledger_entries: usize,
    /// Alarms of the history; older ones are dropped and counted.
    pub alarms: usize,
    /// Instructions that one task executes in one millisecond of controller time.
    ///
    /// ASSUMPTION: this is the speed of the virtual processor; an endless loop costs this much and not more.
    pub instructions_per_ms: u32,
    /// Connections that are closed by the program and wait for their peer to read the last bytes.
    pub lingering_connections: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            program_bytes: 1 << 20,
            programs: 16,
            ledger_entries: 10_000,
            alarms: 1_000,
            instructions_per_ms: 2_000,
            lingering_connections: 64,
        }
    }
}

/// Everything a virtual controller needs to start.
#[derive(Clone, Debug)]
pub struct ControllerConfig {
    /// The controller's name in logs and state, such as `cell-1`.
    pub name: String,
    /// The arm.
    pub model: ArmModel,
    /// Where the arm stands at power-on.
    pub start_joints: PendantJoints,
    /// Programs to load.
    pub programs: Vec<ProgramSource>,
    /// Files for `%INCLUDE`; their names are paths from the folder of the programs.
    pub includes: Vec<ProgramSource>,
    /// Names of the programs to run as tasks. Empty: the first program that is loaded.
    pub run: Vec<String>,
    /// From a port as the program names it to a port of this machine; 0 stands for any free port, which is then kept.
    /// A port that is not in the map is used as it is.
    pub port_map: BTreeMap<u16, u16>,
    /// What happens to a second client.
    pub second_client: SecondClient,
    /// Address that the program's ports are opened on.
    pub ip: IpAddr,
    /// Whether `ip` may be anything but loopback.
    pub exposure: Exposure,
    /// Address of the panel, always loopback; `None` for no panel.
    pub panel: Option<SocketAddr>,
    /// Files that are on the devices at power-on.
    pub files: Vec<(FileName, Vec<u8>)>,
    /// The folder that keeps what programs write, if it shall be kept.
    pub folder: Option<Folder>,
    /// Hosts that programs may connect to with client tags.
    pub hosts: Hosts,
    /// The order of bytes in binary files.
    pub byte_order: ByteOrder,
    /// How much the controller says about itself.
    pub fidelity: Fidelity,
    /// The generation of the controller: what it translates.
    pub generation: ControllerGeneration,
    /// The period in which it interpolates.
    pub interpolation_period: InterpolationPeriod,
    /// I/O ports.
    pub ports: PortCounts,
    /// Numbers of the registers in which TP programs find epoch and number of the command they carry out, for the
    /// ledger.
    pub command_registers: Option<(u16, u16)>,
    /// The gripper, if there is one.
    pub gripper: Option<GripperConfig>,
    /// What the gripper finds.
    pub workpieces: Option<SharedWorkpieces>,
    /// Options that the controller was delivered without.
    pub missing_options: BTreeSet<ControllerOption>,
    /// Who asks the panel may change things, too: the control interface.
    pub control: ControlAccess,
    /// Set before the first statement runs: an item, such as `R[1]`, `DIN[3]` or `[PROG]VAR`, and its value.
    pub presets: Vec<(String, String)>,
    /// Faults that are there from the start.
    pub faults: Vec<FaultBody>,
    /// Controller time goes no further than this.
    pub stop_after: Option<Duration>,
    /// Whether lines are traced from the start.
    pub trace: bool,
    /// Gets everything that programs write to the USER screen.
    pub screen: Option<ScreenSink>,
    /// What random faults are drawn from.
    pub seed: u64,
    /// Whether signals of the user operator panel start programs. Nothing runs from power-on then, but what `run` names.
    pub remote_start: Option<RemoteStart>,
    /// How emergency stop buttons stop the arm.
    pub stop_category: StopCategory,
    /// Bounds.
    pub limits: Limits,
}

/// The period in which a controller interpolates: a `DELAY` lasts a whole number of these, programs see where the arm was
/// at the last one, and SKIP CONDITION, WAIT of TP programs and monitors look once in each.
///
/// The way of the arm itself is exact at any time and does not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InterpolationPeriod(u8);

impl InterpolationPeriod {
    /// So many milliseconds, 1 to 64; `None` for anything else.
    #[must_use]
    pub fn from_millis(ms: u8) -> Option<Self> {
        (1..=64).contains(&ms).then_some(Self(ms))
    }

    /// The period.
    #[must_use]
    pub fn duration(self) -> Duration {
        Duration::from_millis(self.0.into())
    }

    /// The period in milliseconds.
    #[must_use]
    pub fn millis(self) -> f64 {
        self.0.into()
    }
}

impl Default for InterpolationPeriod {
    /// 8 ms, as controllers are delivered.
    fn default() -> Self {
        Self(8)
    }
}

impl ControllerConfig {
    /// A controller of `model` at its home, with nothing loaded, on loopback, without a panel.
    #[must_use]
    pub fn new(name: impl Into<String>, model: &ArmModel) -> Self {
        Self {
            name: name.into(),
            model: model.clone(),
            start_joints: model.home(),
            programs: Vec::new(),
            includes: Vec::new(),
            run: Vec::new(),
            port_map: BTreeMap::new(),
            second_client: SecondClient::default(),
            ip: IpAddr::V4(Ipv4Addr::LOCALHOST),
            exposure: Exposure::default(),
            panel: None,
            files: Vec::new(),
            folder: None,
            hosts: Hosts::default(),
            byte_order: ByteOrder::default(),
            fidelity: Fidelity::default(),
            generation: ControllerGeneration::default(),
            interpolation_period: InterpolationPeriod::default(),
            ports: PortCounts::default(),
            command_registers: None,
            gripper: None,
            workpieces: None,
            missing_options: BTreeSet::new(),
            control: ControlAccess::default(),
            presets: Vec::new(),
            faults: Vec::new(),
            stop_after: None,
            trace: false,
            screen: None,
            seed: 0,
            remote_start: None,
            stop_category: StopCategory::default(),
            limits: Limits::default(),
        }
    }

    /// Loads one more program.
    #[must_use]
    pub fn with_program(mut self, program: ProgramSource) -> Self {
        self.programs.push(program);
        self
    }

    /// Gives one more file to `%INCLUDE`.
    #[must_use]
    pub fn with_include(mut self, file: ProgramSource) -> Self {
        self.includes.push(file);
        self
    }

    /// Fits a gripper. It is open and empty at first.
    #[must_use]
    pub fn with_gripper(mut self, gripper: GripperConfig) -> Self {
        self.gripper = Some(gripper);
        self
    }

    /// Gives the gripper something to grip.
    #[must_use]
    pub fn with_workpieces(mut self, workpieces: Arc<dyn Workpieces>) -> Self {
        self.workpieces = Some(SharedWorkpieces(workpieces));
        self
    }

    /// Maps a port of the program to a port of this machine, 0 for any free one.
    #[must_use]
    pub fn with_port(mut self, program_port: u16, host_port: u16) -> Self {
        let _previous = self.port_map.insert(program_port, host_port);
        self
    }
}
