//! Every generator of the library keeps what a generator must keep.

mod arms;
mod combinators;
mod joints;
mod kit;
mod sensed;
mod standing;
mod tools;
mod violators;

/// Every file of the two folders is named in one of these files as a module, and its allocations are counted.
#[test]
fn every_generator_of_the_library_is_held_to_this() {
    let text = concat!(
        include_str!("arms.rs"),
        include_str!("combinators.rs"),
        include_str!("joints.rs"),
        include_str!("sensed.rs"),
        include_str!("standing.rs"),
        include_str!("tools.rs"),
    );
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/src");
    let folders = ["generators", "combinators"].map(|name| std::fs::read_dir(format!("{source}/{name}")));
    for entry in folders.into_iter().flat_map(|entries| entries.expect("a folder")) {
        let file = entry.expect("an entry").file_name().into_string().expect("a plain name");
        let Some(name) = file.strip_suffix(".rs") else { continue };
        assert!(
            ["mod", "joined"].contains(&name) || text.contains(&format!("\n    {name}: ")),
            "{name} is held to nothing"
        );
    }
    let blocks = text.matches("generator_conformance! {").count();
    assert_eq!(text.matches("    allocated: bytes,\n").count(), blocks);
}
