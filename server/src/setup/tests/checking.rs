use super::support::{DEMO, setup};

#[test]
fn the_demo_cell_has_room_everywhere() {
    let check = setup(DEMO).check();
    println!("{}", serde_json::to_string_pretty(&check).unwrap());
    assert!(check.passed);
}
