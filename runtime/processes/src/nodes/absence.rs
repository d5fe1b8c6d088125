//! Why a node does not answer: nobody is at its address, or somebody else is.
//!
//! In: a node, and whether the network has found it. Out: the reason, and what to do about it.

use std::io::{self, ErrorKind};
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use mrroc_core::cell::Node;

/// How often it is asked who is at an address, because a datagram may be lost, and how long each answer may take.
const ASKED: usize = 3;
const LOOK: Duration = Duration::from_millis(350);

/// Length of a datagram to which every server of QUIC answers \[bytes\] (RFC 9000, section 14.1).
const DATAGRAM: usize = 1200;

/// Why a node has not answered, and what to do.
pub(super) fn absent(node: &Node, is_there: bool) -> String {
    let (name, address) = (node.name.as_str(), node.address);
    if is_there {
        return format!("node {name} at {address} does not answer\n help: is its machine too busy?");
    }
    match ask(address) {
        Ok(()) => format!(
            "who answers at {address} is not node {name} of this cell: its certificate or this node's was made by another authority, or \
             for another name or address, or it is another program\n help: make certificates for all nodes at once, PROGRAM certificates \
             FOLDER, and copy each node's own to it"
        ),
        Err(error) => format!(
            "node {name} is not there: nobody answers at {address}: {error}\n help: start it on its machine: PROGRAM node {name}"
        ),
    }
}

/// Asks who is at an address for a version of QUIC that does not exist: every server answers with those that it speaks (RFC 9000,
/// section 6), and needs no certificate of the asker for that.
fn ask(address: SocketAddr) -> io::Result<()> {
    let here: SocketAddr = if address.is_ipv4() { ([0; 4], 0).into() } else { ([0; 16], 0).into() };
    let socket = UdpSocket::bind(here)?;
    socket.connect(address)?;
    socket.set_read_timeout(Some(LOOK))?;
    // A long header, a version that is reserved for this purpose (section 15), and two names of connections, of eight bytes each.
    let mut asks = [0; DATAGRAM];
    asks[..6].copy_from_slice(&[0xc0, 0x0a, 0x1a, 0x2a, 0x3a, 8]);
    asks[14] = 8;
    let mut answer = [0; DATAGRAM];
    for _ in 0..ASKED {
        socket.send(&asks)?;
        match socket.recv(&mut answer) {
            // A long header of version 0: the versions that it speaks.
            Ok(length) if length >= 5 && answer[0] & 0x80 != 0 && answer[1..5] == [0; 4] => return Ok(()),
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::new(ErrorKind::TimedOut, "no answer within a second"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_core::fault::Name;

    fn node(address: SocketAddr) -> Node {
        Node { name: Name::new("b").expect("a name"), address }
    }

    #[test]
    fn fault_213_an_address_where_nobody_is_or_nobody_speaks_quic_is_told_apart_from_a_stranger() {
        let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        let address = socket.local_addr().expect("an address");
        let silent = absent(&node(address), false);
        assert!(
            silent.contains("nobody answers at") && silent.contains("no answer within a second"),
            "{silent}"
        );
        // Somebody who answers as RFC 9000 has it, in section 17.2.1.
        let answers = std::thread::spawn(move || {
            let mut asked = [0; 2000];
            // What was asked in vain before, and once more.
            for _ in 0..=ASKED {
                let (length, from) = socket.recv_from(&mut asked).expect("asked");
                assert_eq!((length, asked[0] & 0x80), (DATAGRAM, 0x80));
                assert!(asked[1..5].iter().all(|byte| byte & 0x0f == 0x0a), "not a reserved version");
                socket
                    .send_to(&[0x80, 0, 0, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1], from)
                    .expect("sent");
            }
        });
        let stranger = absent(&node(address), false);
        assert!(stranger.contains("is not node b of this cell: its certificate"), "{stranger}");
        answers.join().expect("answered");
        // Its socket is closed by now.
        let nobody = absent(&node(address), false);
        assert!(
            nobody.contains("nobody answers at")
                && nobody.contains("refused")
                && nobody.contains("PROGRAM node b"),
            "{nobody}"
        );
    }
}
