//! Definitions of messages, as a bag has them beside the messages.
//!
//! In: a type. Out: its definition and those of all types that it names, as the encoding `ros2msg` of MCAP has them. Names and fields are those of
//! `common_interfaces`, `geometry2` and `rcl_interfaces` of Jazzy.

/// Types, and the text of their definitions.
const DEFINITIONS: [(&str, &str); 17] = [
    ("builtin_interfaces/Time", include_str!("../../msg/builtin_interfaces/Time.msg")),
    ("diagnostic_msgs/DiagnosticArray", include_str!("../../msg/diagnostic_msgs/DiagnosticArray.msg")),
    ("diagnostic_msgs/DiagnosticStatus", include_str!("../../msg/diagnostic_msgs/DiagnosticStatus.msg")),
    ("diagnostic_msgs/KeyValue", include_str!("../../msg/diagnostic_msgs/KeyValue.msg")),
    ("geometry_msgs/Quaternion", include_str!("../../msg/geometry_msgs/Quaternion.msg")),
    ("geometry_msgs/Transform", include_str!("../../msg/geometry_msgs/Transform.msg")),
    ("geometry_msgs/TransformStamped", include_str!("../../msg/geometry_msgs/TransformStamped.msg")),
    ("geometry_msgs/Vector3", include_str!("../../msg/geometry_msgs/Vector3.msg")),
    ("sensor_msgs/JointState", include_str!("../../msg/sensor_msgs/JointState.msg")),
    ("std_msgs/Bool", include_str!("../../msg/std_msgs/Bool.msg")),
    ("std_msgs/Float64", include_str!("../../msg/std_msgs/Float64.msg")),
    ("std_msgs/Float64MultiArray", include_str!("../../msg/std_msgs/Float64MultiArray.msg")),
    ("std_msgs/Header", include_str!("../../msg/std_msgs/Header.msg")),
    ("std_msgs/MultiArrayDimension", include_str!("../../msg/std_msgs/MultiArrayDimension.msg")),
    ("std_msgs/MultiArrayLayout", include_str!("../../msg/std_msgs/MultiArrayLayout.msg")),
    ("std_msgs/String", include_str!("../../msg/std_msgs/String.msg")),
    ("tf2_msgs/TFMessage", include_str!("../../msg/tf2_msgs/TFMessage.msg")),
];

/// The line before each definition of a type that is named.
const RULE: &str = "================================================================================";

/// The definition of a type, `package/Name`, with those of the types that it names; `None`: there is none here.
pub fn of(name: &str) -> Option<String> {
    let mut text = own(name)?.to_owned();
    let mut named = Vec::new();
    collect(name, &mut named)?;
    for name in named {
        text.push_str(&format!("{RULE}\nMSG: {name}\n{}", own(&name)?));
    }
    Some(text)
}

fn own(name: &str) -> Option<&'static str> {
    DEFINITIONS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
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
        let text = of("tf2_msgs/TFMessage").expect("a definition");
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
        assert_eq!(of("std_msgs/Color"), None);
        for (name, _) in DEFINITIONS {
            assert!(of(name).is_some(), "{name} names a type that has no definition");
        }
    }
}
