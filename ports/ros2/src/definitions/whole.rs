//! Definitions as a bag has them beside its messages.
//!
//! In: a type. Out: its definition and those of all types that it names, as the encoding `ros2msg` of MCAP has them.

use super::common::{BEGINS, common};
use super::message::{Line, Named, whole_name};

/// The line before each definition of a type that is named.
const RULE: &str = "================================================================================";

/// The definition of a type, `package/Name`, with those of the types that it names; `None`: there is none here.
pub fn with_named(name: &str) -> Option<String> {
    let (package, kind) = name.split_once('/')?;
    let name = format!("{package}/msg/{kind}");
    let mut text = format!("{}\n", own(&name)?);
    let mut named = Vec::new();
    collect(&name, &mut named)?;
    for name in named {
        text.push_str(&format!("{RULE}\n{BEGINS}{}\n{}\n", name.replace("/msg/", "/"), own(&name)?));
    }
    Some(text)
}

fn own(name: &str) -> Option<&'static str> {
    common().find(|(known, _)| *known == name).map(|(_, text)| text)
}

/// The types that a type names, and those that these name, each once.
fn collect(name: &str, named: &mut Vec<String>) -> Option<()> {
    let package = name.split('/').next()?;
    for line in own(name)?.lines() {
        let Some(Line { item: Named::Message(message), .. }) = Line::of(line).ok()? else { continue };
        let whole = whole_name(package, message)?;
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
