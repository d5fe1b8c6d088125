//! The script of `mrroc-ur`, done in steps.
//!
//! In: set-points as they come. Out: the position that `servoj` gets in each step, and why the script ends.

use core::time::Duration;
use std::collections::VecDeque;
use std::net::SocketAddr;

use mrroc::robot::Load;
use mrroc_robots::Six;
use mrroc_ur::{Ask, Ended, PERIOD, Script, SetPoint, payload};
use nalgebra::Matrix3;

/// Where its connection is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Call {
    /// It calls, and nobody has answered yet.
    Calls,
    /// It is connected.
    Connected,
    /// The other end has closed the connection.
    HungUp,
}

/// What it does with the arm in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Act {
    /// Leaves it where it is, or brakes it.
    Brake,
    /// Drives it there.
    Servo(Six),
    /// The controller ends the program.
    Fail,
}

#[derive(Clone, Debug)]
pub(crate) struct Running {
    pub script: Script,
    /// What it connects to before it calls: UR's own script, which says nothing when it ends.
    pub others: Option<[SocketAddr; 2]>,
    pub call: Call,
    /// What it has said, to be told to the other end before the connection is closed.
    pub says: Option<Ended>,
    /// It has been told.
    pub is_told: bool,
    messages: VecDeque<SetPoint>,
    /// The payload that it has set, and the inertia for the next one.
    pub payload: Option<Load>,
    inertia: Matrix3<f64>,
    asked: Ask,
    position: Six,
    /// For how many steps nothing has come, and how many of them are waited for; none: for ever.
    missing: u32,
    timeout: Option<Duration>,
}

impl Running {
    pub fn new(script: Script, others: Option<[SocketAddr; 2]>, position: Six) -> Running {
        Running {
            script,
            others,
            call: Call::Calls,
            says: None,
            is_told: false,
            messages: VecDeque::new(),
            payload: None,
            inertia: Matrix3::zeros(),
            asked: Ask::Idle,
            position,
            missing: 0,
            timeout: None,
        }
    }

    /// A set-point has come.
    pub fn take(&mut self, message: SetPoint) {
        self.messages.push_back(message);
    }

    /// Whether it has had a set-point.
    pub fn follows(&self) -> bool {
        self.timeout.is_some()
    }

    /// Steps in a row for which no set-point has come.
    pub fn missing(&self) -> u32 {
        self.missing
    }

    /// One step of an arm that is driven at `speed` [rad/s].
    /// What it may set as payload is `most` at most \[kg\].
    pub fn step(&mut self, speed: &Six, most: f64) -> Act {
        if self.says.is_some() || self.call == Call::Calls {
            return Act::Brake;
        }
        // Reading returns at once while there is something, so the last one counts.
        let mut is_new = false;
        while let Some(message) = self.messages.pop_front() {
            self.timeout = Some(message.timeout()).filter(|timeout| !timeout.is_zero());
            if let Some(inertia) = message.inertia() {
                self.inertia = inertia;
                continue;
            }
            if let Some((mass, centre)) = message.load() {
                let load = Load { mass, centre: centre.into(), inertia: self.inertia };
                if !is_taken(&load, most) {
                    return Act::Fail;
                }
                self.payload = Some(load);
                continue;
            }
            self.asked = message.ask();
            match self.asked {
                Ask::Servo => (self.position, is_new) = (Six::from(message.joints()), true),
                Ask::Idle | Ask::Load | Ask::Inertia => is_new = true,
                Ask::End => self.says = Some(Ended::Asked),
            }
        }
        self.missing = if is_new { 0 } else { self.missing.saturating_add(1) };
        let waited = PERIOD * self.missing;
        if self.says.is_none()
            && (self.call == Call::HungUp || self.timeout.is_some_and(|timeout| waited > timeout))
        {
            self.says = Some(Ended::Timeout);
        }
        match self.asked {
            Ask::Servo if self.says.is_none() => {
                if !is_new {
                    self.position += speed * PERIOD.as_secs_f64();
                }
                Act::Servo(self.position)
            }
            Ask::Servo | Ask::Idle | Ask::Load | Ask::Inertia | Ask::End => Act::Brake,
        }
    }
}

/// The largest element that an inertia may have [kg m²]: UR's manual of URScript, `set_target_payload`.
const LARGEST: f64 = 133.0;

/// Whether `set_target_payload` takes this; otherwise it throws. That it throws for a mass beyond `most` \[kg\] is assumed: the manual says
/// it of the inertia alone.
fn is_taken(load: &Load, most: f64) -> bool {
    let elements = payload::elements(&load.inertia);
    (0.0..=most).contains(&load.mass)
        && elements.iter().all(|element| element.abs() <= LARGEST)
        && elements[..3].iter().all(|moment| *moment >= 0.0)
}
