//! The gateway of a sensor: where the program that sends its readings calls from another machine.
//!
//! In: what the sensor's process sends. Out: what a program with the certificate of that one sensor has sent, and which
//! programs are there: each declares a token with a number of its own. Which of them is believed is the sensor's to say.

use std::sync::Arc;

use mrroc_launch::network::{Gateway, GatewayListener, GatewayPort};
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::SampleKind;
use zenoh::{Config, Wait};

use crate::access::{GatewayKeys, at_gateway};
use crate::certificates::{Files, gateway};
use crate::session::{ClosingInBackground, endpoint, settings};

/// A gateway, as long as it lives.
pub(crate) struct Open(ClosingInBackground<Endpoints>);

struct Endpoints {
    orders: Publisher<'static>,
    _subscribers: [Subscriber<()>; 2],
}

impl GatewayPort for Open {
    fn send(&self, bytes: &[u8]) {
        // What cannot be sent is lost, as it would be in a cable.
        let _ = self.0.parts().map(|endpoints| endpoints.orders.put(bytes).wait());
    }
}

/// Opens a gateway.
pub(crate) fn open(asked: &Gateway<'_>, hears: Arc<dyn GatewayListener>) -> Result<Open, String> {
    let Gateway { sensor, address, keys } = *asked;
    let files = Files::of(&gateway(sensor), keys, "NODE, or FOLDER/cell of a cell without nodes,")?;
    let endpoint = endpoint(address);
    let config = settings(&[endpoint], &[], at_gateway(sensor), &files).to_string();
    let config = Config::from_json5(&config).map_err(|error| error.to_string())?;
    let session = zenoh::open(config).wait().map_err(|error| {
        format!("sensor {sensor} cannot wait at {address}: {error}\n help: is it this machine's address, and free?")
    })?;
    let failed = |error: zenoh::Error| format!("the gateway of sensor {sensor}: {error}");
    let keys = GatewayKeys::of(sensor);
    // An order that the network does not take is dropped: the next one is newer.
    let orders = session.declare_publisher(keys.orders).congestion_control(CongestionControl::Drop);
    let orders = orders.priority(Priority::RealTime).express(true).wait().map_err(failed)?;
    let heard = Arc::clone(&hears);
    let listens = session.declare_subscriber(keys.readings);
    let listens = listens.callback(move |sample| heard.came(&sample.payload().to_bytes()));
    let words = listens.wait().map_err(failed)?;
    let looks = session.liveliness().declare_subscriber(format!("{}/*", keys.programs)).history(true);
    let looks = looks.callback(move |sample| {
        let number = sample.key_expr().as_str().rsplit('/').next().and_then(|last| last.parse().ok());
        match (number, sample.kind()) {
            (Some(program), SampleKind::Put) => hears.is_there(program),
            (Some(program), SampleKind::Delete) => hears.is_lost(program),
            (None, _) => {}
        }
    });
    let there = looks.wait().map_err(failed)?;
    Ok(Open(ClosingInBackground::new(Endpoints { orders, _subscribers: [words, there] }, session)))
}
