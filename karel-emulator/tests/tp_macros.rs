//! TP listings as they are found: macros, values that nobody entered, other motion groups, turns of the wrist.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a helper that fails stops its test"
)]

mod common;

use common::tp::{Core, config, joints, listing, position};
use karel::{Number, Program, TaskState};

fn warnings(lines: &[&str], positions: &str) -> Vec<String> {
    let source = listing("t", lines, positions);
    let program = Program::parse_listing(&source.text, "t.ls").unwrap();
    let messages = program.warnings().iter();
    messages.map(|warning| warning.message.clone()).collect()
}

fn error(lines: &[&str]) -> String {
    let source = listing("t", lines, "");
    let errors = Program::parse_listing(&source.text, "t.ls").unwrap_err();
    errors.first().unwrap().to_string()
}

/// What ended the program.
fn ended(core: &Core) -> String {
    match core.0.task("moves").unwrap().view.state {
        TaskState::Aborted(error) => error.to_string(),
        other @ (TaskState::Ready | TaskState::Blocked(_) | TaskState::Ended) => {
            format!("{other:?}")
        }
    }
}

#[test]
fn assumed_a_macro_is_the_program_of_its_row_or_of_its_name() {
    let lines = ["Open Hand", "CloseHand(3)", "OpenHand"];
    let mut config = config(&lines, "")
        .with_program(listing("grip", &["R[1]=R[1]+AR[1]"], ""))
        .with_program(listing("openhand", &["R[2]=R[2]+1"], ""));
    config.presets = [
        ("R[1]", "0"),
        ("R[2]", "0"),
        ("$MACROTABLE[7].$MACRO_NAME", "closehand"),
        ("$MACROTABLE[7].$PROG_NAME", "GRIP"),
    ]
    .map(|(item, value)| (item.to_owned(), value.to_owned()))
    .into();
    let mut core = Core::of(&config);
    core.finish();
    assert_eq!(ended(&core), "Ended");
    let register = |n| core.0.registers().number(n).unwrap();
    assert_eq!([register(1), register(2)], [3, 2].map(Number::Integer));
}

#[test]
fn a_macro_that_nothing_explains_ends_the_task_and_words_with_a_slip_are_an_error() {
    let mut core = Core::moves(&["Clear User Page"], "");
    core.finish();
    let error_of_task = ended(&core);
    assert!(
        error_of_task.contains("INTP-316") && error_of_task.contains("CLEARUSERPAGE"),
        "{error_of_task}"
    );
    let found = warnings(&["OpenHand", "Op. Entry Menu('Chute')", "Wait"], "");
    assert!(
        found[0].starts_with("`OpenHand` is taken for a macro"),
        "{found:?}"
    );
    assert!(
        found[1].starts_with("`Op. Entry Menu` is taken for a macro"),
        "{found:?}"
    );
    let slip = error(&["CALLL HOME"]);
    assert!(slip.contains("is CALL meant?"), "{slip}");
    let found = warnings(&["VISION RUN_FIND"], "");
    assert!(
        found[0].starts_with("VISION RUN_FIND needs iRVision"),
        "{found:?}"
    );
    for strange in ["R1=5", "Light[3]"] {
        assert!(error(&[strange]).contains("error"), "{strange}");
    }
}

#[test]
fn assumed_what_nobody_has_entered_is_intp_311_for_who_comes_there() {
    for line in [
        "R[1]=Constant",
        "CALL ...",
        "R[...]=1",
        "J PR[...] 100% FINE",
        "JMP LBL[...]",
        "CALL T(Constant)",
    ] {
        assert_eq!(warnings(&[line], "").len(), 1, "{line}");
        let mut core = Core::moves(&["R[2]=1", line], "");
        core.finish();
        let error = ended(&core);
        assert!(error.starts_with("INTP-311 (MOVES, 2)"), "{line}: {error}");
    }
}

#[test]
fn assumed_other_groups_and_axes_are_left_out_with_a_warning() {
    let place = position(1, [900.0, 0.0, 700.0, 180.0, 0.0, 0.0]);
    let more = place.replace(
        "\n};",
        ",\n\tE1 = 10.000 mm\n   GP2:\n\tUF : 0, UT : 1,\n\tJ1 = 5 deg\n};",
    );
    let other = "P[2]{\n   GP2:\n\tUF : 0, UT : 1,\n\tJ1 = 5 deg\n};\n";
    let lines = ["J P[1] 100% FINE"];
    let found = warnings(&lines, &(more.clone() + other));
    assert_eq!(found.len(), 2, "{found:?}");
    let mut core = Core::moves(&lines, &(more + other));
    core.finish();
    assert!((core.tool()[0] - 900.0).abs() < 0.01, "{:?}", core.tool());
}

#[test]
fn assumed_mrot_goes_to_the_nearest_turn_and_without_it_the_turn_counts() {
    for (option, last) in [("", 200.0_f64), (" MROT", -160.0)] {
        let start = joints(1, [0.0, 0.0, 0.0, 0.0, -90.0, -170.0]);
        let end = joints(2, [0.0, 0.0, 0.0, 0.0, -90.0, 200.0]);
        let second = format!("J P[2] 100% FINE{option}");
        let mut core = Core::moves(&["J P[1] 100% FINE", &second], &(start + &end));
        core.finish();
        assert!((core.0.joints_deg()[5] - last).abs() < 1e-3, "{option}");
    }
    assert!(error(&["L P[1] 100mm/sec FINE MROT"]).contains("only a motion J"));
}

#[test]
fn a_file_that_is_no_listing_is_one_error() {
    let errors = Program::parse_listing(b" F Number: F00000\n x\n y\n", "errall.ls").unwrap_err();
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert!(
        errors[0].message.contains("no listing of a TP program"),
        "{}",
        errors[0]
    );
}
