//! A simulator of others, for tests: each joint goes a share of the displacement to where it is to be in each period, and the arms push
//! each other.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use mrroc::robot::MAX_JOINTS;

use crate::plant::ORDERS;
use crate::plant::message::{LAYOUT, PlantOrder, PlantRequest, PlantState, Says, VERSION};
use crate::port::{Ends, channel, monotonic};

/// The share of its displacement that a joint goes in a period.
pub const SHARE: f64 = 0.5;

/// A robot of the simulator: where it is, and its ends of the port.
pub struct Robot {
    pub name: String,
    pub sends: Publisher<ipc::Service, PlantState, ()>,
    pub takes: Subscriber<ipc::Service, PlantOrder, ()>,
    pub queue: Vec<PlantOrder>,
    pub begun: bool,
    /// The first period that it orders, if that is known.
    pub first: Option<u64>,
    pub position: [f64; MAX_JOINTS],
    pub velocity: [f64; MAX_JOINTS],
}

impl Robot {
    pub fn open(ends: &Ends, name: &str) -> Result<Robot, String> {
        let orders = channel::<PlantOrder>(&ends.node, &format!("world/{name}/orders"), ORDERS)?;
        let states = channel::<PlantState>(&ends.node, &format!("world/{name}/states"), 1)?;
        Ok(Robot {
            name: name.to_owned(),
            sends: states.publisher_builder().create().map_err(|error| error.to_string())?,
            takes: orders.subscriber_builder().create().map_err(|error| error.to_string())?,
            queue: Vec::new(),
            begun: false,
            first: None,
            position: [0.0; MAX_JOINTS],
            velocity: [0.0; MAX_JOINTS],
        })
    }

    /// The state that answers an order.
    pub fn state(&self, order: &PlantOrder, says: Says) -> PlantState {
        PlantState {
            version: VERSION,
            kind: says as u32,
            layout: LAYOUT,
            session: order.session,
            period: order.period,
            time: monotonic(),
            joints: order.joints,
            has_wrench: 1,
            robot: order.robot,
            position: self.position,
            velocity: self.velocity,
            wrench: [order.period as f64, 0.0, 0.0, 0.0, 0.0, 1.0],
        }
    }

    pub fn send(&self, state: PlantState) {
        self.sends.send_copy(state).expect("sent");
    }

    /// Takes what has come.
    pub fn hear(&mut self) {
        while let Some(order) = self.takes.receive().expect("no failure") {
            self.queue.push(*order);
        }
    }
}

/// One period of one joint, in seconds of its length.
pub fn follow(position: f64, demanded: f64) -> f64 {
    position + SHARE * (demanded - position)
}

/// What it does with the answers: of which robot, to which order, and the true one.
pub type Answer = dyn FnMut(&str, &PlantOrder, PlantState) -> Option<PlantState> + Send;

/// The periods that it has simulated, with what each robot was asked.
pub type Log = Vec<(u64, BTreeMap<String, u32>)>;

/// It runs until it is dropped.
pub struct Simulator {
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<Log>>,
}

impl Simulator {
    /// With these robots, and answers as they are.
    pub fn of(folder: &Path, robots: &[&str]) -> Simulator {
        Self::answering(folder, robots, |_, _, state| Some(state))
    }

    /// The same, with other answers, or without some.
    pub fn answering(
        folder: &Path,
        robots: &[&str],
        answer: impl FnMut(&str, &PlantOrder, PlantState) -> Option<PlantState> + Send + 'static,
    ) -> Simulator {
        let ends = Arc::new(AtomicBool::new(false));
        let (stop, folder) = (Arc::clone(&ends), PathBuf::from(folder));
        let robots: Vec<_> = robots.iter().map(|&robot| robot.to_owned()).collect();
        let thread = std::thread::spawn(move || run(&folder, &robots, &stop, Box::new(answer)));
        Simulator { ends, thread: Some(thread) }
    }

    /// Ends it; the periods that it has simulated.
    pub fn end(mut self) -> Log {
        self.ends.store(true, Ordering::Release);
        self.thread.take().expect("once").join().expect("it did not panic")
    }
}

impl Drop for Simulator {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
    }
}

fn run(folder: &Path, robots: &[String], stop: &AtomicBool, mut answer: Box<Answer>) -> Log {
    let ends = Ends::open(folder).expect("a node");
    let mut robots: Vec<_> =
        robots.iter().map(|name| Robot::open(&ends, name).expect("the only simulator")).collect();
    let mut log = Log::new();
    let mut goes = false;
    while !stop.load(Ordering::Acquire) {
        robots.iter_mut().for_each(Robot::hear);
        for robot in &mut robots {
            while let Some(order) = robot.queue.first().copied() {
                if order.kind == PlantRequest::Begin as u32 {
                    (robot.begun, robot.position) = (true, order.demanded);
                    robot.velocity = [0.0; MAX_JOINTS];
                    robot.first = (order.period > 0 || !goes).then_some(order.period);
                    let state = robot.state(&order, Says::Placed);
                    answer(&robot.name, &order, state).into_iter().for_each(|state| robot.send(state));
                } else if order.kind == PlantRequest::End as u32 || !robot.begun {
                    robot.begun = false;
                } else {
                    break;
                }
                robot.queue.remove(0);
            }
        }
        let period = robots.iter().filter_map(|robot| robot.queue.first()).map(|order| order.period).min();
        let is_missed = |robot: &Robot, period: u64| {
            robot.begun && robot.queue.is_empty() && robot.first.is_some_and(|first| period >= first)
        };
        let Some(period) = period.filter(|&period| !robots.iter().any(|robot| is_missed(robot, period)))
        else {
            std::thread::yield_now();
            continue;
        };
        goes = true;
        step(&mut robots, period, &mut log, &mut answer);
    }
    log
}

/// One period of the robots that have said where to be.
fn step(robots: &mut [Robot], period: u64, log: &mut Log, answer: &mut Answer) {
    let mut asked = BTreeMap::new();
    let mut orders = Vec::new();
    for robot in robots.iter_mut().filter(|robot| robot.begun && !robot.queue.is_empty()) {
        let order = robot.queue.remove(0);
        assert_eq!(period, order.period, "all robots order the same period");
        if order.kind == PlantRequest::Follow as u32 {
            let seconds = order.length as f64 * 1e-9;
            for i in 0..order.joints as usize {
                let next = follow(robot.position[i], order.demanded[i]);
                robot.velocity[i] = (next - robot.position[i]) / seconds;
                robot.position[i] = next;
            }
        } else {
            robot.velocity = [0.0; MAX_JOINTS];
        }
        asked.insert(robot.name.clone(), order.kind);
        orders.push((robot.name.clone(), order));
    }
    log.push((period, asked));
    for (name, order) in orders {
        let robot = robots.iter().find(|robot| robot.name == name).expect("it is one of them");
        let state = robot.state(&order, Says::Stepped);
        answer(&name, &order, state).into_iter().for_each(|state| robot.send(state));
    }
}
