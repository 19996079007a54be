use api::setup::SetupFile;

use super::support::{DEMO, PAIR, file, with};
use crate::setup::{DocumentError, Form, parse_setup, write_setup};

#[test]
fn what_is_exported_reads_back_as_the_same_in_both_forms() {
    for text in [DEMO, PAIR, "format = 1"] {
        let original = file(text);
        for form in [Form::Toml, Form::Json] {
            let exported = write_setup(&original, form);
            let again = parse_setup(exported.as_bytes(), form).unwrap();
            assert_eq!(again, original, "{exported}");
            assert_eq!(write_setup(&again, form), exported);
        }
    }
    let Ok(empty) = parse_setup(b"format = 1", Form::Toml) else {
        panic!("the smallest set-up is one");
    };
    assert_eq!(empty, SetupFile::empty());
}

#[test]
fn numbers_come_back_to_the_last_bit() {
    let mut setup = file(DEMO);
    for (index, taught) in setup.taught_poses.iter_mut().enumerate() {
        taught.pose.x_mm += 0.1 / (1.0 + f64::from(u32::try_from(index).unwrap()));
        taught.pose.r_deg = -1e-300;
    }
    for form in [Form::Toml, Form::Json] {
        let exported = write_setup(&setup, form);
        assert_eq!(parse_setup(exported.as_bytes(), form).unwrap(), setup);
    }
}

fn wrong(text: &str, form: Form) -> Vec<String> {
    match parse_setup(text.as_bytes(), form).unwrap_err() {
        DocumentError::Shape(errors) => errors
            .violations()
            .iter()
            .map(|found| format!("{}: {}", found.item, found.message))
            .collect(),
        error @ DocumentError::Syntax { .. } => vec![error.to_string()],
    }
}

#[test]
fn everything_that_does_not_fit_is_told_of_at_once() {
    let text = with(DEMO, "tool = 1\n", "tool = \"one\"\n");
    let text = with(&text, "kind = \"WORK\"", "kind = \"PLAY\"");
    let text = with(&text, "approach_mm = 150\n", "approach_cm = 15\n");
    let text = with(&text, "name = \"Demo cell\"", "name = 7\ncolor = \"blue\"");
    let wrong = wrong(&text, Form::Toml);
    for begin in [
        "arms[0].tool: ",
        "zones[0].kind: ",
        "taught_poses[0].",
        "name: ",
        "color: is no section of a set-up",
    ] {
        assert!(
            wrong.iter().any(|line| line.starts_with(begin)),
            "{begin}: {wrong:#?}"
        );
    }
    assert_eq!(wrong.len(), 5, "{wrong:#?}");
}

#[test]
fn m11_a_callback_address_is_no_part_of_a_set_up() {
    let text = with(
        DEMO,
        "home = \"warehouse/gate\"",
        "push_url = \"http://evil.example/\"",
    );
    let wrong = wrong(&text, Form::Toml);
    assert!(
        wrong[0].starts_with("mobile_robots[0].push_url: unknown field `push_url`"),
        "{wrong:?}"
    );
}

#[test]
fn a_list_is_no_object_whose_keys_were_left_out() {
    let pose = "pose = { x_mm = 500, y_mm = 1000, z_mm = 650, w_deg = 180, p_deg = 0, r_deg = 90 }";
    let text = with(DEMO, pose, "pose = [500, 1000, 650, 180, 0, 90]");
    let said = wrong(&text, Form::Toml);
    assert_eq!(
        said,
        ["taught_poses[0].pose: invalid type: array, expected an object with named values"]
    );
    let json = r#"{"format": 1, "routes": [["a", "b/c", "d/e", "ONE_WAY", null, []]]}"#;
    assert_eq!(
        wrong(json, Form::Json),
        ["routes[0]: invalid type: array, expected an object with named values"]
    );
    assert!(!wrong("[1]", Form::Json).is_empty());
}

#[test]
fn doubled_keys_missing_keys_and_broken_texts_are_refused() {
    let json = r#"{"format": 1, "name": "a", "name": "b"}"#;
    assert!(wrong(json, Form::Json)[0].contains("duplicate field `name`"));
    assert!(wrong("format = 1\nformat = 1", Form::Toml)[0].contains("duplicate key"));
    assert_eq!(wrong("{}", Form::Json), ["format: is missing; it is 1"]);
    let said = wrong("format = 1\n[[zones]\n", Form::Toml);
    assert!(said[0].contains("line 2"), "{said:?}");
    for text in [
        "",
        "{",
        "{\"format\": 1}}",
        "null",
        "\u{feff}{\"format\": 1}",
    ] {
        assert!(parse_setup(text.as_bytes(), Form::Json).is_err(), "{text}");
    }
    assert!(parse_setup(b"format = 1\nname = \"\xff\"", Form::Toml).is_err());
    let deep = format!("{{\"format\": {}", "[".repeat(100_000));
    assert!(parse_setup(deep.as_bytes(), Form::Json).is_err());
    let deep = format!("format = {}", "[".repeat(100_000));
    assert!(parse_setup(deep.as_bytes(), Form::Toml).is_err());
}
