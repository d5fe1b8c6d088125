//! The conformance suite is worth something only if it fails: each defect is caught by the check that is meant for it.

use mrroc::prelude::*;
use mrroc::robot::{CoupledLimit, DriveFault, Driver, Homing, Limits, Measured, NoInverse, Search};
use mrroc_robots::{Irp6, Jacobian, Kinematics, SimulatedIrp6, Six, Unhomed, conformance};

use crate::support::engraving;

#[derive(Clone, Copy, PartialEq)]
enum Defect {
    None,
    /// The other wrist than the nearest.
    FarBranch,
    /// The pose is missed by a micrometre.
    Inexact,
    /// Angular rows before linear ones.
    SwappedRows,
    /// One solution is visited again.
    TwiceVisited,
    /// Out of reach is answered by NaN.
    Nan,
    /// A lower limit above the upper one.
    Limits,
}

/// An IRp-6 with a defect.
#[derive(Clone)]
struct Broken(Irp6, Defect, Limits<Six>);

fn broken(defect: Defect) -> Broken {
    let arm = Irp6::nominal();
    let mut limits = *arm.limits();
    if defect == Defect::Limits {
        limits.lower[3] = limits.upper[3] + 0.1;
    }
    Broken(arm, defect, limits)
}

impl Robot for Broken {
    const KIND: &'static str = "broken";
    type Joints = Six;

    fn limits(&self) -> &Limits<Six> {
        &self.2
    }

    fn check_coupled(&self, from: &Six, to: &Six, duration: f64) -> Result<(), CoupledLimit> {
        self.0.check_coupled(from, to, duration)
    }

    fn forward(&self, q: &Six) -> Pose {
        self.0.forward(q)
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Six) -> Result<Six, NoInverse> {
        let found = self.0.inverse(X_WF, near);
        match self.1 {
            Defect::FarBranch => {
                let both = self.0.all_solutions(X_WF, near);
                let far = both
                    .into_iter()
                    .flatten()
                    .max_by(|a, b| (a - near).norm_squared().total_cmp(&(b - near).norm_squared()));
                far.map_or(found, Ok)
            }
            Defect::Inexact => found.map(|q| q + Six::new(0.0, 1e-6, 0.0, 0.0, 0.0, 0.0)),
            Defect::Nan => found.or(Ok(Six::repeat(f64::NAN))),
            Defect::None | Defect::SwappedRows | Defect::TwiceVisited | Defect::Limits => found,
        }
    }
}

impl Kinematics<6> for Broken {
    fn reach(&self) -> f64 {
        self.0.reach()
    }

    fn jacobian(&self, q: &Six) -> Jacobian<6> {
        let right = self.0.jacobian(q);
        let wrong = self.1 == Defect::SwappedRows;
        Jacobian::from_fn(|i, j| if wrong { right[((i + 3) % 6, j)] } else { right[(i, j)] })
    }

    #[allow(non_snake_case)]
    fn solutions(&self, X_WF: &Pose, near: &Six, visit: &mut dyn FnMut(&Six)) -> Result<(), NoInverse> {
        self.0.solutions(X_WF, near, &mut |q| {
            visit(q);
            if self.1 == Defect::TwiceVisited {
                visit(q);
            }
        })
    }
}

#[test]
fn every_defect_of_kinematics_is_caught_and_none_is_invented() {
    let caught = |defect| {
        let robot = broken(defect);
        [
            conformance::limits_are_sound(&robot, &engraving()).is_err(),
            defect != Defect::Limits && conformance::inverse_returns_poses(&robot, 500).is_err(),
            defect != Defect::Limits && conformance::solutions_are_complete(&robot, 200).is_err(),
            defect != Defect::Limits && conformance::jacobian_is_the_derivative(&robot, 50).is_err(),
            conformance::nothing_is_nan(&robot, &engraving()).is_err(),
        ]
    };
    assert_eq!(caught(Defect::None), [false; 5]);
    assert!(caught(Defect::FarBranch)[1] && caught(Defect::FarBranch)[2]);
    assert!(caught(Defect::Inexact)[1]);
    assert_eq!(caught(Defect::SwappedRows), [false, false, false, true, false]);
    assert_eq!(caught(Defect::TwiceVisited), [false, false, true, false, false]);
    assert_eq!(caught(Defect::Nan), [false, false, false, false, true]);
    assert!(caught(Defect::Limits)[0]);
}

#[derive(Clone, Copy, PartialEq)]
enum Slip {
    /// A fault is forgotten in the next tick.
    Forgets,
    /// Never refuses: the last good demand is repeated.
    Swallows,
    /// Measures what is demanded a tenth of a second late.
    Lags,
    /// Stays where it is after half a second.
    Sticks,
}

/// A simulated arm with a defect.
struct Slipping {
    arm: SimulatedIrp6,
    slip: Slip,
    late: Vec<Six>,
}

impl Driver<Irp6> for Slipping {
    fn period(&self) -> std::time::Duration {
        Driver::<Irp6>::period(&self.arm)
    }

    fn measured(&self) -> Result<Measured<Six>, DriveFault> {
        self.arm.measured()
    }

    fn tick(&mut self, demanded: &Six) -> Result<Measured<Six>, DriveFault> {
        match self.slip {
            Slip::Forgets => self.arm.tick(demanded).inspect_err(|_| self.arm.reset()),
            Slip::Swallows => {
                let refused = !demanded.iter().all(|q| q.is_finite());
                self.arm.tick(&if refused { self.arm.measured()?.position } else { *demanded })
            }
            Slip::Sticks => {
                self.late.push(*demanded);
                self.arm.tick(&self.late[(self.late.len() - 1).min(250)])
            }
            Slip::Lags => {
                self.late.push(*demanded);
                let then = self.late.len().saturating_sub(50);
                self.arm.tick(&self.late[then])
            }
        }
    }
}

#[test]
fn every_slip_of_a_driver_is_caught() {
    let robot = Irp6::nominal();
    let make = |slip| {
        move || Slipping {
            arm: SimulatedIrp6::new(Irp6::nominal(), &engraving()),
            slip,
            late: vec![engraving()],
        }
    };
    assert!(conformance::refuses(&robot, make(Slip::Forgets), &engraving()).is_err());
    assert!(conformance::comes_to_rest(&robot, make(Slip::Forgets)(), &engraving()).is_err());
    assert!(conformance::refuses(&robot, make(Slip::Swallows), &engraving()).is_err());
    assert!(conformance::follows_slowly(&robot, make(Slip::Lags), &engraving()).is_err());
    assert!(conformance::bears_lost_demands(&robot, make(Slip::Sticks), &engraving()).is_err());
    assert!(conformance::bears_lost_demands(&robot, make(Slip::Forgets), &engraving()).is_ok());
}

/// A search with a defect: it is over at once, or its drives tick at another pace than they say.
struct Hasty(Unhomed<Irp6, 6>, bool);

impl Homing<Irp6> for Hasty {
    type Drives = SimulatedIrp6;

    fn period(&self) -> std::time::Duration {
        if self.1 { std::time::Duration::from_millis(1) } else { self.0.period() }
    }

    fn search(self) -> Result<Search<Self, SimulatedIrp6>, DriveFault> {
        if !self.1 {
            // Where the drives are told to be at the edge of their limits, there is no robot.
            let edge = Six::new(3.5, -1.57, 0.16, -0.16, 4.71, 0.0);
            return Ok(Search::Found(SimulatedIrp6::new(Irp6::nominal(), &edge)));
        }
        self.0.search().map(|outcome| match outcome {
            Search::Searching(on) => Search::Searching(Hasty(on, true)),
            Search::Found(drives) => Search::Found(drives),
        })
    }
}

#[test]
fn every_slip_of_homing_is_caught() {
    let robot = Irp6::nominal();
    let starts = [engraving(), engraving() + Six::repeat(0.05)];
    let unhomed = |q: &Six| Unhomed::new(Irp6::nominal(), q);
    let caught = |outcome: Result<(), conformance::Violation>, told: &str| {
        let why = outcome.expect_err("a slip").to_string();
        assert!(why.contains(told), "{why}");
    };
    caught(conformance::finds_its_marks(&robot, |q| Hasty(unhomed(q), false), &starts), "outside of");
    caught(conformance::finds_its_marks(&robot, |q| Hasty(unhomed(q), true), &starts), "it searches every");
    let other = |joint: usize| {
        let mut homing = unhomed(&engraving());
        homing.block((joint + 1) % 6);
        homing
    };
    caught(conformance::trips_where_jammed(&robot, other), "is jammed, and joint");
    caught(conformance::trips_where_jammed(&robot, |_| unhomed(&engraving())), "is jammed, and found");
    let places = std::cell::Cell::new(0.0);
    let elsewhere = |q: &Six| {
        places.set(places.get() + 0.01);
        unhomed(&(q + Six::repeat(places.get())))
    };
    assert!(conformance::searches_alike(&robot, elsewhere, &starts).is_err());
}
