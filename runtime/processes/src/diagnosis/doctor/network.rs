//! The network interfaces that robots may be connected to.
//!
//! In: what the kernel and `ethtool` say of each. Out: a line, and what to change where messages wait before they are told.

use std::fs;
use std::path::Path;
use std::process::Command;

/// How long an interface may collect messages before it interrupts \[us\]: a tenth of the period of a robot at 1 kHz.
const COLLECTS: u32 = 100;

/// What was found of one interface.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Interface {
    name: String,
    /// `up`, `down`, as the kernel says.
    state: String,
    /// \[Mbit/s\]
    speed: Option<u32>,
    /// How long it collects what has come before it interrupts \[us\]; `None` if nobody says.
    collects: Option<u32>,
    /// Whether it changes that time by itself.
    adapts: bool,
}

/// The interfaces of this machine that are hardware, or look like it.
pub(super) fn interfaces() -> Vec<Interface> {
    let entries = fs::read_dir("/sys/class/net").into_iter().flatten().flatten();
    let mut found: Vec<_> = entries
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| Path::new("/sys/class/net").join(name).join("device").exists())
        .map(|name| {
            let read = |file: &str| {
                let text = fs::read_to_string(format!("/sys/class/net/{name}/{file}"));
                text.map(|text| text.trim().to_owned()).ok()
            };
            let (state, speed) = (read("operstate").unwrap_or_default(), read("speed"));
            let said = Command::new("ethtool").args(["-c", &name]).output();
            let said = said.map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
            let (collects, adapts) = coalescing(&said.unwrap_or_default());
            // An interface without a cable says -1.
            Interface { state, speed: speed.and_then(|speed| speed.parse().ok()), collects, adapts, name }
        })
        .collect();
    found.sort_by(|a, b| a.name.cmp(&b.name));
    found
}

/// What `ethtool -c` says of how long an interface collects what comes \[us\], and whether it changes that by itself.
fn coalescing(said: &str) -> (Option<u32>, bool) {
    let value = |name: &str| {
        let line =
            said.lines().find_map(|line| line.trim().strip_prefix(name)?.trim_start().strip_prefix(':'));
        line.map(str::trim)
    };
    let adapts = said.lines().any(|line| line.contains("Adaptive RX: on"));
    (value("rx-usecs").and_then(|text| text.parse().ok()), adapts)
}

impl Interface {
    /// `up, 1000 Mbit/s, tells what comes after 3 us`.
    pub fn describe(&self) -> String {
        let speed = self.speed.map(|speed| format!(", {speed} Mbit/s")).unwrap_or_default();
        let collects = match (self.collects, self.adapts) {
            (Some(micros), false) => format!(", tells what comes after {micros} us"),
            (Some(micros), true) => format!(", tells what comes after {micros} us, or when it likes"),
            (None, _) => String::new(),
        };
        format!("{}{speed}{collects}", self.state)
    }

    /// The name, as a heading.
    pub fn heading(&self) -> String {
        format!("network {}", self.name)
    }

    /// What to change, if a robot is to be connected to it.
    pub fn change(&self) -> Option<String> {
        let waits = self.adapts || self.collects.is_some_and(|micros| micros > COLLECTS);
        waits.then(|| {
            format!(
                "for a robot at {0}, let it tell at once what comes, as root: ethtool -C {0} adaptive-rx off rx-usecs 0",
                self.name
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the program writes it, of a card with an Intel chip.
    const SAID: &str = "Coalesce parameters for enp3s0:\nAdaptive RX: off  TX: off\nstats-block-usecs:\tn/a\n\nrx-usecs:\t3\n\
                        rx-frames:\tn/a\nrx-usecs-irq:\tn/a\n\ntx-usecs:\t0\n";

    #[test]
    fn what_ethtool_says_of_coalescing_is_read_and_what_it_does_not_say_is_not() {
        assert_eq!(coalescing(SAID), (Some(3), false));
        assert_eq!(coalescing(&SAID.replace("RX: off", "RX: on")), (Some(3), true));
        assert_eq!(coalescing("netlink error: Operation not supported\n"), (None, false));
        assert_eq!(coalescing("rx-usecs:\tn/a\n"), (None, false));
    }

    #[test]
    fn an_interface_that_collects_messages_for_longer_than_a_tenth_of_a_millisecond_is_to_be_changed() {
        let card = |collects, adapts| Interface {
            name: "enp3s0".into(),
            state: "up".into(),
            speed: Some(1000),
            collects,
            adapts,
        };
        assert_eq!(card(Some(3), false).describe(), "up, 1000 Mbit/s, tells what comes after 3 us");
        for (card, is_to_be_changed) in [
            (card(Some(100), false), false),
            (card(None, false), false),
            (card(Some(101), false), true),
            (card(Some(3), true), true),
        ] {
            assert_eq!(card.change().is_some(), is_to_be_changed, "{card:?}");
        }
    }
}
