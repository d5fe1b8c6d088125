//! The node: its participant of DDS, and its publishers.
//!
//! In: where DDS speaks, and names. Out: publishers of a type and a quality of service.

use std::cell::Cell;
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use mrroc_core::cell::CellError;
use mrroc_core::suggestion::suggestion;
use mrroc_launch::cell_file::PublishedEntry;
use ros2_client::action::{ActionServer, ActionServerQosPolicies};
use ros2_client::dds::rustdds::{DomainParticipant, DomainParticipantBuilder};
use ros2_client::qos::{Durability, History, Reliability, WhenFull};
use ros2_client::{
    ActionTypeName, Context, Message, MessageTypeName, Name, Node, NodeName, NodeOptions, ParameterValue,
    Publisher, QosProfile, Server, ServiceMapping, ServiceTypeName,
};

use crate::messages::RosType;
use crate::outlet::{self, Outlet, Put};

/// Where DDS speaks, as which node, and how topics are published.
#[derive(Clone, Debug)]
pub struct Place {
    /// The domain, `ROS_DOMAIN_ID`.
    pub domain: u16,
    /// The address of this machine on the network where DDS speaks.
    pub address: IpAddr,
    /// The name of the node.
    pub node: String,
    /// What `cell.toml` says of topics.
    pub topics: Vec<PublishedEntry>,
}

/// Topics on which each message tells of something else: one that is left out is missed.
const SHARED: [&str; 3] = ["/joint_states", "/tf", "/diagnostics"];

/// Messages of a topic that wait for a subscriber that is slow. Where more wait, as for a program that stands still, new ones are dropped for all:
/// a bridge waits for nobody.
const WAITING: usize = 100;

/// Who is there gets every message.
pub fn now_only() -> QosProfile {
    QosProfile::publisher_default()
        .reliability(Reliability::Reliable { when_full: WhenFull::Fail })
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth: WAITING })
}

/// Who comes later gets the last message, too.
pub fn kept() -> QosProfile {
    now_only().durability(Durability::TransientLocal).history(History::KeepLast { depth: 1 })
}

/// The parameter that is the speed.
pub const SPEED: &str = "speed";

/// The node.
pub struct RosNode {
    node: Node,
    name: String,
    participant: DomainParticipant,
    /// What the file says of topics.
    asked: Vec<PublishedEntry>,
}

/// A topic of other nodes.
pub struct RosTopic<M: RosType> {
    publisher: Publisher<M>,
    limit: Option<RateLimit>,
}

/// Lets a message pass where the last one is long enough ago.
struct RateLimit {
    every: Duration,
    /// When the next one may pass.
    due: Cell<Instant>,
}

impl RateLimit {
    /// Whether one passes now.
    fn passes(&self, now: Instant) -> bool {
        let due = self.due.get();
        // Messages come in bursts: the mean rate is kept where one was late, by less than a period.
        let next = if now < due + self.every { due } else { now };
        let passes = now >= due;
        if passes {
            self.due.set(next + self.every);
        }
        passes
    }
}

impl RosNode {
    /// Begins to be one. `check_speed` says why a speed cannot be that of the cell, `set_speed` sets it, or says why not.
    ///
    /// # Errors
    /// Why DDS, or a node of this name, cannot be had.
    pub fn begin(
        place: &Place,
        check_speed: impl Fn(f64) -> Result<(), String> + Send + Sync + 'static,
        set_speed: impl Fn(f64) -> Result<(), String> + Send + Sync + 'static,
    ) -> Result<RosNode, String> {
        let participant =
            DomainParticipantBuilder::new(place.domain).with_only_networks([place.address]).build();
        let participant = participant
            .map_err(|error| format!("DDS at {}, domain {}: {error}", place.address, place.domain))?;
        let failed = |error: &dyn core::fmt::Display| format!("node `{}`: {error}", place.node);
        let context =
            Context::from_domain_participant(participant.clone()).map_err(|error| failed(&error))?;
        let name = NodeName::new("/", &place.node).map_err(|error| failed(&error))?;
        let number = |name: &str, value: &ParameterValue| match (name, value) {
            (SPEED, ParameterValue::Double(speed)) => Ok(Some(*speed)),
            (SPEED, _) => Err("the speed is a number with a decimal point, from 0.0 to 1.0".to_owned()),
            _ => Ok(None),
        };
        // The value that is declared is set, too, and is none that anybody has asked for.
        let begun = Arc::new(AtomicBool::new(false));
        let has_begun = Arc::clone(&begun);
        let check =
            move |name: &str, value: &ParameterValue| number(name, value)?.map_or(Ok(()), &check_speed);
        let set = move |name: &str, value: &ParameterValue| match number(name, value)? {
            Some(speed) if has_begun.load(Ordering::Acquire) => set_speed(speed),
            Some(_) | None => Ok(()),
        };
        let options = NodeOptions::new()
            .enable_rosout(false)
            .declare_parameter(SPEED, ParameterValue::Double(1.0))
            .parameter_validator(Box::new(check))
            .parameter_set_action(Box::new(set));
        let mut node = context.new_node(name, options).map_err(|error| failed(&error))?;
        begun.store(true, Ordering::Release);
        let spinner = node.spinner().map_err(|error| failed(&error))?;
        let spin = move || drop(futures::executor::block_on(spinner.spin()));
        std::thread::Builder::new()
            .name("parameters".to_owned())
            .spawn(spin)
            .map_err(|error| failed(&error))?;
        Ok(RosNode { node, name: place.node.clone(), participant, asked: place.topics.clone() })
    }

    /// Its participant of DDS.
    pub const fn participant(&self) -> &DomainParticipant {
        &self.participant
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// A service of this node itself.
    ///
    /// # Errors
    /// Why there is none.
    pub fn service<Request, Response>(
        &mut self,
        service: &str,
        (package, name): (&str, &str),
    ) -> Result<Server<Request, Response>, String>
    where
        Request: Message + Clone + 'static,
        Response: Message + Clone + 'static,
    {
        let called = self.own(service);
        let failed = |error: &dyn core::fmt::Display| format!("service {called}: {error}");
        let of = Name::parse(&called).map_err(|error| failed(&error))?;
        let kind = ServiceTypeName::new(package, name);
        let server = self.node.create_server(ServiceMapping::Enhanced, &of, &kind, now_only(), now_only());
        server.map_err(|error| failed(&error))
    }

    /// An action server.
    ///
    /// # Errors
    /// Why there is none.
    pub fn action<Goal, Outcome, Feedback>(
        &mut self,
        action: &str,
        (package, name): (&str, &str),
    ) -> Result<ActionServer<Goal, Outcome, Feedback>, String>
    where
        Goal: Message + Clone + 'static,
        Outcome: Message + Clone + 'static,
        Feedback: Message + 'static,
    {
        let failed = |error: &dyn core::fmt::Display| format!("action {action}: {error}");
        let of = Name::parse(action).map_err(|error| failed(&error))?;
        let qos = ActionServerQosPolicies {
            goal_service: now_only(),
            result_service: now_only(),
            cancel_service: now_only(),
            feedback_publisher: now_only(),
            status_publisher: kept(),
        };
        let kind = ActionTypeName::new(package, name);
        let server = self.node.create_action_server(ServiceMapping::Enhanced, &of, &kind, qos);
        server.map_err(|error| failed(&error))
    }
}

impl Outlet for RosNode {
    type Topic<M: RosType> = RosTopic<M>;

    fn node(&self) -> &str {
        self.name()
    }

    fn now(&self) -> u64 {
        crate::clock::now()
    }

    /// The check of all names, before the node began, has told it.
    fn warn(&self, _: &str) {}

    fn topic<M: RosType>(
        &mut self,
        name: &str,
        durability: outlet::Durability,
    ) -> Result<RosTopic<M>, String> {
        let failed = |error: &dyn core::fmt::Display| format!("topic {name}: {error}");
        let called = Name::parse(name).map_err(|error| failed(&error))?;
        let asked = self.asked.iter().find(|asked| asked.name().text == name);
        let qos = match durability {
            outlet::Durability::Volatile => asked.map_or_else(now_only, offered),
            outlet::Durability::TransientLocal => kept(),
        };
        let every = asked.and_then(PublishedEntry::every);
        let limit = every.map(|every| RateLimit { every, due: Cell::new(Instant::now()) });
        let described = self.node.create_topic(&called, MessageTypeName::new(M::PACKAGE, M::NAME), &qos);
        let described = described.map_err(|error| failed(&error))?;
        let publisher = self.node.create_publisher(&described, None).map_err(|error| failed(&error))?;
        Ok(RosTopic { publisher, limit })
    }
}

/// What `cell.toml` asks for.
fn offered(asked: &PublishedEntry) -> QosProfile {
    now_only()
        .reliability(reliability(asked.is_reliable()))
        .history(History::KeepLast { depth: asked.depth() })
}

/// That of a topic that is reliable, or best effort.
pub const fn reliability(is_reliable: bool) -> Reliability {
    if is_reliable { Reliability::Reliable { when_full: WhenFull::Fail } } else { Reliability::BestEffort }
}

impl<M: RosType> Put<M> for RosTopic<M> {
    fn put(&self, message: M) {
        if self.limit.as_ref().is_none_or(|limit| limit.passes(Instant::now())) {
            // What nobody takes is dropped.
            drop(self.publisher.publish(message));
        }
    }
}

/// A robot's or a signal's name as a part of a topic's: letters, digits and single underscores, a letter first.
pub fn topic_name(name: &str) -> String {
    let mut made = String::new();
    for c in name.chars() {
        match c {
            _ if c.is_ascii_alphanumeric() => made.push(c),
            _ if made.is_empty() || made.ends_with('_') => {}
            _ => made.push('_'),
        }
    }
    let made = made.trim_end_matches('_');
    if made.starts_with(|c: char| c.is_ascii_alphabetic()) { made.to_owned() } else { format!("n{made}") }
}

/// Two of these names that would be the same part of a topic's, if there are any.
pub fn same_topic<'a>(names: impl Iterator<Item = &'a str> + Clone) -> Option<[&'a str; 2]> {
    names.clone().enumerate().find_map(|(place, one)| {
        let is_same = |other: &&str| topic_name(other) == topic_name(one);
        names.clone().take(place).find(is_same).map(|other| [other, one])
    })
}

/// Refuses what `cell.toml` asks for of topics that are not published, or that cannot have it.
///
/// # Errors
/// All of it.
pub fn check_published(
    published: &[(String, outlet::Durability)],
    asked: &[PublishedEntry],
) -> Result<(), String> {
    let names: Vec<_> = published.iter().map(|(name, _)| name.as_str()).collect();
    let errors = asked.iter().filter_map(|asked| {
        let name = asked.name().text.as_str();
        let Some((_, durability)) = published.iter().find(|(known, _)| known == name) else {
            let what = format!("the bridge publishes no topic `{name}`");
            return Some(asked.refuse(what, suggestion(name, &names, "it publishes")));
        };
        if *durability == outlet::Durability::TransientLocal {
            let what = format!(
                "`{name}` is kept for nodes that come later: it is reliable, and each change is told"
            );
            return Some(asked.refuse(what, "leave the table out".to_owned()));
        }
        (SHARED.contains(&name) && asked.every().is_some()).then(|| {
            let what = format!("each message of `{name}` tells of another robot or another change");
            asked.refuse(what, "leave `every_ms` out".to_owned())
        })
    });
    CellError::all(errors.collect()).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use mrroc_launch::cell_file::CellFile;

    use super::*;

    #[test]
    fn of_messages_in_bursts_as_many_pass_as_there_are_periods_and_none_at_once_after_a_silence() {
        let begun = Instant::now();
        let limit = RateLimit { every: Duration::from_millis(20), due: Cell::new(begun) };
        // Two every 4 ms, for a second: a burst has one at most.
        let at = |ms: u64| begun + Duration::from_millis(ms);
        let passed = (0..250).map(|burst| [0, 0].map(|_| limit.passes(at(4 * burst))));
        let passed: Vec<_> = passed.map(|[first, second]| u32::from(first) + u32::from(second)).collect();
        assert_eq!((passed.iter().sum::<u32>(), passed.iter().max()), (50, Some(&1)));
        let after = [5000, 5000, 5019, 5020].map(|ms| limit.passes(at(ms)));
        assert_eq!(after, [true, false, false, true]);
    }

    #[test]
    fn names_of_robots_are_made_names_of_topics_and_two_that_become_one_are_found() {
        let made = ["left", "left-arm", "press.arm", "2nd", "a--b", "-x-"].map(topic_name);
        assert_eq!(made, ["left", "left_arm", "press_arm", "n2nd", "a_b", "x"]);
        assert_eq!(same_topic(["left", "left-arm", "left_arm"].into_iter()), Some(["left-arm", "left_arm"]));
        assert_eq!(same_topic(["left", "right"].into_iter()), None);
    }

    #[test]
    fn tables_of_topics_that_are_not_there_or_cannot_be_so_are_refused_by_name() {
        let published = [
            ("/joint_states".to_owned(), outlet::Durability::Volatile),
            ("/arm/joint_states".to_owned(), outlet::Durability::Volatile),
            ("/tf_static".to_owned(), outlet::Durability::TransientLocal),
        ];
        let check = |tables: &[(&str, &str)]| {
            let tables: String =
                tables.iter().map(|(name, entry)| format!("[topics.\"{name}\"]\n{entry}\n")).collect();
            let arm = "robots.arm = { kind = \"irp6\", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0] }";
            let file = CellFile::parse("cell.toml", &format!("step_ms = 2\n{arm}\n{tables}"));
            check_published(&published, file.expect("its form is right").published())
        };
        let right = [("/joint_states", "depth = 5"), ("/arm/joint_states", "every_ms = 20")];
        assert_eq!(check(&right), Ok(()));
        let wrong = [
            ("/arm/joint_state", "depth = 5"),
            ("/tf_static", "depth = 5"),
            ("/joint_states", "every_ms = 20"),
            right[1],
        ];
        let why = check(&wrong).expect_err("three are wrong");
        for expected in [
            "the bridge publishes no topic `/arm/joint_state`",
            "did you mean `/arm/joint_states`?",
            "`/tf_static` is kept for nodes that come later",
            "each message of `/joint_states` tells of another robot",
        ] {
            assert!(why.contains(expected), "{expected}: {why}");
        }
    }
}
