//! What the simulated robots do in: a bar on a table, hands that hold it by springs, a base that is not where it is
//! believed to be.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::cell_file::{Kinds, RobotEntry};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc_robots::grasp::{Body, Fingers, Grasp, Hand, SimulatedWrist, Table, World, WorldError};
use mrroc_robots::{Driven, Gripper, Kinematics, One, Polycrank, Rnt, Simulated, simulated};
use nalgebra::{SVector, Translation3, UnitQuaternion, Vector3};

use crate::places::{EDGES, MASS, TABLE, bar};
use crate::sensed::STIFFNESS;
use crate::slow_fingers::SlowFingers;

/// The arms' drives alone: nothing to hold, and hands at the arms' rate.
#[must_use]
pub fn drives() -> Kinds {
    simulated().with("hand", |entry| {
        let start = entry.start(&Gripper::new())?;
        Ok(hand(Simulated::new(Gripper::new(), &start)))
    })
}

/// A hand; what it grasps keeps the fingers off their demand, which is no fault.
#[must_use]
pub fn hand(drive: impl mrroc::robot::Driver<Gripper> + 'static) -> RobotSetup<Gripper> {
    let limits = *Gripper::new().limits();
    RobotSetup::new("hand", Gripper::new(), drive).following_error(limits.upper - limits.lower)
}

/// An error of calibration of a base, in its own axes: 1 mm along (1, 1, 1), and 0.1 degree about the vertical, which is
/// what moves a tool in front of it most.
#[must_use]
pub fn calibration_error() -> Pose {
    let offset = Vector3::repeat(1e-3 / 3.0_f64.sqrt());
    let turn = Vector3::z() * 0.1_f64.to_radians();
    Pose::from_parts(Translation3::from(offset), UnitQuaternion::from_scaled_axis(turn))
}

/// The bar, the table and the arms' hands; all copies are the same.
#[derive(Clone, Debug)]
pub struct Plant {
    /// The bar's world.
    pub world: World,
    /// Each arm's hand, by the arm's name.
    hands: Rc<RefCell<Vec<(String, Hand)>>>,
    /// Where Polycrank's base truly is, in the frame where it is believed to be.
    error: Pose,
    /// Where it truly is in the world, whatever is believed.
    base: Option<Pose>,
}

impl Plant {
    /// The bar on the table, with Polycrank's base this far off.
    ///
    /// # Errors
    /// A figure of `places.rs` is out of range.
    pub fn new(error: Pose) -> Result<Plant, WorldError> {
        let world = World::new(&Body::block(MASS, EDGES).at(bar()))?.with_table(Table::at(TABLE))?;
        Ok(Plant { world, hands: Rc::default(), error, base: None })
    }

    /// The same with Polycrank's base here, whatever a cell's file believes.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn with_base(self, X_WB: Pose) -> Plant {
        Plant { base: Some(X_WB), ..self }
    }

    /// The kinds of `cell.toml`, with drives in this world.
    #[must_use]
    pub fn kinds(&self) -> Kinds {
        let rnt = self.clone();
        let polycrank = self.clone();
        let hand = self.clone();
        Kinds::new()
            .with("rnt", move |entry| {
                rnt.arm(entry, Rnt::new().with_base(entry.base()), Rnt::new().with_base(entry.base()))
            })
            .with("polycrank", move |entry| {
                let base = polycrank.base.unwrap_or_else(|| entry.base() * polycrank.error);
                let truly = Polycrank::new().with_base(base);
                polycrank.arm(entry, Polycrank::new().with_base(entry.base()), truly)
            })
            .with("hand", move |entry| hand.hand(entry))
    }

    /// An arm as programs believe in it and as it truly is. Its hand closes on the bar wherever that is between its fingers.
    fn arm<const N: usize, R: Driven<N> + Kinematics<N>>(
        &self,
        entry: &RobotEntry,
        believed: R,
        truly: R,
    ) -> Result<RobotSetup<R>, CellError> {
        let start: SVector<f64, N> = entry.start(&believed)?;
        let grasp = Grasp::new(STIFFNESS.force, STIFFNESS.torque).with_tool(entry.tool());
        let arm = self.world.arm(Simulated::new(truly, &start), grasp);
        let arm = arm.map_err(|error| impossible(entry, &error))?;
        self.hands.borrow_mut().push((entry.name().to_owned(), arm.hand()));
        Ok(RobotSetup::new(entry.name(), believed, arm))
    }

    /// The hand of the arm of its name.
    fn hand(&self, entry: &RobotEntry) -> Result<RobotSetup<Gripper>, CellError> {
        let start: One = entry.start(&Gripper::new())?;
        let arm = entry.name().trim_end_matches("-hand");
        let Some(on) = self.hand_of(arm) else {
            let what = format!("the hand `{}` is on no arm", entry.name());
            return Err(entry.refuse_start(what, "call it ARM-hand, below the ARM that it is on".to_owned()));
        };
        let fingers = Fingers::new(Simulated::new(Gripper::new(), &start), on, EDGES[1]);
        Ok(hand(SlowFingers::new(fingers.map_err(|error| impossible(entry, &error))?)))
    }

    /// The hand of an arm that the cell has.
    #[must_use]
    pub fn hand_of(&self, arm: &str) -> Option<Hand> {
        self.hands.borrow().iter().find(|(name, _)| name == arm).map(|(_, hand)| hand.clone())
    }

    /// The cell with a force sensor at each arm's wrist, `ARM-wrist`: with noise, with a bias that it does not know, and with
    /// a hand of 0.8 kg on it, whose weight it takes off (all assumed).
    #[must_use]
    pub fn with_wrists(&self, cell: Cell) -> Cell {
        let bias = Wrench::new(Vector3::new(2.0, -1.0, 3.0), Vector3::new(0.1, 0.2, -0.1));
        self.with_wrists_of(cell, |hand, seed| {
            SimulatedWrist::new(hand)
                .with_tool(0.8, Vector3::new(0.0, 0.0, -0.08))
                .with_bias(bias)
                .with_noise(0.05, 2e-3, seed)
                .with_low_pass(50.0)
        })
    }

    /// The same with other sensors, made from a hand and a number.
    #[must_use]
    pub fn with_wrists_of(&self, cell: Cell, wrist: impl Fn(Hand, u64) -> SimulatedWrist) -> Cell {
        let hands = self.hands.borrow();
        hands.iter().zip(0..).fold(cell, |cell, ((arm, hand), seed)| {
            cell.sensor(SensorSetup::new(&format!("{arm}-wrist"), wrist(hand.clone(), seed)).of(arm))
        })
    }
}

fn impossible(entry: &RobotEntry, error: &WorldError) -> CellError {
    entry.refuse_start(error.to_string(), "write figures in range".to_owned())
}
