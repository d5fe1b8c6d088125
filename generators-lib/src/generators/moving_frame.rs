//! Moves the tool to a place in a frame that moves, and on with that frame.

use core::marker::PhantomData;

use mrroc::prelude::*;

use mrroc_generators::cooperation::Transform;
use mrroc_generators::line::LinePath;

/// Moves the tool onto `X_WF(age) X_FG` and keeps it there. The frame F is a function of the motion's path time,
/// evaluated in every step: RCCL's functional transform. While the share `s` of the approach time has passed, the tool
/// is at the share `b = 10 s^3 - 15 s^4 + 6 s^5` of the straight line from its start to where the place is *now*. So it
/// starts at rest and arrives with the velocity of the place, without a step in velocity.
///
/// The frame moves by path time, so it stands still while the cell is suspended. For a frame that moves by itself use
/// [`FollowedFrame`](super::FollowedFrame).
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::cooperation::Functional;
/// use mrroc_generators::generators::MovingFrame;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
///
/// let irp6 = Irp6::nominal();
/// // A belt at 0.05 m/s carries a part; the tool is above it after 1 s, and goes on with it for 0.5 s.
/// let part = irp6.forward(&Irp6::READY) * Pose::translation(0.0, 0.0, 0.1);
/// let belt = move |age: f64| Pose::translation(0.0, 0.05 * age, 0.0) * part;
/// let above = Pose::translation(0.0, 0.0, -0.05);
/// let motion = MovingFrame::to(Functional::new(belt), above, 1.0, 1.5);
/// let demands = rehearse(motion, &irp6, Irp6::READY, 0.002)?;
/// assert_eq!(demands.len(), 750);
/// let end = demands[749].as_pose().map(|end| (belt(1.5) * above).inv_mul(&end).translation.vector.norm());
/// assert!(end.is_some_and(|off| off < 1e-12));
/// # Ok::<(), Fault>(())
/// ```
pub struct MovingFrame<R, F> {
    frame: F,
    place: Pose,
    approach: f64,
    duration: f64,
    start: Pose,
    age: f64,
    of: PhantomData<R>,
}

impl<R: Robot, F: Transform> MovingFrame<R, F> {
    /// To `X_FG` in the frame `X_WF`, within `approach` \[s\], > 0, and with it until `duration` \[s\], >= `approach`, has passed.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn to(X_WF: F, X_FG: Pose, approach: f64, duration: f64) -> Self {
        let start = Pose::identity();
        let age = 0.0;
        MovingFrame { frame: X_WF, place: X_FG, approach, duration, start, age, of: PhantomData }
    }
}

#[generator(ecp)]
impl<R: Robot, F: Transform> MovingFrame<R, F> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        if !(self.approach > 0.0 && self.approach <= self.duration && self.approach.is_finite()) {
            return Err(Fault::thrown(
                "an approach to a moving frame must be finite, > 0 and no longer than the motion",
            ));
        }
        self.start = e.demanded().pose;
        self.next_step(t)
    }

    #[allow(non_snake_case)]
    fn next_step(&mut self, t: Tick) -> Result<Step<R>, Fault> {
        // The exact end is demanded once; rounding must not cost a step.
        if self.age >= self.duration {
            return Ok(Step::Done);
        }
        self.age += t.dt;
        if self.duration - self.age <= 1e-9 * t.dt {
            self.age = self.duration;
        }
        let X_WG = self.frame.at(self.age) * self.place;
        if !X_WG.to_homogeneous().iter().all(|x| x.is_finite()) {
            return Err(Fault::thrown("the place in a moving frame is not finite"));
        }
        let s = (self.age / self.approach).min(1.0);
        let b = s * s * s * (10.0 + s * (6.0 * s - 15.0));
        Ok(Step::Next(Demand::pose(LinePath::new(self.start, X_WG).pose(b))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc_generators::cooperation::Functional;
    use mrroc_robots::{Conveyor, Irp6, One, Six};
    use nalgebra::Vector3;

    #[test]
    fn a_tool_gets_onto_a_conveyor_and_goes_with_it() {
        const SPEED: f64 = 0.1;
        let belt = Conveyor::new();
        let mark = Functional::new(move |age| belt.forward(&One::new(SPEED * age)));
        let above = Pose::translation(0.2, 0.1, 0.3);
        let start = Pose::translation(0.5, -0.3, 0.6);
        let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: start };
        let e = State::<Irp6>::new(RobotImage::new(state, state));
        let dt = 2e-3;
        let mut generator = MovingFrame::to(mark, above, 1.0, 2.0);
        let t = Tick { step: 0, dt, duration: dt };
        let mut p = vec![start.translation.vector; 2];
        let mut step = generator.first_step(&e, t);
        while let Ok(Step::Next(demand)) = step {
            let age = dt * (p.len() - 1) as f64;
            let belt = Conveyor::new().forward(&One::new(SPEED * age)) * above;
            let s = age.min(1.0);
            let share = 10.0 * s.powi(3) - 15.0 * s.powi(4) + 6.0 * s.powi(5);
            let there = start.translation.vector.lerp(&belt.translation.vector, share);
            let demanded = demand.as_pose().expect("a pose").translation.vector;
            assert!((demanded - there).norm() < 1e-14, "at {age} s");
            p.push(demanded);
            step = generator.next_step(t);
        }
        assert_eq!(step, Ok(Step::Done));
        assert_eq!(p.len(), 2 + 1000);
        // b'' is at most 5.7735, b' 1.875 over the distance of a second: |a| <= 5.7735 |distance| + 2 * 1.875 * SPEED.
        let distance = (above.translation.vector - start.translation.vector).norm() + SPEED;
        let end = p.len() - 1;
        for w in p.windows(3) {
            assert!(((w[2] - w[1]) - (w[1] - w[0])).norm() / (dt * dt) < 5.78 * distance + 3.75 * SPEED);
        }
        assert!(((p[end] - p[end - 1]) / dt - Vector3::new(SPEED, 0.0, 0.0)).norm() < 1e-9);
    }
}
