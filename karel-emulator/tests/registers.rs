//! Registers and joint positions on the simulated arm.

mod common;

use common::{Stepped, config_of};
use karel::{Number, PositionRegister};
use karel_emulator::CmosMemory;

const PROGRAM: &str = "PROGRAM regs
VAR
  s : INTEGER
  p : XYZWPR
  jp : JOINTPOS
  j6 : JOINTPOS6
  a : ARRAY[9] OF REAL
BEGIN
  SET_INT_REG(5, 42, s)
  SET_STR_REG(1, 'bin', s)
  jp = CURJPOS(0, 0)
  SET_JPOS_REG(1, jp, s)
  p = GET_POS_REG(1, s)
  SET_POS_REG(2, p, s)
  j6 = GET_JPOS_REG(2, s)
  CNV_JPOS_REL(j6, a, s)
  WRITE (a[1]::8::2, a[2]::8::2, a[3]::8::2, UNINIT(a[7]), J_IN_RANGE(j6), CR)
  a[1] = 500
  CNV_REL_JPOS(a, j6, s)
  WRITE (J_IN_RANGE(j6), CR)
  JOINT2POS(jp, $UFRAME, $UTOOL, 0, p, p.config_data, a, s)
  SET_POS_REG(3, p, s)
END regs
";

#[tokio::test]
async fn a_position_register_holds_joints_and_gives_a_position() {
    let config = config_of(PROGRAM, &[]);
    let home = config.start_joints.degrees();
    let cell = Stepped::start(&config);
    cell.advance(0.1).await;
    let [j1, j2, j3, ..] = home;
    let expected = format!("{j1:8.2}{j2:8.2}{j3:8.2}TRUETRUE");
    let expected = expected.replace(" 0.00", "  .00");
    let screen = cell.controller.screen().await.unwrap();
    assert_eq!(screen, [expected.as_str(), "FALSE"]);
    let registers = cell.controller.registers().await.unwrap();
    assert_eq!(registers.number(5), Ok(Number::Integer(42)));
    assert_eq!(registers.string(1), Ok("bin"));
    let joints = registers.position(1).unwrap();
    assert!(matches!(joints, PositionRegister::Joints(joints) if joints.axes.len() == 6));
    let pose = cell.controller.state().await.unwrap().pose;
    for n in [2, 3] {
        let PositionRegister::Cartesian(position) = registers.position(n).unwrap() else {
            panic!("PR[{n}] holds no position");
        };
        assert!((f64::from(position.x) - pose.x_mm).abs() < 0.01, "PR[{n}]");
        assert!((f64::from(position.z) - pose.z_mm).abs() < 0.01, "PR[{n}]");
    }
}

#[tokio::test]
async fn registers_survive_a_power_cycle_with_the_battery_only() {
    let counts = "PROGRAM t\nVAR s, i: INTEGER\nb: BOOLEAN\nr: REAL\nBEGIN\nGET_REG(5, b, i, r, s)\n\
        SET_INT_REG(5, i + 1, s)\nEND t\n";
    let cell = Stepped::start(&config_of(counts, &[]));
    cell.advance(0.1).await;
    cell.controller.power_cycle(CmosMemory::Kept).await.unwrap();
    cell.advance(0.1).await;
    let registers = cell.controller.registers().await.unwrap();
    assert_eq!(registers.number(5), Ok(Number::Integer(2)));
    cell.controller.power_cycle(CmosMemory::Lost).await.unwrap();
    cell.advance(0.1).await;
    let registers = cell.controller.registers().await.unwrap();
    assert_eq!(registers.number(5), Ok(Number::Integer(1)));
}
