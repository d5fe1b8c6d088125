//! UR's own script for control from outside, and the program node that asks for one.
//!
//! In: the text of a script, or where to ask for one. Out: what is done of UR's script here, or the text as the node gives it to its program.
//!
//! UR's script is not interpreted. It is recognised by the three connections that it opens, and of what it can do the set-points of joint
//! positions are followed (`servoj`), which is the same for the script of `mrroc-ur`; other modes are not done.

use core::time::Duration;
use std::net::SocketAddr;

use mrroc_ur::Script;

/// What the node says when its program is started.
pub(crate) const ASKS: &[u8] = b"request_program\n";

/// Periods for which the node waits for more of a line: 500 ms.
const LINE: u32 = 250;

/// The most bytes of a script.
const MOST: usize = 256 * 1024;

/// UR's script: how it follows set-points, and what else it connects to before it does.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct External {
    pub script: Script,
    pub others: [SocketAddr; 2],
}

impl External {
    /// Reads it; `None` if it is not UR's.
    pub(crate) fn read(text: &str) -> Option<External> {
        let socket = |name: &str| {
            text.lines().find_map(|line| {
                let (_, call) = line.split_once("connect_socket_with_retry(\"")?;
                let mut parts = call.split('"');
                let (ip, port, of) = (parts.next()?, parts.next()?, parts.next()?);
                let port = port.trim_matches([',', ' ']).parse().ok()?;
                (of == name).then_some(SocketAddr::new(ip.parse().ok()?, port))
            })
        };
        let number = |before: &str| {
            let (_, rest) = text.split_once(before)?;
            let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.'))?;
            rest[..end].parse().ok().filter(|number: &f64| *number > 0.0)
        };
        let others = [socket("trajectory_socket")?, socket("script_command_socket")?];
        let script = Script::new(socket("reverse_socket")?, number("STOPJ_ACCELERATION = ")?);
        let lookahead = number("lookahead_time=").filter(|seconds| *seconds < 1.0)?;
        let (lookahead, gain) = (Duration::from_secs_f64(lookahead), number("gain=")?);
        Some(External { script: Script { lookahead, gain, ..script }, others })
    }
}

/// A node that has asked for a script.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Asking {
    came: usize,
    /// Periods in which nothing came.
    periods: u32,
}

/// What has come of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Answered {
    NotYet,
    /// Nobody says anything, in time.
    Nothing,
    /// The part of the text that the node takes over.
    Script(String),
}

impl Asking {
    /// Looks at all that `came`, once in a period. The node waits for whole lines, and reads on while there is something.
    pub(crate) fn poll(&mut self, came: &[u8], is_open: bool) -> Answered {
        if came.last() == Some(&b'\n') || came.len() > MOST || !is_open {
            return Answered::Script(taken_over(&String::from_utf8_lossy(came)));
        }
        self.periods = if came.len() > self.came { 0 } else { self.periods + 1 };
        self.came = came.len();
        if self.periods > LINE { Answered::Nothing } else { Answered::NotYet }
    }
}

/// What the node takes of a text, each line behind a space: from the line that begins the header on, where there is a header; otherwise all.
fn taken_over(text: &str) -> String {
    let lines = || text.lines().map(|line| format!(" {line}\n"));
    let is = |line: &str, anchor: &str| line.trim() == anchor;
    if lines().any(|line| is(&line, "# HEADER_BEGIN")) && lines().any(|line| is(&line, "# HEADER_END")) {
        lines().skip_while(|line| !is(line, "# HEADER_BEGIN")).collect()
    } else {
        lines().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_of_ur_is_known_by_its_connections_and_no_other_is() {
        let text = "STOPJ_ACCELERATION = 4.0\ndef connect_socket_with_retry(host, port, name):\nend\n\
                    servoj(q, t=steptime, lookahead_time=0.03, gain=2000)\n\
                    f = connect_socket_with_retry(\"10.0.0.2\", 50003, \"trajectory_socket\")\n\
                    g = connect_socket_with_retry(\"10.0.0.2\", 50004, \"script_command_socket\")\n\
                    h = connect_socket_with_retry(\"10.0.0.2\", 50001, \"reverse_socket\")\n";
        let read = External::read(text).expect("it is UR's");
        let address = |port: u16| SocketAddr::new([10, 0, 0, 2].into(), port);
        assert_eq!(read.others, [address(50003), address(50004)]);
        let Script { reverse, deceleration, lookahead, gain, .. } = read.script;
        assert_eq!((reverse, deceleration, gain), (address(50001), 4.0, 2000.0));
        assert_eq!(lookahead, Duration::from_millis(30));
        assert_eq!(External::read(&text.replace("50001", "home")), None);
        assert_eq!(External::read(&Script::new(address(1), 9.0).text()), None);
    }

    #[test]
    fn a_node_waits_for_the_rest_of_a_line_for_half_a_second() {
        let mut asking = Asking::default();
        let mut polls = (0..).map(|_| asking.poll(b"a line\nand a ", true));
        // The first look finds something new.
        assert!(polls.by_ref().take(251).all(|answered| answered == Answered::NotYet));
        assert_eq!(polls.next(), Some(Answered::Nothing));
        let taken = Answered::Script(" a line\n and a half\n".to_owned());
        for (came, is_open) in [("a line\nand a half\n", true), ("a line\nand a half", false)] {
            assert_eq!(Asking::default().poll(came.as_bytes(), is_open), taken);
        }
    }

    #[test]
    fn a_node_takes_what_follows_the_beginning_of_the_header() {
        let text = "a\n# HEADER_BEGIN\nb\n# HEADER_END\nc\n";
        assert_eq!(taken_over(text), " # HEADER_BEGIN\n b\n # HEADER_END\n c\n");
        assert_eq!(taken_over("a\nb"), " a\n b\n");
    }
}
