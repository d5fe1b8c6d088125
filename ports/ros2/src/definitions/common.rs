//! Definitions of messages that many have. Names and fields are those of `common_interfaces`, `geometry2` and `rcl_interfaces` of Jazzy.

const COMMON: &str = include_str!("common.msg");

/// What stands before the name of each of them, here and in the encoding `ros2msg` of MCAP.
pub const BEGINS: &str = "MSG: ";

/// Names, `package/msg/Name`, and texts of all.
pub fn common() -> impl Iterator<Item = (&'static str, &'static str)> {
    let parts = COMMON.split(BEGINS).skip(1).filter_map(|part| part.split_once('\n'));
    parts.map(|(name, text)| (name, text.trim_end()))
}
