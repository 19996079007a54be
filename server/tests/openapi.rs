//! `openapi.yaml` at the root of the repository is what the routes say.

use std::path::Path;

#[test]
fn openapi_yaml_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../openapi.yaml");
    let current = server::openapi_yaml().unwrap();
    if std::env::var_os("UPDATE_OPENAPI").is_some() {
        std::fs::write(&path, &current).unwrap();
        return;
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    let differing = committed
        .lines()
        .zip(current.lines())
        .enumerate()
        .find(|(_, (committed, current))| committed != current);
    assert!(
        committed == current,
        "openapi.yaml is not what the routes say (first difference: {differing:?}); run `cargo xtask openapi`"
    );
}
