//! Entries `[robots.NAME.inputs]` and `[robots.NAME.outputs]`.

use core::time::Duration;

use mrroc_core::cell::{InputSetup, OutputSetup};
use mrroc_core::robot::{ANALOG, Channel, DIGITAL, Value as SignalValue};
use toml::de::{DeTable, DeValue};

use super::{Reader, Value};

pub(in super::super) const INPUT_KEYS: [&str; 3] = ["channel", "follows", "after_ms"];
pub(in super::super) const OUTPUT_KEYS: [&str; 4] = ["channel", "on_stop", "holds_body", "turns_tool"];

/// How a channel is written.
const CHANNEL: &str = "a channel: \"digital 0\" or \"analog 0\"";

impl Reader {
    /// Reads the named inputs of a robot.
    pub(super) fn inputs(&mut self, value: &Value<'_>) -> Vec<InputSetup> {
        self.signals(value, "inputs", |reader, name, value| {
            let Some(table) = reader.signal_table(value, &INPUT_KEYS, "an input has")? else {
                return Some(InputSetup::new(name, reader.channel(value)?));
            };
            let input = InputSetup::new(name, reader.channel_of(value, table)?);
            let after = table.get("after_ms").map(|value| reader.duration(value));
            let Some(follows) = table.get("follows") else {
                if let Some(value) = table.get("after_ms") {
                    let help =
                        "write follows = \"vacuum\", the output that it follows, or leave `after_ms` out";
                    let what = "`after_ms` of an input that follows no output".to_owned();
                    reader.complain(&value.span(), what, help.to_owned());
                }
                return Some(input);
            };
            let output = reader.text(follows, "the name of an output of the robot, in quotes")?;
            Some(input.follows(output, after.map_or(Some(Duration::ZERO), |after| after)?))
        })
    }

    /// Reads the named outputs of a robot.
    pub(super) fn outputs(&mut self, value: &Value<'_>) -> Vec<OutputSetup> {
        self.signals(value, "outputs", |reader, name, value| {
            let Some(table) = reader.signal_table(value, &OUTPUT_KEYS, "an output has")? else {
                return Some(OutputSetup::new(name, reader.channel(value)?));
            };
            let mut output = OutputSetup::new(name, reader.channel_of(value, table)?);
            let says = |reader: &mut Reader, key: &str| match table.get(key) {
                Some(value) => reader.truth(value, "true or false").is_some_and(|truth| truth.value),
                None => false,
            };
            if says(reader, "holds_body") {
                output = output.holds_body();
            }
            if says(reader, "turns_tool") {
                output = output.turns_tool();
            }
            if let Some(value) = table.get("on_stop") {
                let on_stop = match value.get_ref() {
                    DeValue::Boolean(on) => SignalValue::Digital(*on),
                    _ => SignalValue::Analog(reader.number(value, "true, false or a number")?.value),
                };
                output = output.on_stop(on_stop);
            }
            Some(output)
        })
    }

    /// Reads the signals of a table, in the order of the file.
    fn signals<T>(
        &mut self,
        value: &Value<'_>,
        key: &str,
        mut read: impl FnMut(&mut Reader, &str, &Value<'_>) -> Option<T>,
    ) -> Vec<T> {
        let DeValue::Table(table) = value.get_ref() else {
            self.wrong_type(value, &format!("a table of {key}"));
            return Vec::new();
        };
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(name, _)| name.span().start);
        entries.into_iter().filter_map(|(name, value)| read(self, name.get_ref(), value)).collect()
    }

    /// The table of a signal; nothing where a channel alone is written. `None`: it is neither.
    fn signal_table<'t>(
        &mut self,
        value: &'t Value<'_>,
        keys: &[&str],
        has: &str,
    ) -> Option<Option<&'t DeTable<'t>>> {
        match value.get_ref() {
            DeValue::String(_) => Some(None),
            DeValue::Table(table) => {
                self.known(table, keys, has);
                Some(Some(table))
            }
            _ => {
                self.wrong_type(value, CHANNEL);
                None
            }
        }
    }

    fn channel_of(&mut self, value: &Value<'_>, table: &DeTable<'_>) -> Option<Channel> {
        let Some(channel) = table.get("channel") else {
            self.complain(
                &value.span(),
                "it has no `channel`".to_owned(),
                "write channel = \"digital 0\", or \"analog 0\"".to_owned(),
            );
            return None;
        };
        self.channel(channel)
    }

    fn channel(&mut self, value: &Value<'_>) -> Option<Channel> {
        let text = self.text(value, CHANNEL)?;
        let read = || {
            let (kind, number) = text.split_once(' ')?;
            let number: u8 = number.trim().parse().ok()?;
            match kind {
                "digital" if usize::from(number) < DIGITAL => Some(Channel::Digital(number)),
                "analog" if usize::from(number) < ANALOG => Some(Channel::Analog(number)),
                _ => None,
            }
        };
        let channel = read();
        if channel.is_none() {
            let help = format!(
                "write \"digital 0\" to \"digital {}\", or \"analog 0\" to \"analog {}\"",
                DIGITAL - 1,
                ANALOG - 1
            );
            self.complain(&value.span(), format!("no channel `{text}`"), help);
        }
        channel
    }
}
