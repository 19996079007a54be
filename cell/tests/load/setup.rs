//! A cell of two arms and two mobile robots that share two hand-over points, and a plant of several such cells.
//!
//! ```text
//!                north, from y
//!    rack r1  [ handover/north ]
//!    [][][][]
//!        r1     x 1100    r2      x
//!                            [][][][]
//!             [ handover/south ]  rack r2
//!                south, from -y                  gates at x 4500
//! ```
//! Both arms reach both points. What is at r1 at (x, y) is at r2 turned by half a turn: at (2200 - x, -y).

use std::fmt::Write as _;

/// Cells of the plant; 2 arms and 2 mobile robots each.
pub(crate) const CELLS: usize = 4;
pub(crate) const ARMS: [&str; 2] = ["r1", "r2"];
pub(crate) const MOBILES: [&str; 2] = ["mr1", "mr2"];
pub(crate) const POINTS: [&str; 2] = ["south", "north"];
pub(crate) const SLOTS: [&str; 2] = ["left", "right"];

/// The place of a mobile robot's crates at an arm: places 0 and 1 are the first robot's, 2 and 3 the second's.
pub(crate) fn place(arm: usize, mobile: usize, slot: usize) -> String {
    format!("rack{}/{}", arm + 1, mobile * 2 + slot)
}

pub(crate) fn cell_id(cell: usize) -> String {
    format!("cell{}", cell + 1)
}

pub(crate) fn controller(cell: usize, arm: usize) -> String {
    format!("vc{}-{}", cell + 1, arm + 1)
}

/// The server's cells, and the virtual parts in front of them.
///
/// With `files` each cell has its set-up in a file of its id.
pub(crate) fn config(scale: f64, files: bool) -> String {
    let mut text =
        "[server]\ndemo = true\nlisten = '127.0.0.1:0'\nlegacy_robot = 'cell1/r1'\n".to_owned();
    let mut parts = String::new();
    for cell in 0..CELLS {
        let id = cell_id(cell);
        writeln!(text, "[[cells]]\nid = '{id}'").unwrap();
        if files {
            writeln!(text, "setup = '{id}.toml'").unwrap();
        }
        for (arm, name) in ARMS.iter().enumerate() {
            let controller = controller(cell, arm);
            writeln!(
                text,
                "[[cells.robots]]\nid = '{name}'\nmodel = 'fanuc-m20ia'\ncontroller = 'virtual:{controller}'\n\
                 tier = 'cell_server'\ntime_scale = {scale:.1}"
            )
            .unwrap();
            writeln!(
                parts,
                "[[virtual_controllers]]\nname = '{controller}'\nmodel = 'fanuc-m20ia'\nruns = 'cell_server'\n\
                 time_scale = {scale:.1}\nstart_joints_deg = [90, 0, 0, 0, -90, 0]"
            )
            .unwrap();
        }
        for mobile in MOBILES {
            writeln!(
                parts,
                "[[virtual_mobile_robots]]\ncell = '{id}'\nid = '{mobile}'\ntime_scale = {scale:.1}"
            )
            .unwrap();
        }
    }
    text + &parts
}

/// The set-up of each of the cells.
pub(crate) fn setup() -> String {
    let mut text = "format = 1\nname = 'Two arms, two mobile robots'\n".to_owned();
    let t = &mut text;
    arms(t);
    zones(t);
    floor(t);
    for (arm, name) in ARMS.iter().enumerate() {
        for index in 0..4 {
            let place = format!("rack{}/{index}", arm + 1);
            writeln!(
                t,
                "[[places]]\nid = '{place}'\nkind = 'FIXED'\naccepts = ['crate']"
            )
            .unwrap();
            let x = 100.0 - 200.0 * f64::from(index);
            taught(t, name, &place, 150, at(arm, x, 1000.0, 650.0, 90.0));
        }
        for (point, side) in POINTS.iter().zip([1.0, -1.0]) {
            for (slot, ahead) in SLOTS.iter().zip([180.0, -180.0]) {
                // Its front looks to the middle of the cell; the slots are before and behind its middle.
                let y = -side * 800.0 + side * ahead;
                let turned = if arm == 0 { (1100.0, y) } else { (1100.0, -y) };
                let pose = at(arm, turned.0, turned.1, 600.0, 0.0);
                taught(t, name, &format!("{point}/{slot}"), 200, pose);
            }
        }
    }
    text
}

/// X, Y, Z and R in the cell of what is at an arm as if it stood in the origin.
fn at(arm: usize, x: f64, y: f64, z: f64, r: f64) -> [f64; 4] {
    match arm {
        0 => [x, y, z, r],
        _ => [2200.0 - x, -y, z, r - 180.0],
    }
}

fn taught(t: &mut String, arm: &str, place: &str, approach: u32, [x, y, z, r]: [f64; 4]) {
    writeln!(
        t,
        "[[taught_poses]]\narm = '{arm}'\nplace = '{place}'\nconfiguration = 'N U T, 0, 0, 0'\n\
         approach_mm = {approach}\n\
         pose = {{ x_mm = {x:.1}, y_mm = {y:.1}, z_mm = {z:.1}, w_deg = 180, p_deg = 0, r_deg = {r:.1} }}"
    )
    .unwrap();
}

fn arms(t: &mut String) {
    for (arm, name) in ARMS.iter().enumerate() {
        let [x, y, _, r] = at(arm, 0.0, 0.0, 0.0, 0.0);
        writeln!(
            t,
            "[[arms]]\nid = '{name}'\ntool = 1\nbody_radius_mm = 110\n\
             base = {{ x_mm = {x:.1}, y_mm = {y:.1}, z_mm = 525, w_deg = 0, p_deg = 0, r_deg = {r:.1} }}\n\
             safe = {{ j1_deg = 90, j2_deg = 0, j3_deg = 0, j4_deg = 0, j5_deg = -90, j6_deg = 0 }}\n\
             [[tools]]\narm = '{name}'\nnumber = 1\nradius_mm = 60\n\
             frame = {{ x_mm = 0, y_mm = 0, z_mm = 150, w_deg = 0, p_deg = 0, r_deg = 0 }}"
        )
        .unwrap();
    }
}

fn zones(t: &mut String) {
    let mut zone = |id: &str, kind: &str, robots: &str, min: [i32; 3], max: [i32; 3]| {
        let corner = |[x, y, z]: [i32; 3]| format!("{{ x_mm = {x}, y_mm = {y}, z_mm = {z} }}");
        writeln!(
            t,
            "[[zones]]\nid = '{id}'\nkind = '{kind}'\n{robots}\nbox.min = {}\nbox.max = {}",
            corner(min),
            corner(max)
        )
        .unwrap();
    };
    zone(
        "r1-work",
        "WORK",
        "robots = ['r1']",
        [-1200, -1300, 300],
        [1700, 1400, 2200],
    );
    zone(
        "r2-work",
        "WORK",
        "robots = ['r2']",
        [500, -1400, 300],
        [3400, 1300, 2200],
    );
    let mobiles = "robots = ['mr1', 'mr2']";
    zone(
        "floor",
        "WORK",
        mobiles,
        [500, -3500, -100],
        [6000, 3500, 2000],
    );
    zone("south", "HANDOVER", "", [650, -1500, 0], [1550, -250, 690]);
    zone("north", "HANDOVER", "", [650, 250, 0], [1550, 1500, 690]);
}

/// Where mobile robots dock and drive.
fn floor(t: &mut String) {
    t.push_str("[[stations]]\nid = 'handover'\n");
    for (point, (y, heading)) in POINTS.iter().zip([(-800, 90), (800, 270)]) {
        writeln!(
            t,
            "[[stations.points]]\nid = '{point}'\narms = ['r1', 'r2']\nzone = '{point}'\n\
             dock = {{ x_mm = 1100, y_mm = {y}, heading_deg = {heading} }}\n\
             dock_tolerance = {{ position_mm = 15, angle_deg = 2 }}"
        )
        .unwrap();
    }
    t.push_str("[[stations]]\nid = 'gates'\n");
    for (mobile, y) in MOBILES.iter().zip([-600, 600]) {
        writeln!(
            t,
            "[[stations.points]]\nid = '{mobile}'\ndock = {{ x_mm = 4500, y_mm = {y}, heading_deg = 0 }}\n\
             dock_tolerance = {{ position_mm = 50, angle_deg = 5 }}"
        )
        .unwrap();
    }
    for mobile in MOBILES {
        writeln!(
            t,
            "[[destinations]]\nid = 'gate-{mobile}'\npoint = 'gates/{mobile}'\n\
             [[mobile_robots]]\nid = '{mobile}'\nhome = 'gates/{mobile}'\n\
             footprint = {{ length_mm = 800, width_mm = 600, height_mm = 650 }}\n\
             slots = [{{ id = 'left', accepts = ['crate'] }}, {{ id = 'right', accepts = ['crate'] }}]"
        )
        .unwrap();
        for (point, y) in POINTS.iter().zip([-2300, 2300]) {
            writeln!(
                t,
                "[[routes]]\nid = '{mobile}-{point}'\nfrom = 'handover/{point}'\nto = 'gates/{mobile}'\n\
                 waypoints = [{{ x_mm = 1100, y_mm = {y} }}, {{ x_mm = 4000, y_mm = {y} }}]"
            )
            .unwrap();
        }
    }
    t.push_str(
        "[[routes]]\nid = 'south-north'\nfrom = 'handover/south'\nto = 'handover/north'\n\
         waypoints = [{ x_mm = 1100, y_mm = -2300 }, { x_mm = 4000, y_mm = -2300 }, { x_mm = 4000, y_mm = 2300 }, \
         { x_mm = 1100, y_mm = 2300 }]\n",
    );
    for point in POINTS {
        for slot in SLOTS {
            writeln!(
                t,
                "[[places]]\nid = '{point}/{slot}'\nkind = 'ON_MOBILE_ROBOT'\npoint = 'handover/{point}'\n\
                 slot = '{slot}'\naccepts = ['crate']"
            )
            .unwrap();
        }
    }
}
