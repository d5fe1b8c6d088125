//! Tables `[sensors.NAME.external]`.

use core::time::Duration;
use std::net::SocketAddr;
use std::rc::Rc;

use mrroc_core::fault::Name;
use mrroc_core::sensor::VspMode;
use toml::de::DeValue;

use super::super::error::At;
use super::super::external::ExternalEntry;
use super::{Reader, Value};

pub(in super::super) const EXTERNAL_KEYS: [&str; 7] =
    ["port", "address", "rate_hz", "least", "largest", "per_second", "topic"];

/// What the sensor's own table says that matters here.
pub(super) struct Around<'a> {
    pub name: &'a At<String>,
    pub mode: VspMode,
    pub stale_after: Option<Duration>,
    pub step: Duration,
}

impl Reader {
    /// Reads the table, which says all that may be believed of a program that nobody has checked.
    pub(super) fn external(&mut self, value: &Value<'_>, around: &Around<'_>) -> Option<ExternalEntry> {
        let name = &around.name.value;
        let DeValue::Table(table) = value.get_ref() else {
            self.wrong_type(value, &format!("a table [sensors.{name}.external]"));
            return None;
        };
        self.known(table, &EXTERNAL_KEYS, "a sensor of a program of another has");
        let port = match table.get("port") {
            None => Some(name.clone()),
            Some(value) => {
                let port = self.text(value, "a name, in quotes");
                port.and_then(|port| match Name::new(port) {
                    Ok(port) => Some(port.as_str().to_owned()),
                    Err(bad) => {
                        self.complain(
                            &value.span(),
                            bad.to_string(),
                            "write port = \"..\" with such a name".to_owned(),
                        );
                        None
                    }
                })
            }
        };
        let address = table.get("address").map(|value| {
            let address = self.address_of_gateway(value)?;
            self.take_gateway(value, name, address).then_some(address)
        });
        let topic = table.get("topic").map(|value| {
            if let Some(address) = table.get("address") {
                let what = format!(
                    "a topic of sensor `{name}` comes by the bridge to ROS 2, which is on this machine"
                );
                self.complain(&address.span(), what, "leave `address` out".to_owned());
            }
            self.topic(value, name)
        });
        let mut required = |key: &str, example: &str| {
            let value = table.get(key);
            if value.is_none() {
                let what = format!("sensor `{name}` has a program of another, and no `{key}`");
                self.complain(&around.name.span, what, format!("write {key} = {example}"));
            }
            value
        };
        let each = "[..], a number for each number of a reading";
        let rate = required("rate_hz", "30.0, how many readings the program sends in a second");
        // A kind whose numbers have no range of their own needs neither: who makes the sensor says so.
        let has_bounds = ["least", "largest"].iter().any(|key| table.get(*key).is_some());
        let (least, largest) = if has_bounds {
            (Some(required("least", each)), Some(required("largest", each)))
        } else {
            (None, None)
        };
        let rate = rate.and_then(|value| self.rate(value));
        let mut bounds = |value| Some(self.numbers(value?, "a list of numbers")?.plain());
        let (least, largest) = (least.map(&mut bounds), largest.map(&mut bounds));
        let per_second = table.get("per_second").map(|value| bounds(Some(value)));
        if around.stale_after.is_none() {
            let what = format!("sensor `{name}` has a program of another, and no `stale_after_ms`");
            let help = "write stale_after_ms = 200 into its own table, the age at which a reading is too old to move by";
            self.complain(&around.name.span, what, help.to_owned());
        }
        if !matches!(around.mode, VspMode::NonInteractive(_)) {
            let what = format!("sensor `{name}` has a program of another, for which nobody waits");
            let help =
                "write mode = \"free running\" and period_ms = 5, or another period, into its own table";
            self.complain(&around.name.span, what, help.to_owned());
        }
        let (rate, stale_after) = (rate?, around.stale_after?);
        if stale_after.as_secs_f64() * rate.value < 1.0 {
            let what = format!("readings come every {:.1} ms and are too old sooner", 1e3 / rate.value);
            let help = format!("write stale_after_ms = {:.0} or more", (3e3 / rate.value).ceil());
            self.complain(&rate.span, what, help);
        }
        let told = |list: Option<Option<At<Vec<f64>>>>| list.map_or(Some(None), |list| list.map(Some));
        let (least, largest, per_second) = (told(least)?, told(largest)?, told(per_second)?);
        if let (Some(least), Some(largest)) = (&least, &largest) {
            let mut pairs = least.value.iter().zip(&largest.value);
            if least.value.len() == largest.value.len() && pairs.any(|(least, largest)| least > largest) {
                let what = "a number of `least` is larger than that of `largest`".to_owned();
                self.complain(&least.span, what, "write the smaller ones into `least`".to_owned());
            }
        }
        if let Some(list) = per_second.as_ref().filter(|list| list.value.iter().any(|&change| change <= 0.0))
        {
            let help = "write the most by which each number may change in a second";
            self.complain(&list.span, "a change that is not above 0".to_owned(), help.to_owned());
        }
        Some(ExternalEntry {
            source: Rc::clone(&self.source),
            name: name.clone(),
            port: port?,
            has_port: table.get("port").is_some(),
            address: address.map_or(Some(None), |address| address.map(Some))?,
            span: value.span(),
            step: around.step,
            stale_after,
            rate: rate.value,
            least,
            largest,
            per_second,
            topic: topic.map_or(Some(None), |topic| topic.map(Some))?,
        })
    }

    fn address_of_gateway(&mut self, value: &Value<'_>) -> Option<SocketAddr> {
        const ADDRESS: &str = "\"192.168.1.2:7449\", the address of the sensor's machine in the network of the program, and a port";
        let text = self.text(value, ADDRESS)?;
        let wrong = match text.parse::<SocketAddr>() {
            Err(_) => format!("`{text}` is no address of a network with a port"),
            Ok(address) if address.ip().is_unspecified() || address.port() == 0 => {
                format!("`{text}` is no address at which a program could find the sensor")
            }
            Ok(address) => return Some(address),
        };
        self.complain(&value.span(), wrong, format!("write address = {ADDRESS}"));
        None
    }

    /// Takes the address for this sensor's gateway; false, and told, if another sensor's has it.
    fn take_gateway(&mut self, value: &Value<'_>, name: &str, address: SocketAddr) -> bool {
        if let Some((other, _)) = self.gateways.iter().find(|(_, known)| *known == address) {
            let what = format!("sensor `{other}` has this address already");
            let port = address.port().checked_add(1).unwrap_or(7449);
            let help =
                format!("write a port of its own, such as \"{}\"", SocketAddr::new(address.ip(), port));
            self.complain(&value.span(), what, help);
            return false;
        }
        self.gateways.push((name.to_owned(), address));
        true
    }

    fn rate(&mut self, value: &Value<'_>) -> Option<At<f64>> {
        const RANGE: &str = "a number of readings a second from 0.1 to 1000";
        let rate = self.number(value, RANGE)?;
        if (0.1..=1e3).contains(&rate.value) {
            return Some(rate);
        }
        self.complain(&rate.span, format!("{} Hz", rate.value), format!("write {RANGE}"));
        None
    }
}

impl At<Vec<At<f64>>> {
    /// The numbers without their places.
    fn plain(self) -> At<Vec<f64>> {
        At { value: self.value.into_iter().map(|number| number.value).collect(), span: self.span }
    }
}
