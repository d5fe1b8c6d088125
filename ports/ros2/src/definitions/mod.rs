//! Definitions of messages that many have, in the `.msg` language of ROS 2. Names and fields are those of `common_interfaces`, `geometry2` and
//! `rcl_interfaces` of Jazzy.
//!
//! In: a type. Out: its definition; for a bag with those of all types that it names, as the encoding `ros2msg` of MCAP has them.

/// Definitions of messages that many have.
const COMMON: &str = include_str!("common.msg");

/// What stands before the name of each of them.
const BEGINS: &str = "MSG: ";

/// The line before each definition of a type that is named.
const RULE: &str = "================================================================================";

/// Names, `package/msg/Name`, and texts of all.
pub fn common() -> impl Iterator<Item = (&'static str, &'static str)> {
    let parts = COMMON.split(BEGINS).skip(1).filter_map(|part| part.split_once('\n'));
    parts.map(|(name, text)| (name, text.trim_end()))
}

/// The definition of a type, `package/Name`, with those of the types that it names; `None`: there is none here.
pub fn with_named(name: &str) -> Option<String> {
    let mut text = format!("{}\n", own(name)?);
    let mut named = Vec::new();
    collect(name, &mut named)?;
    for name in named {
        text.push_str(&format!("{RULE}\n{BEGINS}{name}\n{}\n", own(&name)?));
    }
    Some(text)
}

fn own(name: &str) -> Option<&'static str> {
    let (package, kind) = name.split_once('/')?;
    let is_it = |known: &str| known.split('/').eq([package, "msg", kind]);
    common().find(|(known, _)| is_it(known)).map(|(_, text)| text)
}

/// The types that a type names, and those that these name, each once.
fn collect(name: &str, named: &mut Vec<String>) -> Option<()> {
    let package = name.split('/').next()?;
    for line in own(name)?.lines() {
        let of = line.split([' ', '[']).next()?;
        // A type of the same package has its bare name, and only names of types have capital letters.
        let is_bare = of.starts_with(|c: char| c.is_ascii_uppercase());
        if !is_bare && !of.contains('/') {
            continue;
        }
        let whole = if is_bare { format!("{package}/{of}") } else { of.to_owned() };
        if !named.contains(&whole) {
            named.push(whole.clone());
            collect(&whole, named)?;
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_has_those_of_all_types_that_it_names_once() {
        let text = with_named("tf2_msgs/TFMessage").expect("a definition");
        let named: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("MSG: ")).collect();
        let expected = [
            "geometry_msgs/TransformStamped",
            "std_msgs/Header",
            "builtin_interfaces/Time",
            "geometry_msgs/Transform",
            "geometry_msgs/Vector3",
            "geometry_msgs/Quaternion",
        ];
        assert_eq!(named, expected);
        assert!(text.starts_with("geometry_msgs/TransformStamped[] transforms\n====="), "{text}");
        assert_eq!(with_named("std_msgs/Color"), None);
        for (name, _) in common() {
            let name = name.replace("/msg/", "/");
            assert!(with_named(&name).is_some(), "{name} names a type that has no definition");
        }
    }
}
