//! The operator's set-up through the real `cellctl` binary and the library, against the real server.

use std::path::Path;
use std::process::{Command, Output};

use api::setup::{CalibrationBody, PlaceBody, SetupCheck, SetupRevision};
use client::{ClientError, SetupForm, SetupText};
use tests::TestCell;

const DEMO: &str = include_str!("../../cell/demo.setup.toml");

/// What a run left behind: exit code, standard output, standard error.
async fn cellctl(
    cell: &TestCell,
    arguments: &[&str],
) -> anyhow::Result<(Option<i32>, String, String)> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cellctl"));
    let _ = command
        .env_clear()
        .args(["--server", &format!("http://{}", cell.server_address())])
        .args(arguments);
    let Output {
        status,
        stdout,
        stderr,
    } = tokio::task::spawn_blocking(move || command.output()).await??;
    Ok((
        status.code(),
        String::from_utf8(stdout)?,
        String::from_utf8(stderr)?,
    ))
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap_or("a path of the test is not UTF-8")
}

#[tokio::test]
async fn an_operator_checks_imports_shows_teaches_and_exports() -> anyhow::Result<()> {
    let cell = TestCell::start().await?;
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("demo.setup.toml");
    std::fs::write(&file, DEMO)?;
    let demo = path(&file);

    let (code, said, wrong) = cellctl(&cell, &["cell", "check", demo]).await?;
    assert_eq!((code, &*wrong), (Some(0), ""), "{said}");
    assert!(said.contains("Every taught pose can be reached"), "{said}");
    assert!(said.contains("rack-frame"), "{said}");

    let (code, said, wrong) = cellctl(&cell, &["cell", "import", demo]).await?;
    assert_eq!((code, &*wrong), (Some(0), ""), "{said}");
    assert!(said.starts_with("Revision 2 holds now; changed:"), "{said}");
    let (_, said, _) = cellctl(&cell, &["cell", "import", demo]).await?;
    assert!(
        said.starts_with("Nothing was changed: revision 2"),
        "{said}"
    );

    let (code, said, _) = cellctl(&cell, &["cell", "show"]).await?;
    assert_eq!(code, Some(0));
    assert!(said.contains("handover/front, warehouse/gate"), "{said}");
    assert!(said.contains("rack/a"), "{said}");

    // The seed's controller reports no position.
    let (code, _, wrong) = cellctl(&cell, &["teach", "rack/a"]).await?;
    assert_eq!(code, Some(1));
    assert!(wrong.contains("reports no position"), "{wrong}");
    let teach = "teach rack/a --lift-mm 120 --configuration NUT000 --pose 490 1000 650 180 0 90";
    let teach: Vec<_> = teach.split(' ').collect();
    let (code, said, wrong) = cellctl(&cell, &teach).await?;
    assert_eq!((code, &*wrong), (Some(0), ""), "{said}");
    assert!(said.contains("Taught rack/a for r1."), "{said}");

    let json = folder.path().join("out.json");
    let (code, said, _) = cellctl(&cell, &["cell", "export", "--output", path(&json)]).await?;
    assert_eq!(code, Some(0), "{said}");
    assert!(std::fs::read_to_string(&json)?.contains("\"x_mm\": 490.0"));
    let (_, said, _) = cellctl(&cell, &["--json", "cell", "import", path(&json)]).await?;
    let revision: SetupRevision = serde_json::from_str(&said)?;
    assert_eq!((revision.revision, revision.changed.len()), (3, 0));
    let (_, said, _) = cellctl(&cell, &["cell", "export"]).await?;
    assert!(said.contains("[[taught_poses]]"), "{said}");
    cell.shutdown().await
}

#[tokio::test]
async fn what_does_not_fit_or_would_not_work_is_exit_code_1_with_everything_wrong()
-> anyhow::Result<()> {
    let cell = TestCell::start().await?;
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("bad.setup.toml");
    let bad = DEMO
        .replacen("zone = \"front\"", "zone = \"back\"", 1)
        .replacen("approach_mm = 150", "approach_mm = 0", 1);
    std::fs::write(&file, bad)?;
    let (code, said, wrong) = cellctl(&cell, &["cell", "import", path(&file)]).await?;
    assert_eq!((code, &*said), (Some(1), ""));
    assert!(wrong.contains("stations[0].points[0].zone"), "{wrong}");
    assert!(
        wrong.contains("taught_poses[0].approach_mm = 0 (limits 1 to 1000)"),
        "{wrong}"
    );

    let far = DEMO.replacen("x_mm = 500, y_mm = 1000", "x_mm = 2500, y_mm = 1000", 1);
    std::fs::write(&file, far)?;
    let (code, said, _) = cellctl(&cell, &["cell", "check", path(&file)]).await?;
    assert_eq!(code, Some(1));
    assert!(said.contains("Wrong: taught-poses/r1/rack/a: "), "{said}");
    let (code, said, _) = cellctl(&cell, &["--json", "cell", "check", path(&file)]).await?;
    let check: SetupCheck = serde_json::from_str(&said)?;
    assert_eq!((code, check.passed), (Some(1), false));

    let absent = folder.path().join("absent.toml");
    let (code, _, wrong) = cellctl(&cell, &["cell", "check", path(&absent)]).await?;
    assert_eq!(code, Some(2), "{wrong}");
    cell.shutdown().await
}

#[tokio::test]
async fn two_programs_never_overwrite_each_other_unnoticed() -> anyhow::Result<()> {
    let cell = TestCell::start().await?;
    let setup = cell.client().setup("demo");
    let empty = setup.get().await?;
    let text = SetupText {
        form: SetupForm::Toml,
        text: DEMO.to_owned(),
    };
    let imported = setup.import(text.clone(), &empty.etag).await?;
    let Err(ClientError::Problem(problem)) = setup.import(text, &empty.etag).await else {
        anyhow::bail!("a change based on an old revision was made");
    };
    assert_eq!(problem.code, api::ProblemCode::PreconditionFailed);
    let at = ["places", "rack/f"];
    let place = setup.part::<PlaceBody>(&at).await?;
    assert_eq!(place.etag, imported.etag);
    let named = PlaceBody {
        name: Some("Last one".to_owned()),
        ..place.value
    };
    let changed = setup.put_part(&at, &named, &place.etag).await?;
    assert_eq!(changed.changed, ["places/rack/f"]);
    let Err(ClientError::Problem(problem)) = setup.delete_part(&at, &changed.etag).await else {
        anyhow::bail!("a place with a taught pose was deleted");
    };
    assert_eq!(problem.code, api::ProblemCode::StillReferenced);
    let taught = ["taught-poses", "r1", "rack/f"];
    let changed = setup.delete_part(&taught, &changed.etag).await?;
    let _gone = setup.delete_part(&at, &changed.etag).await?;
    let none = CalibrationBody {
        points: Vec::new(),
        max_residual_mm: None,
    };
    let Err(ClientError::Problem(problem)) = setup.calibrate("r1", 1, &none).await else {
        anyhow::bail!("a tool was found from nothing");
    };
    assert_eq!(problem.code, api::ProblemCode::CalibrationRefused);
    cell.shutdown().await
}
