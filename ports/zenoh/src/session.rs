//! A node's session: one QUIC connection to each node that it speaks to.
//!
//! In: what is to be sent. Out: what has come, and who is there. The launcher's node calls the others, which wait at their
//! addresses; nobody is looked for, no router is between them, and what comes for another node is passed on by none. A node
//! that says nothing for 300 ms is lost. Messages are not collected (express), and the transport is zenoh's
//! low-latency one, which sends in the calling thread: the carrier's, and never that of a step.

use std::fmt::Display;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::Duration;

use mrroc_core::cell::Nodes;
use mrroc_launch::network::{JoinOptions, NodeListener, Side, Wires};
use serde_json::{Value, json};
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::SampleKind;
use zenoh::{Config, Session, Wait};

use crate::access::{alive, control, sent};
use crate::certificates::Files;

/// What nodes and gateways speak below zenoh: QUIC, which is encrypted by TLS 1.3 over UDP. zenoh's other transport with certificates, TLS
/// over TCP, reads and writes one state of rustls from two threads at once (zenoh's issue 2557): messages vanish, and programs crash.
const PROTOCOL: &str = "quic";

/// The endpoint at an address, for [`settings`].
pub(crate) fn endpoint(address: impl Display) -> String {
    format!("{PROTOCOL}/{address}")
}

/// After so long without a word a node is lost \[ms\].
const LEASE_MS: u64 = 300;

/// How often a node that is not there is called again, at first and at most \[ms\].
const CALL_MS: u64 = 200;
const CALL_MOST_MS: u64 = 1000;

/// How long a session may take to say farewell. zenoh itself takes 10 s for it where a cable is pulled, and as long again for each
/// word that waits for a peer that takes none: the end of the process says the same.
const FAREWELL: Duration = Duration::from_secs(1);

/// The connections to the other nodes, as long as it lives.
pub(crate) struct Zenoh(ClosingInBackground<Endpoints>);

/// What is closed in a thread of its own, which is waited for no longer than [`FAREWELL`].
pub(crate) struct ClosingInBackground<P: Send + 'static> {
    parts: Option<P>,
    session: Session,
}

impl<P: Send + 'static> ClosingInBackground<P> {
    /// What a session has declared, and the session.
    pub fn new(parts: P, session: Session) -> ClosingInBackground<P> {
        ClosingInBackground { parts: Some(parts), session }
    }

    /// What the session has declared.
    pub const fn parts(&self) -> Option<&P> {
        self.parts.as_ref()
    }
}

impl<P: Send + 'static> Drop for ClosingInBackground<P> {
    fn drop(&mut self) {
        let (parts, session) = (self.parts.take(), self.session.clone());
        let (tells, told) = channel();
        let closing = std::thread::Builder::new().name("closes".to_owned()).spawn(move || {
            // A session that is closed twice, or whose connections are gone, has nothing left to close.
            let _ = session.close().wait();
            drop(parts);
            let _ = tells.send(());
        });
        if closing.is_ok() {
            let _ = told.recv_timeout(FAREWELL);
        }
    }
}

struct Endpoints {
    /// By the nodes' places; none to itself.
    publishers: Vec<Option<Publisher<'static>>>,
    _subscribers: Vec<Subscriber<()>>,
    _token: LivelinessToken,
}

impl Wires for Zenoh {
    fn send(&self, to: usize, bytes: &[u8]) {
        let publisher = self.0.parts().and_then(|endpoints| endpoints.publishers.get(to)?.as_ref());
        if let Some(publisher) = publisher {
            // What cannot be sent is lost, as it would be in a cable.
            let _ = publisher.put(bytes).wait();
        }
    }
}

/// Joins a node to the others.
pub(crate) fn join(joining: &JoinOptions<'_>, hears: Arc<dyn NodeListener>) -> Result<Zenoh, String> {
    let JoinOptions { nodes, me, side, keys } = *joining;
    let Some(own) = nodes.all().get(me) else { return Err("no such node".to_owned()) };
    let name = own.name.as_str();
    let files = Files::of(name, keys, name).map_err(|error| format!("node {error}"))?;
    let config = Config::from_json5(&config(nodes, me, side, &files).to_string())
        .map_err(|error| error.to_string())?;
    let session = zenoh::open(config).wait().map_err(|error| {
        format!(
            "node {name} cannot wait at {}: {error}\n help: is it this machine's address, and is node {name} running already?",
            own.address
        )
    })?;
    let failed = |error: zenoh::Error| format!("node {name} cannot join: {error}");
    let mut subscribers = Vec::new();
    let mut publishers = Vec::new();
    for (place, other) in nodes.all().iter().enumerate() {
        if place == me {
            publishers.push(None);
            continue;
        }
        let other = other.name.as_str();
        let publisher = session
            .declare_publisher(sent(name, other))
            .congestion_control(CongestionControl::Block)
            .priority(Priority::RealTime)
            .express(true);
        publishers.push(Some(publisher.wait().map_err(failed)?));
        let heard = Arc::clone(&hears);
        let listens = session
            .declare_subscriber(sent(other, name))
            .callback(move |sample| heard.came(place, &sample.payload().to_bytes()));
        subscribers.push(listens.wait().map_err(failed)?);
        let heard = Arc::clone(&hears);
        let looks =
            session.liveliness().declare_subscriber(alive(other)).history(true).callback(move |sample| {
                match sample.kind() {
                    SampleKind::Put => heard.is_there(place),
                    SampleKind::Delete => heard.is_lost(place),
                }
            });
        subscribers.push(looks.wait().map_err(failed)?);
    }
    let token = session.liveliness().declare_token(alive(name)).wait().map_err(failed)?;
    Ok(Zenoh(ClosingInBackground::new(
        Endpoints { publishers, _subscribers: subscribers, _token: token },
        session,
    )))
}

/// zenoh's configuration of a node.
fn config(nodes: &Nodes, me: usize, side: Side, files: &Files) -> Value {
    let all = || nodes.all().iter().enumerate();
    let own: Vec<_> =
        all().filter(|(place, _)| *place == me).map(|(_, node)| endpoint(node.address)).collect();
    let others: Vec<_> =
        all().filter(|(place, _)| *place != me).map(|(_, node)| endpoint(node.address)).collect();
    let (listen, connect) = match side {
        Side::Calls => (Vec::new(), others),
        Side::Waits => (own, Vec::new()),
    };
    let name = nodes.all()[me].name.as_str();
    let others = nodes.all().iter().map(|node| node.name.as_str()).filter(|other| *other != name);
    settings(&listen, &connect, control(name, others), files)
}

/// zenoh's configuration of who waits at these places, or calls those, and lets in what `access` says.
pub(crate) fn settings(listen: &[String], connect: &[String], access: Value, files: &Files) -> Value {
    let path = |path: &Path| path.to_string_lossy().into_owned();
    json!({
        "mode": "peer",
        "listen": { "endpoints": listen, "exit_on_failure": true },
        "connect": {
            "endpoints": connect,
            "timeout_ms": -1,
            "exit_on_failure": false,
            "retry": { "period_init_ms": CALL_MS, "period_max_ms": CALL_MOST_MS, "period_increase_factor": 2 },
        },
        "scouting": { "multicast": { "enabled": false }, "gossip": { "enabled": false } },
        "timestamping": { "enabled": false },
        "transport": {
            "unicast": { "lowlatency": true, "qos": { "enabled": false }, "accept_pending": 16, "max_links": 1 },
            "link": {
                "protocols": [PROTOCOL],
                "tx": { "lease": LEASE_MS, "keep_alive": 4 },
                "tls": {
                    "root_ca_certificate": path(&files.authority),
                    "listen_private_key": path(&files.key),
                    "listen_certificate": path(&files.certificate),
                    "connect_private_key": path(&files.key),
                    "connect_certificate": path(&files.certificate),
                    "enable_mtls": true,
                    "verify_name_on_connect": true,
                    // zenoh 1.10 panics when a low-latency link that watches its certificate is closed from both sides.
                    "close_link_on_expiration": false,
                },
            },
        },
        "access_control": access,
    })
}
