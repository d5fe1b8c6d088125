//! A panel of a cell that is not there: what pages are told and may do under a virtual clock, whatever they send; what is answered over connections in
//! memory whose clock stands; and a little of it over loopback.

mod connections;
mod frames;
mod kinematics;
mod limits;
mod operating;
mod pages;
mod real_time;
mod teaching;

use core::time::Duration;
use std::sync::Arc;

use mrroc_core::robot::Robot;
use mrroc_robots::{Irp6, Six};

use crate::console_session::CellSnapshot;
use crate::now::{Appearance, CellMoment, RobotNow};
use crate::rules::request::Stamp;

const MS: fn(u64) -> Duration = Duration::from_millis;

/// An arm.
fn looks() -> Appearance {
    use mrroc::prelude::*;
    use mrroc_robots::SimulatedIrp6;
    let start = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let arm = RobotSetup::new("arm", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start));
    Appearance::of(&Cell::new(Duration::from_millis(2)).robot(arm).layout())
}

/// The arm, which stands there.
fn robot_at(joints: Six) -> RobotNow {
    RobotNow {
        name: "arm".to_owned(),
        time: 0.0,
        demanded: joints.as_slice().to_vec(),
        measured: joints.as_slice().to_vec(),
        tool: Irp6::nominal().forward(&joints),
        doing: String::new(),
        jogs: true,
        stop: String::new(),
        carried: crate::beside::CarriedLoad::default(),
    }
}

/// A cell that runs, in its step 1000 of 2 ms.
fn shown(looks: &Appearance) -> CellSnapshot {
    let text = looks.state(&CellMoment { state: "running", step: 1000, ..CellMoment::default() }).to_string();
    let stamp = Stamp { epoch: 0, step: 1000 };
    CellSnapshot {
        text: Some(text.into()),
        stamp: Some((stamp, 2_000_000)),
        robots: Arc::default(),
        moves: false,
        over: None,
    }
}

/// One frame, masked by zeros.
fn frame(kind: u8, bytes: &[u8]) -> Vec<u8> {
    let mut frame = vec![kind];
    match bytes.len() {
        short @ 0..126 => frame.push(0x80 | short as u8),
        long => {
            frame.push(0x80 | 127);
            frame.extend_from_slice(&(long as u64).to_be_bytes());
        }
    }
    frame.extend_from_slice(&[0; 4]);
    frame.extend_from_slice(bytes);
    frame
}
