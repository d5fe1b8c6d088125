//! MRROC++'s law of force control, per axis of the tool's frame.
//!
//! With `T` the path time of a step, `b` the reciprocal damping, `m` the inertia, `Fd` and `F` the wanted and the present load
//! of the tool on its surroundings, `v` the wanted velocity:
//!
//! ```text
//! Delta = [(b (Fd - F) + v) T^2 + b m Delta'] / (T + b m)        X_WE <- X_WE Exp(Delta)
//! u     = [(b (Fd - F) + v) T   + b m u'    ] / (T + b m)        the same by the velocity u = Delta / T
//! ```
//!
//! a first-order lag of the velocity with the time constant `b m`. The second form is the one used: it stays true when the
//! path time of a step changes, and nothing moves at `T = 0`. Source: MRROC++, `edp_e_manip.cc`.

use mrroc::fault::FaultKind;
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::sensor::SensorImage;
use nalgebra::{Translation3, UnitQuaternion, Vector3, Vector6};
use thiserror::Error;

/// The farthest that any tool goes in a step \[m or rad\]: laws that ask for more have numbers of another world.
const FARTHEST: f64 = 1.0;

/// How an axis of the tool's frame behaves: along x, y, z in N and m, about them in N m and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Behaviour {
    /// Moves as told, whatever it feels: `b = m = 0`.
    Unguarded {
        /// `v` [m/s or rad/s].
        velocity: f64,
    },
    /// Moves as told and yields to a contact, at which it comes to rest with the load `v / b`: `Fd = 0`.
    Guarded {
        /// `v` [m/s or rad/s].
        velocity: f64,
        /// How it yields.
        give: Give,
    },
    /// Keeps a load on its surroundings: `v = 0`. Without surroundings it would move for ever, with `b Fd`: so it has bounds.
    Contact {
        /// `Fd`, of the tool on its surroundings [N or N m].
        load: f64,
        /// How it yields.
        give: Give,
        /// How fast it may be, and how far it may go.
        within: Bound,
    },
}

/// How fast an axis that keeps a load may be, and how far it may go for it.
///
/// ```
/// use mrroc_generators::force::{Behaviour, Bound, ForceControl, Give};
///
/// // 10 N along z, found and kept within 50 mm of the start, at 20 mm/s at most.
/// let mut axes = [Behaviour::Unguarded { velocity: 0.0 }; 6];
/// axes[2] = Behaviour::Contact { load: 10.0, give: Give::FORCE, within: Bound { speed: 0.02, travel: 0.05 } };
/// assert!(ForceControl::new(axes).is_ok());
/// axes[2] = Behaviour::Contact { load: 10.0, give: Give::FORCE, within: Bound { speed: 0.02, travel: 0.0 } };
/// assert!(ForceControl::new(axes).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// The largest velocity in either direction [m/s or rad/s], finite, > 0: an axis that would be faster goes at this velocity.
    pub speed: f64,
    /// How far it may be from where it began to keep a load, in either direction [m or rad], finite, > 0. Farther is a fault.
    pub travel: f64,
}

/// How an axis yields to a load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Give {
    /// Reciprocal damping `b` [m/(N s) or rad/(N m s)], finite, > 0.
    pub reciprocal_damping: f64,
    /// Inertia `m` [N s²/m or N m s²/rad], finite, >= 0.
    pub inertia: f64,
}

impl Give {
    /// MRROC++'s along an axis.
    pub const FORCE: Give = Give { reciprocal_damping: 0.005, inertia: 20.0 };
    /// MRROC++'s about an axis.
    pub const TORQUE: Give = Give { reciprocal_damping: 0.1, inertia: 0.5 };
}

/// Why a force law cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error(
    "axis {axis} of the force law: {name} is {value}, it must be finite (damping, speed and travel > 0, inertia >= 0)"
)]
pub struct BadForceLaw {
    /// 0 to 5: x, y, z, about x, about y, about z.
    pub axis: usize,
    /// Which number.
    pub name: &'static str,
    /// Its value, SI.
    pub value: f64,
}

/// The law of all six axes, with the velocity that they have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceControl {
    axes: [Behaviour; 6],
    velocity: Vector6<f64>,
    /// How far each axis has gone since it keeps a load [m or rad].
    travel: Vector6<f64>,
}

/// What a tool feels that moves by a force law, and how far the law has moved it: what a motion may end by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Felt {
    /// Load of the surroundings on the tool, in its axes \[N\], [N m].
    pub load: Wrench,
    /// How far the law has moved the tool since the motion began \[m\], in the axes that the tool had then. What a path moves it
    /// beside is not in it.
    pub travel: Vector3<f64>,
}

/// The load that a wrist sensor tells; `None` before it has told any.
///
/// # Errors
/// A reading that is older than `oldest` \[steps\].
pub fn fresh<S: Sensor<Reading = Wrench>>(
    image: &SensorImage<S>,
    oldest: u32,
) -> Result<Option<Wrench>, Fault> {
    let Some(load) = image.reading() else { return Ok(None) };
    let age = image.age();
    if age > oldest {
        return Err(Fault::new(FaultKind::SensorStale).exceeds(age.into(), oldest.into(), "step"));
    }
    Ok(Some(load))
}

/// What a fault calls the axes.
const AXES: [&str; 6] = ["along x", "along y", "along z", "about x", "about y", "about z"];

impl ForceControl {
    /// At rest, with a behaviour for x, y, z, and about x, y, z of the tool's frame.
    ///
    /// # Errors
    /// A number out of range.
    pub fn new(axes: [Behaviour; 6]) -> Result<Self, BadForceLaw> {
        let law = ForceControl { axes, velocity: Vector6::zeros(), travel: Vector6::zeros() };
        for (axis, behaviour) in axes.iter().enumerate() {
            let (load, velocity, Give { reciprocal_damping, inertia }) = law.of(axis);
            let unguarded = matches!(behaviour, Behaviour::Unguarded { .. });
            let damped = reciprocal_damping > 0.0 || unguarded;
            // Others have none.
            let Bound { speed, travel } = law.bound(axis).unwrap_or(Bound { speed: 1.0, travel: 1.0 });
            for (name, value, holds) in [
                ("load", load, true),
                ("velocity", velocity, true),
                ("reciprocal damping", reciprocal_damping, damped),
                ("inertia", inertia, inertia >= 0.0),
                ("largest speed", speed, speed > 0.0),
                ("longest travel", travel, travel > 0.0),
                ("damping's time constant", reciprocal_damping * inertia, true),
            ] {
                if !(value.is_finite() && holds) {
                    return Err(BadForceLaw { axis, name, value });
                }
            }
        }
        Ok(law)
    }

    /// Wanted load, wanted velocity, and give of an axis.
    fn of(&self, axis: usize) -> (f64, f64, Give) {
        match self.axes[axis] {
            Behaviour::Unguarded { velocity } => {
                (0.0, velocity, Give { reciprocal_damping: 0.0, inertia: 0.0 })
            }
            Behaviour::Guarded { velocity, give } => (0.0, velocity, give),
            Behaviour::Contact { load, give, within: _ } => (load, 0.0, give),
        }
    }

    /// The bound of an axis that keeps a load.
    const fn bound(&self, axis: usize) -> Option<Bound> {
        match self.axes[axis] {
            Behaviour::Unguarded { .. } | Behaviour::Guarded { .. } => None,
            Behaviour::Contact { within, .. } => Some(within),
        }
    }

    /// Another behaviour of an axis (0 to 5) from now on; its velocity stays. The travel of one that begins to keep a load counts
    /// from here; that of one that keeps another load goes on.
    ///
    /// # Errors
    /// A number out of range; the law stays as it was.
    pub fn set(&mut self, axis: usize, behaviour: Behaviour) -> Result<(), BadForceLaw> {
        let mut axes = self.axes;
        if let Some(place) = axes.get_mut(axis) {
            *place = behaviour;
        }
        let (law, before) = (ForceControl::new(axes)?, *self);
        self.axes = law.axes;
        for axis in (0..6).filter(|&axis| before.bound(axis).is_none()) {
            self.travel[axis] = 0.0;
        }
        Ok(())
    }

    /// Velocity of the tool in its own axes [m/s], [rad/s].
    #[must_use]
    pub const fn velocity(&self) -> Vector6<f64> {
        self.velocity
    }

    /// `X_EE'`, the tool's next displacement in its own axes, where its surroundings do `reading` to it. Without path
    /// time (`dt = 0`) the tool is not displaced.
    ///
    /// # Errors
    /// A reading that is not finite, one that asks for more than 1 m or rad in a step, or an axis that has used up its travel for
    /// the load that it is to keep.
    #[allow(non_snake_case)]
    pub fn advance(&mut self, reading: &Wrench, dt: f64) -> Result<Pose, Fault> {
        if !reading.is_finite() {
            return Err(Fault::thrown("the reading of a force law is not finite"));
        }
        if dt <= 0.0 {
            return Ok(Pose::identity());
        }
        let f = &reading.force;
        let m = &reading.torque;
        // The law speaks of what the tool does to its surroundings.
        let present = -Vector6::new(f.x, f.y, f.z, m.x, m.y, m.z);
        for axis in 0..6 {
            let (load, velocity, Give { reciprocal_damping: b, inertia }) = self.of(axis);
            let wanted = b * (load - present[axis]) + velocity;
            self.velocity[axis] = (wanted * dt + b * inertia * self.velocity[axis]) / (dt + b * inertia);
            if let Some(Bound { speed, travel }) = self.bound(axis) {
                // What is not a number stays one, and is refused below.
                let velocity = self.velocity[axis];
                self.velocity[axis] =
                    if velocity.abs() > speed { speed.copysign(velocity) } else { velocity };
                self.travel[axis] += self.velocity[axis] * dt;
                if self.travel[axis].abs() > travel {
                    return Err(used_up(axis, self.travel[axis].abs(), travel));
                }
            }
        }
        let step = self.velocity * dt;
        // What is not a number is too far, too.
        if !step.iter().all(|x| x.abs() <= FARTHEST) {
            return Err(Fault::thrown("the force law asks for more than 1 m or rad in a step"));
        }
        let travel = Vector3::new(step[0], step[1], step[2]);
        let turn = Vector3::new(step[3], step[4], step[5]);
        let R_EE = UnitQuaternion::from_scaled_axis(turn);
        // The velocity goes on in the axes that the tool then has.
        let turned = |from: usize| {
            let v = &self.velocity;
            R_EE.inverse_transform_vector(&Vector3::new(v[from], v[from + 1], v[from + 2]))
        };
        let along = turned(0);
        let about = turned(3);
        self.velocity = Vector6::new(along.x, along.y, along.z, about.x, about.y, about.z);
        Ok(Pose::from_parts(Translation3::from(travel), R_EE))
    }
}

/// The fault of an axis that has gone too far for the load that it is to keep.
#[cold]
fn used_up(axis: usize, gone: f64, travel: f64) -> Fault {
    let text = format!("the force law has used up its travel {} and does not keep its load", AXES[axis]);
    Fault::thrown(&text).exceeds(gone, travel, if axis < 3 { "m" } else { "rad" })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More than any of the tests below goes.
    const WIDE: Bound = Bound { speed: 1.0, travel: 1.0 };
    const STILL: Behaviour = Behaviour::Unguarded { velocity: 0.0 };
    const T: f64 = 2e-3;

    fn along_z(behaviour: Behaviour) -> ForceControl {
        ForceControl::new([STILL, STILL, behaviour, STILL, STILL, STILL]).expect("in range")
    }

    /// Free space: `u_n = b Fd (1 - r^n)`, `r = b m / (T + b m)`, and the travel is `T` times the sum.
    #[test]
    fn a_wanted_load_without_contact_gives_the_step_response_of_a_first_order_lag() {
        let b = 0.005;
        let m = 20.0;
        let load = 10.0;
        let give = Give { reciprocal_damping: b, inertia: m };
        let mut law = along_z(Behaviour::Contact { load, give, within: WIDE });
        let r = b * m / (T + b * m);
        let mut z = 0.0;
        for n in 1..=500 {
            z += law.advance(&Wrench::default(), T).expect("finite").translation.z;
            let decay = r.powi(n);
            assert!((law.velocity()[2] - b * load * (1.0 - decay)).abs() < 1e-13);
            let travel = T * b * load * (f64::from(n) - r * (1.0 - decay) / (1.0 - r));
            assert!((z - travel).abs() < 1e-12, "{z} {travel}");
        }
    }

    /// MRROC++'s own form, with the increment carried instead of the velocity.
    #[test]
    fn equal_steps_give_the_increments_of_the_original_law() {
        let give = Give::FORCE;
        let mut law = along_z(Behaviour::Guarded { velocity: 0.02, give });
        let b = give.reciprocal_damping;
        let m = give.inertia;
        let mut delta = 0.0;
        for n in 0..200 {
            let felt = 3.0 * (f64::from(n) * 0.1).sin();
            let reading = Wrench::new(Vector3::new(0.0, 0.0, -felt), Vector3::zeros());
            let step = law.advance(&reading, T).expect("finite").translation.z;
            delta = ((b * (0.0 - felt) + 0.02) * T * T + b * m * delta) / (T + b * m);
            assert!((step - delta).abs() < 1e-16, "{step} {delta}");
        }
    }

    /// Against a spring: rest where the load is the wanted one, `z = Fd / K`; a guarded axis where it is `v / b`.
    #[test]
    fn against_a_spring_the_load_becomes_the_wanted_one() {
        let stiffness = 2000.0;
        for (behaviour, load) in [
            (Behaviour::Contact { load: 10.0, give: Give::FORCE, within: WIDE }, 10.0),
            (Behaviour::Guarded { velocity: 0.02, give: Give::FORCE }, 4.0),
        ] {
            let mut law = along_z(behaviour);
            let mut z = 0.0_f64;
            for _ in 0..5000 {
                let reading = Wrench::new(Vector3::new(0.0, 0.0, -stiffness * z.max(0.0)), Vector3::zeros());
                z += law.advance(&reading, T).expect("finite").translation.z;
            }
            assert!((stiffness * z - load).abs() < 1e-6, "{} N", stiffness * z);
        }
    }

    /// Free space with a bound: at `b Fd` it would have 50 mm/s, so it goes at the bound's 10 mm/s from when the lag comes to
    /// that, `1 - r^n = 0.2`, and its travel of 20 mm is used up about 2 s later.
    #[test]
    fn fault_131_a_load_that_meets_nothing_moves_no_faster_than_its_bound_and_ends_at_its_range() {
        let within = Bound { speed: 0.01, travel: 0.02 };
        let mut law = along_z(Behaviour::Contact { load: -10.0, give: Give::FORCE, within });
        let (mut z, mut steps) = (0.0, 0);
        let fault = loop {
            match law.advance(&Wrench::default(), T) {
                Ok(step) => z += step.translation.z,
                Err(fault) => break fault,
            }
            steps += 1;
            assert!(law.velocity()[2].abs() <= 0.01 && f64::abs(z) <= 0.02);
            // Another load is kept within the same travel.
            let load = if steps % 2 == 0 { -10.0 } else { -12.0 };
            law.set(2, Behaviour::Contact { load, give: Give::FORCE, within }).expect("in range");
        };
        // The time constant is 0.1 s: until the bound is reached, at most 0.1 s * ln(1 / 0.8) pass.
        assert!((0.02 / 0.01..0.02 / 0.01 + 0.03).contains(&(f64::from(steps) * T)), "{steps}");
        assert!(fault.to_string().contains("used up its travel along z"), "{fault}");
        assert!(fault.excess().is_some_and(|excess| excess.limit == 0.02 && excess.unit == "m"), "{fault}");
        // An axis that begins to keep a load has its whole travel before it.
        law.set(2, STILL).expect("in range");
        law.set(2, Behaviour::Contact { load: -10.0, give: Give::FORCE, within }).expect("in range");
        assert!(law.advance(&Wrench::default(), T).is_ok());
    }

    #[test]
    fn an_unguarded_axis_feels_nothing_and_no_time_moves_nothing() {
        let mut law = along_z(Behaviour::Unguarded { velocity: 0.1 });
        let push = Wrench::new(Vector3::new(0.0, 0.0, -1000.0), Vector3::zeros());
        assert!((law.advance(&push, T).expect("finite").translation.z - 0.1 * T).abs() < 1e-18);
        assert_eq!(law.advance(&push, 0.0), Ok(Pose::identity()));
        let endless = Wrench::new(Vector3::repeat(f64::INFINITY), Vector3::zeros());
        assert!(law.advance(&endless, T).is_err());
    }

    #[test]
    fn numbers_out_of_range_are_named() {
        let give = Give { reciprocal_damping: 0.0, inertia: 1.0 };
        let contact = |give, within| Behaviour::Contact { load: 1.0, give, within };
        let of = |behaviour| ForceControl::new([STILL, behaviour, STILL, STILL, STILL, STILL]);
        let refused = of(contact(give, WIDE));
        assert_eq!(refused, Err(BadForceLaw { axis: 1, name: "reciprocal damping", value: 0.0 }));
        assert!(ForceControl::new([Behaviour::Unguarded { velocity: f64::NAN }; 6]).is_err());
        for (within, name) in [
            (Bound { speed: 0.0, ..WIDE }, "largest speed"),
            (Bound { speed: f64::INFINITY, ..WIDE }, "largest speed"),
            (Bound { travel: f64::NAN, ..WIDE }, "longest travel"),
            (Bound { travel: -0.1, ..WIDE }, "longest travel"),
        ] {
            assert!(of(contact(Give::FORCE, within)).is_err_and(|bad| (bad.axis, bad.name) == (1, name)));
        }
    }
}
