//! UR's own script for control from outside, and the program node that asks for one.
//!
//! In: the text of a script, or where to ask for one. Out: what is done of UR's script here, or the text as the node gives it to its program.
//!
//! UR's script is not interpreted. It is recognised by the three connections that it opens, and of what it can do the set-points of joint
//! positions are followed (`servoj`), which is the same for the script of `mrroc-ur`; other modes are not done.

use core::time::Duration;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};

use mrroc_ur::Script;

/// How long the node waits for its call to be answered, and for a line.
const CALL: Duration = Duration::from_secs(5);
const LINE: Duration = Duration::from_millis(500);

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

/// Asks for a script as the node of UR's URCap does when its program is started, and gives the part of it that the node takes over.
///
/// # Errors
/// Nobody is there, or says nothing in time.
pub(crate) fn ask(at: SocketAddr) -> io::Result<String> {
    let mut stream = TcpStream::connect_timeout(&at, CALL)?;
    stream.set_read_timeout(Some(LINE))?;
    stream.write_all(b"request_program\n")?;
    let (mut came, mut bytes) = (Vec::new(), [0; 4096]);
    // It waits for whole lines, and reads on while there is something.
    while came.len() <= MOST {
        match stream.read(&mut bytes) {
            Ok(0) => break,
            Ok(length) => came.extend_from_slice(&bytes[..length]),
            Err(why) if why.kind() == ErrorKind::WouldBlock && came.last() == Some(&b'\n') => break,
            Err(why) => return Err(why),
        }
        stream.set_nonblocking(came.last() == Some(&b'\n'))?;
    }
    Ok(taken_over(&String::from_utf8_lossy(&came)))
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
    fn a_node_takes_what_follows_the_beginning_of_the_header() {
        let text = "a\n# HEADER_BEGIN\nb\n# HEADER_END\nc\n";
        assert_eq!(taken_over(text), " # HEADER_BEGIN\n b\n # HEADER_END\n c\n");
        assert_eq!(taken_over("a\nb"), " a\n b\n");
    }
}
