//! Tables `[sensors.NAME.external.topic]`, and `[topics."/NAME"]`.

use std::rc::Rc;

use mrroc_core::suggestion::suggestion;
use toml::de::{DeTable, DeValue};

use super::super::topic::{Place, PublishedEntry, TopicEntry, TopicReading, TopicText};
use super::{Reader, Value};

pub(in super::super) const TOPIC_KEYS: [&str; 8] =
    ["name", "type", "reading", "stamp", "reliability", "durability", "depth", "definitions"];
pub(in super::super) const PUBLISHED_KEYS: [&str; 3] = ["reliability", "depth", "every_ms"];
const RELIABILITIES: [&str; 2] = ["best effort", "reliable"];
const DURABILITIES: [&str; 2] = ["volatile", "transient local"];

/// Messages that wait to be read, at most.
const DEEPEST: usize = 100;

impl Reader {
    /// Reads the table of the sensor of this name.
    pub(super) fn topic(&mut self, value: &Value<'_>, name: &str) -> Option<TopicEntry> {
        let DeValue::Table(table) = value.get_ref() else {
            self.wrong_type(value, &format!("a table [sensors.{name}.external.topic]"));
            return None;
        };
        self.known(table, &TOPIC_KEYS, "a topic has");
        let mut required = |key: &str, example: &str| {
            let found = table.get(key);
            if found.is_none() {
                let what = format!("sensor `{name}` has a topic, and no `{key}` of it");
                self.complain(&value.span(), what, format!("write {key} = {example}"));
            }
            found
        };
        let topic = required("name", "\"/joy_twist\", the name of the topic");
        let message = required("type", "\"geometry_msgs/msg/TwistStamped\", the type of its messages");
        let reading = required(
            "reading",
            "{ v = \"twist.linear.x\" }, for each field of a reading its path in a message",
        );
        let topic = topic.and_then(|value| {
            let text = self.topic_text(value, "the name of a topic, in quotes")?;
            if is_topic(&text.text) {
                return Some(text);
            }
            let what = format!("`{}` is no whole name of a topic", text.text);
            let help = "write a name that begins with /, of letters, digits and _, such as \"/joy_twist\"";
            self.complain(&value.span(), what, help.to_owned());
            None
        });
        let message = message.and_then(|value| {
            let text = self.topic_text(value, "the type of a message, in quotes")?;
            let parts: Vec<_> = text.text.split('/').collect();
            if let [package, "msg", kind] = parts[..]
                && [package, kind].into_iter().all(is_word)
            {
                return Some(text);
            }
            let what = format!("`{}` is no type of a message", text.text);
            let help = "write PACKAGE/msg/NAME, such as \"geometry_msgs/msg/TwistStamped\"";
            self.complain(&value.span(), what, help.to_owned());
            None
        });
        let reading = reading.and_then(|value| self.topic_reading(value));
        let mut optional =
            |key: &str, expected: &str| table.get(key).map(|value| self.topic_text(value, expected));
        let stamp = optional("stamp", "the path of a time in the message, in quotes");
        let definitions = optional("definitions", "a folder, in quotes");
        let reliable = self.choice(table, "reliability", &RELIABILITIES, false);
        let kept = self.choice(table, "durability", &DURABILITIES, false);
        let depth = self.depth(table, 1);
        let told = |text: Option<Option<TopicText>>| text.map_or(Some(None), |text| text.map(Some));
        Some(TopicEntry {
            source: Rc::clone(&self.source),
            name: topic?,
            message: message?,
            reading: reading?,
            stamp: told(stamp)?,
            reliable: reliable?,
            kept: kept?,
            depth: depth?,
            definitions: told(definitions)?,
        })
    }

    /// Reads the tables `[topics."/NAME"]`.
    pub(super) fn published(&mut self, table: &DeTable<'_>) -> Vec<PublishedEntry> {
        let Some(value) = table.get("topics") else { return Vec::new() };
        let DeValue::Table(named) = value.get_ref() else {
            self.wrong_type(value, "tables [topics.\"/NAME\"]");
            return Vec::new();
        };
        let mut published = Vec::new();
        for (name, value) in named {
            let DeValue::Table(table) = value.get_ref() else {
                self.wrong_type(value, "a table [topics.\"/NAME\"]");
                continue;
            };
            self.known(table, &PUBLISHED_KEYS, "a topic that the bridge publishes has");
            let reliable = self.choice(table, "reliability", &RELIABILITIES, true);
            let depth = self.depth(table, DEEPEST);
            let every = table.get("every_ms").map_or(Some(None), |value| self.duration(value).map(Some));
            if let (Some(reliable), Some(depth), Some(every)) = (reliable, depth, every) {
                let source = Rc::clone(&self.source);
                let name = TopicText { text: name.get_ref().to_string(), at: Place(name.span()) };
                published.push(PublishedEntry { source, name, reliable, depth, every });
            }
        }
        published
    }

    /// Whether a key has the second one of two values.
    fn choice(&mut self, table: &DeTable<'_>, key: &str, choices: &[&str; 2], default: bool) -> Option<bool> {
        let Some(value) = table.get(key) else { return Some(default) };
        let text = self.text(value, &format!("\"{}\" or \"{}\"", choices[0], choices[1]))?;
        let found = choices.iter().position(|choice| *choice == text);
        if found.is_none() {
            let what = format!("no {key} `{text}`");
            self.complain(&value.span(), what, suggestion(text, choices, "there are"));
        }
        found.map(|place| place == 1)
    }

    fn depth(&mut self, table: &DeTable<'_>, default: usize) -> Option<usize> {
        let Some(value) = table.get("depth") else { return Some(default) };
        let range = format!("a whole number of messages from 1 to {DEEPEST}");
        let depth = self.number(value, &range)?;
        self.whole(&depth, 1..=DEEPEST, &range)
    }

    fn topic_text(&mut self, value: &Value<'_>, expected: &str) -> Option<TopicText> {
        let text = self.text(value, expected)?.to_owned();
        Some(TopicText { text, at: Place(value.span()) })
    }

    /// A path, a table of fields, or a list of values.
    fn topic_reading(&mut self, value: &Value<'_>) -> Option<TopicReading> {
        let place = Place(value.span());
        match value.get_ref() {
            DeValue::String(text) => {
                Some(TopicReading::Path(TopicText { text: text.to_string(), at: place }))
            }
            DeValue::Table(table) => {
                let fields: Vec<_> = table
                    .iter()
                    .map(|(name, value)| {
                        let name = TopicText { text: name.get_ref().to_string(), at: Place(name.span()) };
                        Some((name, self.topic_reading(value)?))
                    })
                    .collect();
                Some(TopicReading::Fields(fields.into_iter().collect::<Option<_>>()?, place))
            }
            DeValue::Array(array) => {
                let items: Vec<_> = array.iter().map(|item| self.topic_reading(item)).collect();
                Some(TopicReading::Items(items.into_iter().collect::<Option<_>>()?, place))
            }
            DeValue::Integer(_) | DeValue::Float(_) | DeValue::Boolean(_) | DeValue::Datetime(_) => {
                self.wrong_type(
                    value,
                    "the path of a field in the message, in quotes, or a table of such paths",
                );
                None
            }
        }
    }
}

/// A letter, then letters, digits and underscores.
fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Whether ROS 2 has this as the whole name of a topic.
fn is_topic(text: &str) -> bool {
    let is_part = |part: &str| {
        part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    text.strip_prefix('/').is_some_and(|text| text.split('/').all(is_part) && text.len() < 240)
}

#[cfg(test)]
mod tests {
    use core::time::Duration;

    use crate::cell_file::{CellFile, TopicReading};

    fn file(topic: &str) -> Result<CellFile, String> {
        let text = format!(
            "step_ms = 2\n[robots.arm]\nkind = \"irp6\"\n[sensors.joy]\nmode = \"free running\"\nperiod_ms = 4\n\
             stale_after_ms = 100\n[sensors.joy.external]\nrate_hz = 30.0\nleast = [-1.0]\nlargest = [1.0]\n{topic}"
        );
        CellFile::parse("cell.toml", &text).map_err(|error| error.to_string())
    }

    const WHOLE: &str = "[sensors.joy.external.topic]\nname = \"/joy\"\ntype = \"sensor_msgs/msg/Joy\"\n\
                         reading = { v = \"axes[1]\", on = [\"buttons[0]\", \"buttons[3]\"], at.x = \"axes[0]\" }\n";

    #[test]
    fn the_table_says_which_part_of_a_message_is_which_of_a_reading_and_has_the_qualities_that_all_publishers_offer()
     {
        let file = file(WHOLE).expect("nothing is wrong with it");
        let (external, topic) = file.topics().next().expect("one");
        assert_eq!((external.name(), topic.name().text.as_str()), ("joy", "/joy"));
        assert_eq!(topic.message().text, "sensor_msgs/msg/Joy");
        assert_eq!((topic.is_reliable(), topic.is_transient_local(), topic.depth()), (false, false, 1));
        assert!(topic.stamp().is_none() && topic.definitions().is_none());
        let TopicReading::Fields(fields, _) = topic.reading() else { panic!("{:?}", topic.reading()) };
        let told: Vec<_> = fields.iter().map(|(name, of)| (name.text.as_str(), of)).collect();
        assert!(
            matches!(
                told[..],
                [
                    ("at", TopicReading::Fields(..)),
                    ("on", TopicReading::Items(..)),
                    ("v", TopicReading::Path(_)),
                ]
            ),
            "{told:?}"
        );
    }

    #[test]
    fn what_the_bridge_publishes_is_reliable_and_whole_unless_the_table_of_its_topic_says_otherwise() {
        let file = |text: &str| {
            CellFile::parse("cell.toml", &format!("step_ms = 2\nrobots.arm.kind = \"irp6\"\n{text}"))
        };
        let text =
            "[topics.\"/a\"]\nreliability = \"best effort\"\ndepth = 5\nevery_ms = 20\n[topics.\"/b\"]\n";
        let file_of_two = file(text).expect("nothing is wrong with it");
        let found = file_of_two
            .published()
            .iter()
            .map(|topic| (topic.name().text.as_str(), topic.is_reliable(), topic.depth(), topic.every()));
        let every = Some(Duration::from_millis(20));
        assert_eq!(found.collect::<Vec<_>>(), [("/a", false, 5, every), ("/b", true, 100, None)]);
        for (wrong, told) in [
            ("topics = 1", "tables [topics.\"/NAME\"]"),
            ("topics.a = 1", "a table [topics.\"/NAME\"]"),
            ("[topics.\"/a\"]\ndurability = \"volatile\"", "unknown key `durability`"),
            ("[topics.\"/a\"]\nreliability = \"never\"", "no reliability `never`"),
            ("[topics.\"/a\"]\ndepth = 101", "101 is out of range"),
            ("[topics.\"/a\"]\nevery_ms = 0", "0 ms"),
        ] {
            let error = file(wrong).expect_err(told).to_string();
            assert!(error.contains(told), "{told}: {error}");
        }
    }

    #[test]
    fn what_is_wrong_with_a_topic_is_named_with_what_to_write() {
        for (wrong, with, told, help) in [
            ("name = \"/joy\"\n", "", "has a topic, and no `name` of it", "write name = \"/joy_twist\""),
            ("\"/joy\"", "\"joy\"", "`joy` is no whole name of a topic", "begins with /"),
            ("\"/joy\"", "\"/joy//x\"", "is no whole name of a topic", "begins with /"),
            ("sensor_msgs/msg/Joy", "sensor_msgs/Joy", "`sensor_msgs/Joy` is no type", "PACKAGE/msg/NAME"),
            ("sensor_msgs/msg/Joy", "../msg/Joy", "is no type of a message", "PACKAGE/msg/NAME"),
            ("\"axes[1]\"", "1", "a integer where the path of a field", "in quotes"),
            (
                "\n[",
                "\nreliability = \"relaible\"\n[",
                "no reliability `relaible`",
                "did you mean `reliable`?",
            ),
            // Spellings of other programs.
            (
                "\n[",
                "\nreliability = \"best_effort\"\n[",
                "no reliability `best_effort`",
                "did you mean `best effort`?",
            ),
            (
                "\n[",
                "\nreliability = \"RELIABLE\"\n[",
                "no reliability `RELIABLE`",
                "did you mean `reliable`?",
            ),
            (
                "\n[",
                "\ndurability = \"TRANSIENT_LOCAL\"\n[",
                "no durability `TRANSIENT_LOCAL`",
                "did you mean `transient local`?",
            ),
            ("\n[", "\ndurability = true\n[", "a boolean where \"volatile\" or \"transient local\"", "write"),
            ("\n[", "\ndepth = 0\n[", "0 is out of range", "from 1 to 100"),
            ("\n[", "\nqos = 1\n[", "unknown key `qos`", "a topic has"),
        ] {
            let text = match wrong {
                "\n[" => format!("{WHOLE}{}", with.trim_end_matches('[')),
                _ => WHOLE.replace(wrong, with),
            };
            let error = file(&text).expect_err(told);
            assert!(error.contains(told) && error.contains(help), "{told}: {error}");
        }
        let elsewhere = format!("address = \"127.0.0.1:7449\"\n{WHOLE}");
        let error = file(&elsewhere).expect_err("the bridge is on this machine");
        assert!(error.contains("comes by the bridge to ROS 2, which is on this machine"), "{error}");
    }
}
