//! The script that runs on the controller, and takes a position from this machine in every period.
//!
//! In: where to call, and how to follow. Out: the text in URScript; and back, for a controller in tests.
//!
//! It calls this machine and reads [set-points](crate::SetPoint). A step for which none has come goes on at the speed of the one before.
//! When none has come for the read timeout, which is in every set-point, it says so, brakes all joints together by `stopj`, and
//! ends. Its first lines say in comments what its parameters are. It is sent to the controller as a program of its own, or asked for by
//! a program node of UR's External Control URCap, which puts its header and its control loop into a program of the pendant.

use core::time::Duration;
use std::net::SocketAddr;

use mrroc::robot::Outputs;

use crate::outputs;

/// Why the script ended, as it says itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Ended {
    /// No set-point came in time.
    Timeout = 1,
    /// It was asked to.
    Asked = 2,
}

impl Ended {
    /// Bytes of what it says.
    pub const BYTES: usize = 4;

    /// Reads what it says; `None` if that is something else.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<Ended> {
        match i32::from_be_bytes(bytes.try_into().ok()?) {
            1 => Some(Ended::Timeout),
            2 => Some(Ended::Asked),
            _ => None,
        }
    }

    /// Its bytes.
    #[must_use]
    pub const fn bytes(self) -> [u8; Self::BYTES] {
        (self as i32).to_be_bytes()
    }
}

/// The script and its parameters.
///
/// ```
/// use mrroc_ur::Script;
///
/// let script = Script::new("192.168.1.2:50001".parse()?, 9.0);
/// assert!(script.text().contains(r#"socket_open("192.168.1.2", 50001, "mrroc")"#));
/// assert_eq!(Script::read(&script.text()), Some(script));
/// # Ok::<(), std::net::AddrParseError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Script {
    /// Where it calls.
    pub reverse: SocketAddr,
    /// How hard `stopj` brakes the joint that is fastest, and the others with it [rad/s²], > 0.
    pub deceleration: f64,
    /// `lookahead_time` of `servoj`, which smooths its path: 0.03 to 0.2 s.
    pub lookahead: Duration,
    /// `gain` of `servoj`: 100 to 2000.
    pub gain: f64,
    /// What outputs take when no set-point has come for the read timeout; the others hold.
    pub when_lost: Outputs,
}

/// The text, with a place for each parameter.
const TEXT: &str = include_str!("script.urscript");

/// The line that says whose script it is.
const MARK: &str = "# mrroc-ur 1";

impl Script {
    /// With UR's own usual `lookahead_time` of 0.03 s and `gain` of 2000.
    #[must_use]
    pub const fn new(reverse: SocketAddr, deceleration: f64) -> Script {
        let lookahead = Duration::from_millis(30);
        Script { reverse, deceleration, lookahead, gain: 2000.0, when_lost: Outputs::NONE }
    }

    /// The text for the controller.
    #[must_use]
    pub fn text(&self) -> String {
        TEXT.replace("@ADDRESS@", &self.reverse.ip().to_string())
            .replace("@PORT@", &self.reverse.port().to_string())
            .replace("@LOOKAHEAD@", &self.lookahead.as_secs_f64().to_string())
            .replace("@GAIN@", &self.gain.to_string())
            .replace("@STOPJ@", &self.deceleration.to_string())
            .replace("@WHEN_LOST@", &outputs::written(&self.when_lost))
            .replace("@SWITCH@", &outputs::switched(&self.when_lost))
    }

    /// The text for a program node that asks for it: what is within the program of [`text`](Self::text).
    #[must_use]
    pub fn node_text(&self) -> String {
        let text = self.text();
        // The first line begins the program, the last one ends it.
        let within = text.split_once('\n').and_then(|(_, rest)| rest.trim_end().rsplit_once('\n'));
        within.map_or(String::new(), |(within, _)| format!("{within}\n"))
    }

    /// The parameters, from the first lines of a text; `None` if it is not this script, or a parameter is none.
    #[must_use]
    pub fn read(text: &str) -> Option<Script> {
        let mut lines = text.lines().map(str::trim).skip_while(|line| *line != MARK).skip(1);
        let mut words = |name: &str| {
            let words: Vec<_> = lines.next()?.strip_prefix("# ")?.split_whitespace().collect();
            (words.first() == Some(&name)).then_some(words)
        };
        let positive =
            |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
        let reverse = words("reverse")?;
        let [_, ip, port] = reverse[..] else { return None };
        let reverse = SocketAddr::new(ip.parse().ok()?, port.parse().ok()?);
        let servo = words("servoj")?;
        let [_, "lookahead_time", lookahead, "gain", gain] = servo[..] else { return None };
        let stop = words("stopj")?;
        let [_, deceleration] = stop[..] else { return None };
        let when_lost = outputs::read(&words("when_lost")?[1..])?;
        let lookahead = positive(lookahead).filter(|seconds| *seconds < 1.0).map(Duration::from_secs_f64)?;
        let (deceleration, gain) = (positive(deceleration)?, positive(gain)?);
        Some(Script { reverse, deceleration, lookahead, gain, when_lost })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc::robot::{Channel, Value};

    #[test]
    fn the_text_has_no_place_left_and_gives_its_parameters_back() {
        let reverse = "10.0.0.2:50001".parse().expect("an address");
        let off = |outputs: Outputs, number| outputs.with(Channel::Digital(number), Value::Digital(false));
        let when_lost = off(off(Outputs::NONE, 1), 9).with(Channel::Digital(17), Value::Digital(true));
        let lookahead = Duration::from_millis(100);
        let when_lost = when_lost.with(Channel::Analog(1), Value::Analog(0.25));
        let script = Script { gain: 300.0, lookahead, when_lost, ..Script::new(reverse, 4.5) };
        let text = script.text();
        assert!(!text.contains('@'), "{text}");
        assert!(text.contains("lookahead_time=0.1, gain=300)") && text.contains("stopj(4.5)"), "{text}");
        for switched in [
            "set_standard_digital_out(1, False)",
            "set_configurable_digital_out(1, False)",
            "set_tool_digital_out(1, True)",
            "set_standard_analog_out(1, 0.25)",
        ] {
            assert_eq!(text.matches(switched).count(), 1, "{switched}");
        }
        assert_eq!(Script::read(&text), Some(script));
        let node = script.node_text();
        assert!(!node.contains("def ") && node.trim_start().starts_with("# HEADER_BEGIN\n"), "{node}");
        assert!(node.ends_with("# NODE_CONTROL_LOOP_ENDS\n"), "{node}");
        assert_eq!(Script::read(&node), Some(script));
        // Blocks are closed: every one of these words ends with an `end`.
        let begins =
            |line: &str| ["def ", "thread ", "while ", "if "].iter().any(|word| line.starts_with(word));
        let lines = || text.lines().map(str::trim);
        assert_eq!(
            lines().filter(|line| begins(line)).count(),
            lines().filter(|line| *line == "end").count()
        );
    }

    #[test]
    fn another_script_and_one_with_parameters_that_are_none_are_not_taken_for_it() {
        let reverse = "10.0.0.2:50001".parse().expect("an address");
        let text = Script::new(reverse, 4.5).text();
        assert_eq!(Script::read("def other():\n  movej([0,0,0,0,0,0])\nend\n"), None);
        for (from, to) in [
            ("# stopj 4.5", "# stopj -1"),
            ("# stopj 4.5", "# stopj nan"),
            ("# reverse 10.0.0.2", "# reverse home"),
            ("gain 2000", "gain"),
            ("# when_lost", "# when_lost 18 off"),
            ("# when_lost", "# when_lost 1 maybe"),
            ("# when_lost", "# when_lost analog2 0.5"),
            ("# when_lost", "# when_lost analog0 1.5"),
            ("# mrroc-ur 1", "# mrroc-ur 2"),
        ] {
            assert_eq!(Script::read(&text.replacen(from, to, 1)), None, "{to}");
        }
    }
}
