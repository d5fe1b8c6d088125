//! Nodes on loopback.

use std::net::TcpListener;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use mrroc_core::cell::{Node, Nodes};
use mrroc_core::fault::Name;
use mrroc_launch::network::{Hears, Joining, Network, Side, Wires};

use crate::Zenoh;

/// What a node has heard.
#[derive(Debug, PartialEq)]
enum Heard {
    Came(usize, Vec<u8>),
    There(usize),
    Lost(usize),
}

struct Ear(Mutex<Sender<Heard>>);

impl Ear {
    fn tell(&self, heard: Heard) {
        let _ = self.0.lock().expect("whole").send(heard);
    }
}

impl Hears for Ear {
    fn came(&self, from: usize, bytes: &[u8]) {
        self.tell(Heard::Came(from, bytes.to_vec()));
    }
    fn is_there(&self, node: usize) {
        self.tell(Heard::There(node));
    }
    fn is_lost(&self, node: usize) {
        self.tell(Heard::Lost(node));
    }
}

/// Nodes a, b and c of a test, with free ports of this machine, and a folder with their certificates.
struct Bench {
    nodes: Nodes,
    folder: PathBuf,
}

impl Bench {
    fn new(test: &str) -> Bench {
        let folder = std::env::temp_dir().join(format!("mrroc-zenoh-{}-{test}", std::process::id()));
        // Held together, so that they differ.
        let ports: Vec<_> = (0..3).map(|_| TcpListener::bind("127.0.0.1:0").expect("a port")).collect();
        let node = |(name, port): (&str, &TcpListener)| Node {
            name: Name::new(name).expect("a name"),
            address: port.local_addr().expect("an address"),
        };
        let nodes = ["a", "b", "c"].into_iter().zip(&ports).map(node).collect();
        let nodes = Nodes::new(nodes, 0, 0);
        Zenoh.certify(nodes.all(), &folder).expect("certificates");
        Bench { nodes, folder }
    }

    fn join(&self, me: usize, side: Side) -> (Box<dyn Wires>, Receiver<Heard>) {
        self.join_as(me, side, &self.nodes, self.folder.join(self.nodes.all()[me].name.as_str())).expect("joined")
    }

    fn join_as(&self, me: usize, side: Side, nodes: &Nodes, keys: PathBuf) -> Result<(Box<dyn Wires>, Receiver<Heard>), String> {
        let (tells, hears) = channel();
        let joining = Joining { nodes, me, side, keys: &keys };
        Ok((Zenoh.join(&joining, Arc::new(Ear(Mutex::new(tells))))?, hears))
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// For what must come.
const SOON: Duration = Duration::from_secs(20);
/// For what must not.
const A_WHILE: Duration = Duration::from_millis(700);

fn until(hears: &Receiver<Heard>, awaited: &Heard) {
    while hears.recv_timeout(SOON).unwrap_or_else(|_| panic!("{awaited:?} does not come")) != *awaited {}
}

#[test]
fn nodes_find_each_other_and_what_one_says_comes_in_order_and_with_its_name() {
    let bench = Bench::new("order");
    let (b, b_hears) = bench.join(1, Side::Waits);
    let (c, c_hears) = bench.join(2, Side::Waits);
    let (a, a_hears) = bench.join(0, Side::Calls);
    until(&a_hears, &Heard::There(1));
    until(&b_hears, &Heard::There(0));
    until(&c_hears, &Heard::There(0));
    for number in 0..200_u8 {
        a.send(1, &[number; 700]);
    }
    for number in 0..200_u8 {
        assert_eq!(b_hears.recv_timeout(SOON), Ok(Heard::Came(0, vec![number; 700])));
    }
    b.send(0, b"b");
    c.send(0, b"c");
    let mut came = [a_hears.recv_timeout(SOON), a_hears.recv_timeout(SOON), a_hears.recv_timeout(SOON)]
        .into_iter()
        .flatten()
        .filter(|heard| matches!(heard, Heard::Came(..)))
        .collect::<Vec<_>>();
    while came.len() < 2 {
        came.push(a_hears.recv_timeout(SOON).expect("both"));
    }
    assert!(came.contains(&Heard::Came(1, b"b".to_vec())) && came.contains(&Heard::Came(2, b"c".to_vec())));
    drop(a);
    until(&b_hears, &Heard::Lost(0));
}
