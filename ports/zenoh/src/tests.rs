//! Nodes on loopback.

use std::net::UdpSocket;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use mrroc_core::cell::{Node, Nodes};
use mrroc_core::fault::Name;
use mrroc_launch::network::{
    CertificateRequest, Gateway, GatewayListener, JoinOptions, Network, NodeListener, Side, Wires,
};
use zenoh::Wait;

use crate::Zenoh;
use crate::certificates::Files;

/// What a node has heard.
#[derive(Debug, PartialEq)]
enum Heard {
    Came(usize, Vec<u8>),
    There(usize),
    Lost(usize),
}

struct Listener(Mutex<Sender<Heard>>);

impl Listener {
    fn tell(&self, heard: Heard) {
        let _ = self.0.lock().expect("whole").send(heard);
    }
}

impl NodeListener for Listener {
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
        let ports: Vec<_> = (0..3).map(|_| UdpSocket::bind("127.0.0.1:0").expect("a port")).collect();
        let node = |(name, port): (&str, &UdpSocket)| Node {
            name: Name::new(name).expect("a name"),
            address: port.local_addr().expect("an address"),
        };
        let nodes = ["a", "b", "c"].into_iter().zip(&ports).map(node).collect();
        let nodes = Nodes::new(nodes, 0, 0);
        let gateways =
            vec![("camera", nodes.all()[2].address, Some("c")), ("laser", nodes.all()[1].address, Some("b"))];
        Zenoh.certify(&CertificateRequest { nodes: nodes.all(), gateways }, &folder).expect("certificates");
        Bench { nodes, folder }
    }

    fn join(&self, me: usize, side: Side) -> (Box<dyn Wires>, Receiver<Heard>) {
        self.join_as(me, side, &self.nodes, self.folder.join(self.nodes.all()[me].name.as_str()))
            .expect("joined")
    }

    fn join_as(
        &self,
        me: usize,
        side: Side,
        nodes: &Nodes,
        keys: PathBuf,
    ) -> Result<(Box<dyn Wires>, Receiver<Heard>), String> {
        let (tells, hears) = channel();
        let joining = JoinOptions { nodes, me, side, keys: &keys };
        Ok((Zenoh.join(&joining, Arc::new(Listener(Mutex::new(tells))))?, hears))
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
    let mut awaited = vec![Heard::Came(1, b"b".to_vec()), Heard::Came(2, b"c".to_vec())];
    while !awaited.is_empty() {
        let came = a_hears.recv_timeout(SOON).expect("both");
        awaited.retain(|awaited| *awaited != came);
    }
    drop(a);
    until(&b_hears, &Heard::Lost(0));
}

/// Everything that has come until nothing comes for a while.
fn all(hears: &Receiver<Heard>) -> Vec<Heard> {
    std::iter::from_fn(|| hears.recv_timeout(A_WHILE).ok()).collect()
}

#[test]
fn fault_143_a_node_with_a_valid_certificate_that_speaks_for_another_node_is_not_heard() {
    let bench = Bench::new("impostor");
    let (_c, c_hears) = bench.join(2, Side::Waits);
    // Node b's machine says that it is a: it joins at the place of a, with the certificate of b under a's name.
    let keys = bench.folder.join("stolen");
    std::fs::create_dir(&keys).expect("a folder");
    for (from, to) in [("b/authority.pem", "authority.pem"), ("b/b.pem", "a.pem"), ("b/b.key", "a.key")] {
        std::fs::copy(bench.folder.join(from), keys.join(to)).expect("copied");
    }
    let (impostor, _hears) = bench.join_as(0, Side::Calls, &bench.nodes, keys).expect("joined");
    for _ in 0..50 {
        impostor.send(2, b"go");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(all(&c_hears), [], "c has heard b as a");
    drop(impostor);
    // The same words, said by a itself, are heard.
    let (a, a_hears) = bench.join(0, Side::Calls);
    until(&a_hears, &Heard::There(2));
    a.send(2, b"go");
    until(&c_hears, &Heard::Came(0, b"go".to_vec()));
}

#[test]
fn fault_141_who_has_a_certificate_of_another_authority_or_for_another_name_is_no_node() {
    let (bench, other) = (Bench::new("ours"), Bench::new("theirs"));
    let (_b, b_hears) = bench.join(1, Side::Waits);
    // Node a of a cell of the same names, with an authority of its own, calls ours.
    let foreign = other.folder.join("a");
    let (foreigner, hears) = bench.join_as(0, Side::Calls, &bench.nodes, foreign).expect("joined");
    foreigner.send(1, b"go");
    assert_eq!((all(&hears), all(&b_hears)), (vec![], vec![]));
    drop(foreigner);
    // Our a calls at the address of b, where a node with the certificate of c waits.
    drop(_b);
    let keys = bench.folder.join("swapped");
    std::fs::create_dir(&keys).expect("a folder");
    for (from, to) in [("c/authority.pem", "authority.pem"), ("c/c.pem", "b.pem"), ("c/c.key", "b.key")] {
        std::fs::copy(bench.folder.join(from), keys.join(to)).expect("copied");
    }
    let (swapped, _hears) = bench.join_as(1, Side::Waits, &bench.nodes, keys).expect("joined");
    let (a, a_hears) = bench.join(0, Side::Calls);
    for _ in 0..20 {
        swapped.send(0, b"here I am");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(all(&a_hears), [], "a has heard c as b");
    drop(a);
}

#[test]
fn fault_144_an_address_that_is_taken_is_told_and_who_has_it_is_not_disturbed() {
    let bench = Bench::new("twice");
    let (_b, b_hears) = bench.join(1, Side::Waits);
    let keys = bench.folder.join("b");
    let second = bench.join_as(1, Side::Waits, &bench.nodes, keys).map(drop).expect_err("taken");
    assert!(second.contains("node b cannot wait at ") && second.contains(" help: "), "{second}");
    let (a, a_hears) = bench.join(0, Side::Calls);
    until(&a_hears, &Heard::There(1));
    a.send(1, b"x");
    until(&b_hears, &Heard::Came(0, b"x".to_vec()));
}

#[test]
fn keys_are_their_owners_alone_and_one_that_others_may_read_is_refused() {
    use std::os::unix::fs::PermissionsExt;

    let bench = Bench::new("keys");
    let mode = |file: &std::path::Path| file.metadata().expect("there").permissions().mode() & 0o777;
    for file in ["authority.key", "a/a.key", "b/b.key"] {
        assert_eq!(mode(&bench.folder.join(file)), 0o600, "{file}");
    }
    assert_eq!(mode(&bench.folder.join("a")), 0o700);
    assert!(!bench.folder.join("a/authority.key").exists(), "a node could make certificates");
    let key = bench.folder.join("b/b.key");
    std::fs::set_permissions(&key, std::fs::Permissions::from_mode(0o640)).expect("changed");
    let refused =
        bench.join_as(1, Side::Waits, &bench.nodes, bench.folder.join("b")).map(drop).expect_err("refused");
    assert!(refused.contains("its mode is 640") && refused.contains("chmod 600"), "{refused}");
    let none =
        bench.join_as(1, Side::Waits, &bench.nodes, bench.folder.join("a")).map(drop).expect_err("none");
    assert!(none.contains("node b has no ") && none.contains("certificates FOLDER"), "{none}");
    // No certificate is written over another one.
    let whom = CertificateRequest { nodes: bench.nodes.all(), gateways: Vec::new() };
    assert!(Zenoh.certify(&whom, &bench.folder).is_err());
}

#[test]
fn fault_146_a_node_that_is_gone_is_told_and_found_again() {
    let bench = Bench::new("gone");
    let (b, _b_hears) = bench.join(1, Side::Waits);
    let (_a, a_hears) = bench.join(0, Side::Calls);
    until(&a_hears, &Heard::There(1));
    drop(b);
    until(&a_hears, &Heard::Lost(1));
    // A connection that was closed is kept for a moment, for words that come late (RFC 9000, section 10.2), and the address with it.
    let (address, since) = (bench.nodes.all()[1].address, std::time::Instant::now());
    while UdpSocket::bind(address).is_err() {
        assert!(since.elapsed() < SOON, "the address is not free");
        std::thread::sleep(Duration::from_millis(20));
    }
    // It is called again; whether it is taken in again is not the network's to say.
    let (_b, _b_hears) = bench.join(1, Side::Waits);
    until(&a_hears, &Heard::There(1));
}

/// Who is held up where it hears, as by a word that it has to say to a peer that takes none.
struct HeldUp {
    told: Mutex<Sender<()>>,
    until: Mutex<Receiver<()>>,
}

impl NodeListener for HeldUp {
    fn came(&self, _: usize, _: &[u8]) {
        let _ = self.told.lock().expect("whole").send(());
        let _ = self.until.lock().expect("whole").recv();
    }
    fn is_there(&self, _: usize) {}
    fn is_lost(&self, _: usize) {}
}

#[test]
fn fault_159_a_node_that_is_held_up_by_the_network_has_ended_soon() {
    let bench = Bench::new("farewell");
    let (b, b_hears) = bench.join(1, Side::Waits);
    let ((tells, told), (_holds, until_then)) = (channel(), channel());
    let held_up = HeldUp { told: Mutex::new(tells), until: Mutex::new(until_then) };
    let keys = bench.folder.join("a");
    let joining = JoinOptions { nodes: &bench.nodes, me: 0, side: Side::Calls, keys: &keys };
    let a = Zenoh.join(&joining, Arc::new(held_up)).expect("joined");
    until(&b_hears, &Heard::There(0));
    b.send(0, b"x");
    told.recv_timeout(SOON).expect("a hears it");
    // While it is held up: without a limit of its own this would not end, as who holds it up waits for the end of this test.
    drop(a);
}

/// Who hears at a gateway.
struct GatewayRecorder(Mutex<Sender<AtGateway>>);

#[derive(Debug, PartialEq)]
enum AtGateway {
    Came(Vec<u8>),
    There(u64),
    Lost(u64),
}

impl GatewayListener for GatewayRecorder {
    fn came(&self, bytes: &[u8]) {
        let _ = self.0.lock().expect("whole").send(AtGateway::Came(bytes.to_vec()));
    }
    fn is_there(&self, program: u64) {
        let _ = self.0.lock().expect("whole").send(AtGateway::There(program));
    }
    fn is_lost(&self, program: u64) {
        let _ = self.0.lock().expect("whole").send(AtGateway::Lost(program));
    }
}

/// A program that calls an address with a certificate of a folder, as Python would.
fn program(bench: &Bench, (folder, name): (&str, &str), place: usize) -> zenoh::Session {
    let files = Files::of(name, &bench.folder.join(folder), folder).expect("certificates");
    let endpoint = crate::session::endpoint(bench.nodes.all()[place].address);
    let open = serde_json::json!({ "enabled": false });
    let config = crate::session::settings(&[], &[endpoint], open, &files).to_string();
    zenoh::open(zenoh::Config::from_json5(&config).expect("a configuration")).wait().expect("a session")
}

#[test]
fn fault_211_the_certificate_of_a_sensors_program_is_taken_by_the_gateway_of_that_sensor_and_nothing_else() {
    let bench = Bench::new("gateway");
    let (tells, hears) = channel();
    let listener = Arc::new(GatewayRecorder(Mutex::new(tells)));
    let keys = bench.folder.join("c");
    let gateway = Gateway { sensor: "camera", address: bench.nodes.all()[2].address, keys: &keys };
    let gateway = Zenoh.open_gateway(&gateway, listener).expect("opened");
    let says = |session: &zenoh::Session, who: u64| {
        let token = session.liveliness().declare_token(format!("mrroc/@sensor/camera/@program/{who}")).wait();
        for _ in 0..25 {
            session.put("mrroc/@sensor/camera/readings", who.to_le_bytes()).wait().expect("put");
            std::thread::sleep(Duration::from_millis(20));
        }
        token
    };
    // A node's certificate, the one of another sensor's program, that of a gateway.
    let strangers = [("b", "b"), ("sensor.laser", "sensor.laser"), ("b", "door.laser")]
        .map(|who| program(&bench, who, 2));
    let _tokens =
        strangers.iter().enumerate().map(|(who, session)| says(session, who as u64 + 1)).collect::<Vec<_>>();
    assert_eq!(hears.recv_timeout(A_WHILE), Err(std::sync::mpsc::RecvTimeoutError::Timeout));
    let camera = program(&bench, ("sensor.camera", "sensor.camera"), 2);
    let (orders, ordered) = channel();
    let listens = camera.declare_subscriber("mrroc/@sensor/camera/orders").callback(move |sample| {
        let _ = orders.send(sample.payload().to_bytes().to_vec());
    });
    let _listens = listens.wait().expect("declared");
    let _token = says(&camera, 7);
    let mut awaited = vec![AtGateway::There(7), AtGateway::Came(7_u64.to_le_bytes().to_vec())];
    while !awaited.is_empty() {
        let heard = hears.recv_timeout(SOON).expect("the program of the sensor is heard");
        assert!(
            heard == AtGateway::There(7) || heard == AtGateway::Came(7_u64.to_le_bytes().to_vec()),
            "{heard:?}"
        );
        awaited.retain(|awaited| *awaited != heard);
    }
    let sent = std::time::Instant::now();
    while ordered.recv_timeout(Duration::from_millis(20)) != Ok(b"order".to_vec()) {
        assert!(sent.elapsed() < SOON, "no order comes");
        gateway.send(b"order");
    }
    // At a node it is nobody.
    let (_b, b_hears) = bench.join(1, Side::Waits);
    let at_node = program(&bench, ("sensor.camera", "sensor.camera"), 1);
    let _alive = at_node.liveliness().declare_token("mrroc/@alive/a").wait();
    for _ in 0..25 {
        at_node.put("mrroc/a/b", b"go".as_slice()).wait().expect("put");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(all(&b_hears), [], "node b has heard the program of a sensor");
    camera.close().wait().expect("closed");
    while hears.recv_timeout(SOON).expect("it is gone") != AtGateway::Lost(7) {}
}
