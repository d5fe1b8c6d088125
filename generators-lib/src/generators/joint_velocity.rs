//! Brings joints to a velocity, and goes on at it: a belt, a fan, a rotary table.

use mrroc::prelude::*;
use mrroc::robot::JointVector;

/// Changes the velocity of every joint within an acceleration, from whatever motion it finds, and then keeps it.
///
/// It has no end of its own, except that of velocity zero: it is done when all joints are at rest. So it is a motion for
/// [`Mp::start_robot`](mrroc::program::Mp::start_robot), and changes the velocity of one. Velocities are those at full
/// speed; at an operator's lower speed the joints are as much slower.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::JointVelocity;
/// use mrroc_generators::rehearsal::at_rest;
/// use mrroc_robots::{Conveyor, One};
///
/// // A belt comes to 0.2 m/s within 0.1 m/s² in 2 s and 0.2 m, and then runs by 0.2 m in a second.
/// let mut run = JointVelocity::<Conveyor>::of(One::new(0.2), One::new(0.1));
/// let (order, v) = (Order::new(()), Reading::new(()));
/// let e = State::new(at_rest(&Conveyor::new(), One::new(0.0)));
/// let t = Tick { step: 0, dt: 0.01, duration: 0.01 };
/// let mut step = mrroc::generator::Generator::first_step(&mut run, &order, &e, &v, t)?;
/// for _ in 1..300 {
///     step = mrroc::generator::Generator::next_step(&mut run, &order, &e, &v, t)?;
/// }
/// let Step::Next(demand) = step else { unreachable!() };
/// assert!(demand.as_joints().is_some_and(|q| (q[0] - 0.4).abs() < 1e-12));
/// # Ok::<(), Fault>(())
/// ```
pub struct JointVelocity<R: Robot> {
    velocity: R::Joints,
    acceleration: R::Joints,
    /// Where it began, and how fast that was in path time.
    start: R::Joints,
    found: R::Joints,
    /// Path time since then \[s\].
    t: f64,
}

impl<R: Robot> JointVelocity<R> {
    /// To a `velocity` [rad/s or m/s] of each joint, which may be zero, within an `acceleration` [rad/s² or m/s²], > 0.
    /// Leave a tenth of the robot's limits to the operator's feed rate.
    #[must_use]
    pub fn of(velocity: R::Joints, acceleration: R::Joints) -> Self {
        let zero = R::Joints::from_joints(|_| 0.0);
        JointVelocity { velocity, acceleration, start: zero, found: zero, t: 0.0 }
    }

    /// `q0 + v0 t + a t² / 2` until joint `i` has its velocity `v`, then `v` on; and whether it has it.
    fn joint(&self, i: usize) -> (f64, bool) {
        let (v0, v) = (self.found[i], self.velocity[i]);
        let change = ((v - v0) / self.acceleration[i]).abs();
        let t = self.t.min(change);
        let changed = (v - v0).signum() * self.acceleration[i] * t * t / 2.0;
        (self.start[i] + v0 * t + changed + v * (self.t - t), self.t >= change)
    }

    fn advance(&mut self, dt: f64) -> Step<R> {
        let joints = 0..R::Joints::LEN;
        if self.velocity.as_slice().iter().all(|v| *v == 0.0) && joints.into_iter().all(|i| self.joint(i).1) {
            return Step::Done;
        }
        self.t += dt;
        Step::Next(Demand::joints(R::Joints::from_joints(|i| self.joint(i).0)))
    }
}

#[generator(ecp)]
impl<R: Robot> JointVelocity<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        let positive = |a: &f64| a.is_finite() && *a > 0.0;
        if !self.acceleration.as_slice().iter().all(positive) {
            return Err(Fault::thrown("the acceleration of a velocity must be finite and > 0"));
        }
        if !self.velocity.as_slice().iter().all(|v| v.is_finite()) {
            return Err(Fault::thrown("a velocity must be finite"));
        }
        let here = e.demanded();
        (self.start, self.t) = (here.joints, 0.0);
        // At half the speed the joints move half as fast as in path time.
        self.found = R::Joints::from_joints(|i| here.velocity[i] * t.duration / t.dt);
        Ok(self.advance(t.dt))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        self.advance(t.dt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_robots::{Conveyor, One, Simulated};
    use std::cell::RefCell;
    use std::rc::Rc;
    use std::time::Duration;

    /// Where a belt is demanded to be in every period of 2 ms while a program runs it by `limit` \[m/s²\].
    fn demanded(speed: f64, program: impl FnMut(&mut Mp) -> Result<(), Fault> + 'static) -> Vec<f64> {
        let belt = Conveyor::new();
        let seen = Rc::new(RefCell::new(Vec::new()));
        let keep = Rc::clone(&seen);
        let drives = Simulated::new(belt.clone(), &One::new(0.0));
        let setup = RobotSetup::new("belt", belt, drives).observe(
            move |record: &mrroc::observe::ServoRecord<Conveyor>| {
                keep.borrow_mut().push(record.demanded[0]);
            },
        );
        let cell = Cell::new(Duration::from_millis(2)).stop_time(Duration::from_secs(20)).robot(setup);
        let cell = cell.on_step(move |_, operator| operator.set_speed(speed).expect("a share"));
        cell.program(program).run().expect("within the limits");
        seen.take()
    }

    #[test]
    fn a_belt_changes_its_velocity_while_it_runs_as_the_closed_form_says_at_any_speed_of_the_operator() {
        const A: f64 = 0.02;
        for speed in [1.0, 0.5] {
            let belt = demanded(speed, |mp| {
                let mut belt = mp.robot::<Conveyor>("belt")?;
                let to = |v: f64| JointVelocity::of(One::new(v), One::new(A));
                let until = |x: f64| Passed(x);
                mp.start_robot(&mut belt, to(0.1))?;
                mp.wait_until((&mut belt,), (), until(0.5))?;
                mp.start_robot(&mut belt, to(0.05))?;
                mp.wait_until((&mut belt,), (), until(0.9))?;
                mp.move_robot(&mut belt, (), to(0.0)).map(drop)
            });
            let speeds: Vec<f64> = belt.windows(2).map(|x| (x[1] - x[0]) / 0.002 / speed).collect();
            assert!(speeds.windows(2).all(|v| (v[1] - v[0]).abs() <= A * 0.002 * speed + 1e-9), "at {speed}");
            for v in [0.1, 0.05] {
                assert!(speeds.iter().filter(|s| (**s - v).abs() < 1e-9).count() > 100, "{v} at {speed}");
            }
            // It passed 0.9 m within a step, and brakes in 0.05² / 2 A.
            let end = belt[belt.len() - 1] - 0.9 - 0.05 * 0.05 / (2.0 * A);
            assert!((0.0..3.0 * 0.05 * 0.002).contains(&end), "{end} at {speed}");
        }
    }

    struct Passed(f64);

    #[condition(mp)]
    fn passed(c: &mut Passed, e: &State<(Conveyor,)>) -> bool {
        e.0.demanded().joints[0] > c.0
    }
}
