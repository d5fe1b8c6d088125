//! Checks that every crate of the workspace is tested.

use std::collections::BTreeSet;
use std::path::Path;

/// `cargo test` tests the default members. A member that needs more than a Rust toolchain is none of them, and is tested
/// by a script of `.ci/peers`, or by the script `ports` that several of those share.
#[test]
fn every_member_is_a_default_member_or_has_a_script_among_the_peers() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let manifest = std::fs::read_to_string(root.join("Cargo.toml")).expect("the workspace's manifest");
    let manifest: toml::Table = manifest.parse().expect("a manifest");
    let list = |key: &str| -> BTreeSet<&str> {
        let list = manifest["workspace"][key].as_array().expect("a list");
        list.iter().map(|path| path.as_str().expect("a path")).collect()
    };
    let (members, tested) = (list("members"), list("default-members"));
    assert!(members.is_superset(&tested), "{:?} are no members", tested.difference(&members));
    let peers = std::fs::read_dir(root.join("tests/peers")).expect("the peers");
    let mut scripts: Vec<_> = peers
        .filter_map(|peer| std::fs::read_to_string(peer.expect("an entry").path().join("run")).ok())
        .collect();
    if scripts.iter().any(|script| script.contains("tests/peers/ports\n")) {
        scripts.push(std::fs::read_to_string(root.join("tests/peers/ports")).expect("a script"));
    }
    // Examples have no tests: Clippy compiles them, and peers run them.
    for member in members.difference(&tested).filter(|member| **member != "tests/examples") {
        let name = member.rsplit('/').next().expect("a name");
        let tests = format!("cargo test -p mrroc-{name}");
        let is_tested = scripts.iter().any(|script| script.contains(&tests));
        assert!(is_tested, "{member} is no default member, and no tests/peers/NAME/run has `{tests}`");
    }
}
