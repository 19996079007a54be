//! Any text as a file that somebody configures with: an arm model.

use kinematics::ArmModel;

/// It is refused with a reason, or what it says can be used.
///
/// # Panics
/// If that finds something.
pub fn run(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    match ArmModel::from_toml(text) {
        Ok(model) => use_arm(&model),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// A model that is taken has a home inside of its limits, and a finite geometry.
fn use_arm(model: &ArmModel) {
    let home = model.home();
    assert!(model.check_limits(&home).is_ok(), "the home is outside");
    let pose = model.forward(&home);
    let text = format!("{pose:?}");
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    let _solutions = model.inverse_all(&pose).map_err(|error| error.to_string());
    let _singular = model.singularity(&home);
    let _configuration = model.configuration(&home);
}
