//! What crosses the port between a robot's drives and the simulator: one order and one state for each servo period.
//!
//! In: where a robot is to be, or where it is. Out: plain messages of fixed size, or what is wrong with one of another program.

use core::time::Duration;

use iceoryx2::prelude::ZeroCopySend;
use mrroc::nalgebra::Vector3;
use mrroc::payload::layout_hash;
use mrroc::pose::Wrench;
use mrroc::robot::{MAX_JOINTS, Simulated};

/// The version of this interface.
pub(crate) const VERSION: u32 = 1;

/// The most bytes of a robot's name.
const NAME: usize = mrroc::fault::MAX_NAME;

/// The fields of both messages, in their order: a program whose messages differ has another hash.
pub(crate) const LAYOUT: u64 = layout_hash(
    0,
    "order: version u32, kind u32, layout u64, session u64, period u64, time u64, length u64, late u64, clock u32, joints u32, robot \
     u8*24, demanded f64*8; state: version u32, kind u32, layout u64, session u64, period u64, time u64, joints u32, has_wrench u32, \
     robot u8*24, position f64*8, velocity f64*8, wrench f64*6",
);

/// What an order asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum PlantRequest {
    /// Let the robot stand at `demanded`, and say where it is. No time passes. Its orders begin with this period; where others
    /// are on their way and it says 0, with the next one that comes.
    Begin = 1,
    /// Be at `demanded` at the end of the period.
    Follow = 2,
    /// The robot has no power, and its brakes are applied.
    StandBy = 3,
    /// Nothing more comes: do not wait for this robot.
    End = 4,
}

/// What a state says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Says {
    /// The robot stands where it begins.
    Placed = 1,
    /// The period is over.
    Stepped = 2,
    /// The simulation cannot go on.
    Failed = 3,
}

/// From the drives of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(crate) struct PlantOrder {
    pub version: u32,
    /// [`PlantRequest`].
    pub kind: u32,
    pub layout: u64,
    /// Which opening of the port it belongs to.
    pub session: u64,
    /// The servo period, counted from the cell's start.
    pub period: u64,
    /// When it was sent: `CLOCK_MONOTONIC` \[ns\].
    pub time: u64,
    /// How long a period is \[ns\].
    pub length: u64,
    /// Answers that were not there in time so far, of a cell in real time.
    pub late: u64,
    /// 0: under the virtual clock, 1: in real time.
    pub clock: u32,
    pub joints: u32,
    /// The robot's name, and zeros.
    pub robot: [u8; NAME],
    /// Joint positions \[rad or m\].
    pub demanded: [f64; MAX_JOINTS],
}

/// From the simulator.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(crate) struct PlantState {
    pub version: u32,
    /// [`Says`].
    pub kind: u32,
    pub layout: u64,
    /// Of the order that it answers.
    pub session: u64,
    /// The period at whose end it is.
    pub period: u64,
    /// When it was sent: `CLOCK_MONOTONIC` \[ns\].
    pub time: u64,
    pub joints: u32,
    /// 1: the wrench says something.
    pub has_wrench: u32,
    pub robot: [u8; NAME],
    /// Joint positions \[rad or m\], velocities \[rad/s or m/s\].
    pub position: [f64; MAX_JOINTS],
    pub velocity: [f64; MAX_JOINTS],
    /// Force \[N\] and torque \[N m\] of the surroundings on the flange, at its origin and in its axes.
    pub wrench: [f64; 6],
}

#[expect(unsafe_code, reason = "it says to iceoryx2 that the type may be in shared memory")]
// SAFETY: it consists of plain numbers in C's layout without gaps: it has no pointer and nothing to drop, and every bit pattern is
// valid.
unsafe impl ZeroCopySend for PlantOrder {
    unsafe fn type_name() -> &'static str {
        "mrroc_plant_order_1"
    }
}

#[expect(unsafe_code, reason = "it says to iceoryx2 that the type may be in shared memory")]
// SAFETY: it consists of plain numbers in C's layout without gaps: it has no pointer and nothing to drop, and every bit pattern is
// valid.
unsafe impl ZeroCopySend for PlantState {
    unsafe fn type_name() -> &'static str {
        "mrroc_plant_state_1"
    }
}

/// Why a state of another program is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Untrue {
    /// Of another version, or with other fields.
    Version,
    /// Of another robot.
    Robot,
    /// With another number of joints.
    Joints,
    /// A number is NaN or infinite.
    NotFinite,
    /// The simulator says itself that it cannot go on.
    Failed,
}

/// A name as bytes.
pub(crate) fn name_of(robot: &str) -> [u8; NAME] {
    let mut name = [0; NAME];
    for (byte, of) in name.iter_mut().zip(robot.bytes()) {
        *byte = of;
    }
    name
}

impl PlantOrder {
    /// The length of a servo period as an order says it \[ns\].
    pub fn length_of(period: Duration) -> u64 {
        u64::try_from(period.as_nanos()).unwrap_or(u64::MAX)
    }
}

impl PlantState {
    /// The state of this robot with so many joints.
    pub fn read(&self, robot: &[u8; NAME], joints: usize) -> Result<Simulated, Untrue> {
        if self.version != VERSION || self.layout != LAYOUT {
            return Err(Untrue::Version);
        }
        if self.robot != *robot {
            return Err(Untrue::Robot);
        }
        if self.kind == Says::Failed as u32 {
            return Err(Untrue::Failed);
        }
        if self.joints as usize != joints {
            return Err(Untrue::Joints);
        }
        let told = self.position[..joints].iter().chain(&self.velocity[..joints]);
        let has_wrench = self.has_wrench == 1;
        let wrench = self.wrench.iter().filter(|_| has_wrench);
        if !told.chain(wrench).all(|number| number.is_finite()) {
            return Err(Untrue::NotFinite);
        }
        let [fx, fy, fz, tx, ty, tz] = self.wrench;
        let wrench = Wrench::new(Vector3::new(fx, fy, fz), Vector3::new(tx, ty, tz));
        Ok(Simulated {
            position: self.position,
            velocity: self.velocity,
            wrench: has_wrench.then_some(wrench),
        })
    }
}

#[cfg(test)]
mod tests {
    use core::mem::{offset_of, size_of};

    use super::*;

    #[test]
    fn the_layouts_of_both_messages_are_those_that_the_page_tells_to_others() {
        assert_eq!((size_of::<PlantOrder>(), size_of::<PlantState>()), (152, 248));
        assert_eq!(
            [offset_of!(PlantOrder, late), offset_of!(PlantOrder, robot), offset_of!(PlantOrder, demanded)],
            [48, 64, 88]
        );
        assert_eq!(
            [offset_of!(PlantState, joints), offset_of!(PlantState, robot), offset_of!(PlantState, wrench)],
            [40, 48, 200]
        );
    }

    #[test]
    fn fault_122_a_state_that_is_none_of_this_robot_is_refused_by_its_reason() {
        let robot = name_of("arm");
        let good = PlantState {
            version: VERSION,
            kind: Says::Stepped as u32,
            layout: LAYOUT,
            session: 1,
            period: 3,
            time: 0,
            joints: 2,
            has_wrench: 0,
            robot,
            position: [0.5; MAX_JOINTS],
            velocity: [0.25; MAX_JOINTS],
            wrench: [f64::NAN; 6],
        };
        let read = |state: PlantState| state.read(&robot, 2);
        assert_eq!(read(good).map(|state| (state.position[1], state.wrench)), Ok((0.5, None)));
        let mut beyond = good;
        beyond.position[2] = f64::NAN;
        assert!(read(beyond).is_ok(), "what is beyond its joints says nothing");
        let mut bad = good;
        bad.velocity[1] = f64::INFINITY;
        for (state, why) in [
            (PlantState { version: 2, ..good }, Untrue::Version),
            (PlantState { layout: 1, ..good }, Untrue::Version),
            (PlantState { robot: name_of("arms"), ..good }, Untrue::Robot),
            (PlantState { joints: 3, ..good }, Untrue::Joints),
            (PlantState { joints: u32::MAX, ..good }, Untrue::Joints),
            (PlantState { has_wrench: 1, ..good }, Untrue::NotFinite),
            (PlantState { kind: Says::Failed as u32, ..good }, Untrue::Failed),
            (bad, Untrue::NotFinite),
        ] {
            assert_eq!(read(state), Err(why));
        }
    }
}
