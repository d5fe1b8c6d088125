//! What a demand says beside its coordinates, once in a motion: what the robot carries from now on, or where its motion leads.
//!
//! In: a load, or coordinates. Out: the same to seven digits. Every demand has room for one of the two and is copied in every
//! step, so it is small.

use crate::model::joints::{JointVector, MAX_JOINTS};
use crate::model::load::{CompactLoad, LOAD_WORDS, Load};
use crate::model::pose::Pose;
use crate::model::wire::{BadWords, Wire};
use nalgebra::{Quaternion, Translation3, UnitQuaternion};

/// Digits that a goal loses, as a share of its largest number, and the least: places nearer than this are one place.
pub(crate) const GOAL_ROUND_OFF: f64 = 1e-6;

/// Where a motion leads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Goal<J> {
    /// Joint positions [rad or m].
    Joints(J),
    /// `X_WE`.
    Pose(Pose),
    /// `X_EsE`, from the pose demanded at the start of the motion.
    Displacement(Pose),
}

/// A load, a goal, or nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Beside {
    Nothing,
    Load(CompactLoad),
    /// The kind of a goal, and its numbers.
    Goal(u8, [f32; MAX_JOINTS]),
}

const JOINTS: u8 = 1;
const POSE: u8 = 2;
const DISPLACEMENT: u8 = 3;

impl Beside {
    pub const fn is_nothing(&self) -> bool {
        matches!(self, Beside::Nothing)
    }

    pub const fn is_load(&self) -> bool {
        matches!(self, Beside::Load(_))
    }

    pub fn load(&self) -> Option<Load> {
        match self {
            Beside::Load(load) => Some(Load::from(*load)),
            Beside::Nothing | Beside::Goal(..) => None,
        }
    }

    pub fn of_goal<J: JointVector>(goal: &Goal<J>) -> Beside {
        let mut numbers = [0.0; MAX_JOINTS];
        let kind = match goal {
            Goal::Joints(q) => {
                numbers.iter_mut().zip(q.as_slice()).for_each(|(number, q)| *number = *q as f32);
                JOINTS
            }
            Goal::Pose(pose) | Goal::Displacement(pose) => {
                let (p, q) = (pose.translation.vector, pose.rotation.coords);
                numbers.iter_mut().zip(p.iter().chain(q.iter())).for_each(|(number, x)| *number = *x as f32);
                if matches!(goal, Goal::Pose(_)) { POSE } else { DISPLACEMENT }
            }
        };
        Beside::Goal(kind, numbers)
    }

    pub fn goal<J: JointVector>(&self) -> Option<Goal<J>> {
        let Beside::Goal(kind, numbers) = self else { return None };
        let x = numbers.map(f64::from);
        let rotation = Quaternion::new(x[6], x[3], x[4], x[5]);
        let pose = || {
            let place = Translation3::new(x[0], x[1], x[2]);
            Pose::from_parts(place, UnitQuaternion::new_normalize(rotation))
        };
        match *kind {
            JOINTS => Some(Goal::Joints(J::from_joints(|i| x[i]))),
            POSE => Some(Goal::Pose(pose())),
            DISPLACEMENT => Some(Goal::Displacement(pose())),
            _ => None,
        }
    }
}

/// Words of what is said beside coordinates.
pub(crate) const BESIDE_WORDS: usize = LOAD_WORDS;

const _: () = assert!(MAX_JOINTS < BESIDE_WORDS, "a goal takes no more words than a load");

impl Beside {
    /// Puts a load or a goal; the message says elsewhere which it is.
    pub fn put(&self, words: &mut [u64]) {
        match self {
            Beside::Nothing => {}
            Beside::Load(load) => Load::from(*load).put(words),
            Beside::Goal(kind, numbers) => {
                words[0] = u64::from(*kind);
                let said = numbers.iter().map(|x| u64::from(x.to_bits()));
                words[1..].iter_mut().zip(said.chain([0])).for_each(|(word, said)| *word = said);
            }
        }
    }

    pub fn get_load(words: &[u64]) -> Result<Beside, BadWords> {
        Ok(Beside::Load(Load::get(words)?.into()))
    }

    pub fn get_goal(words: &[u64]) -> Result<Beside, BadWords> {
        let words = words.get(..BESIDE_WORDS).ok_or(BadWords)?;
        let kind = u8::try_from(words[0]).ok().filter(|kind| (JOINTS..=DISPLACEMENT).contains(kind));
        let numbers = core::array::from_fn(|i| f32::from_bits(words[1 + i] as u32));
        Ok(Beside::Goal(kind.ok_or(BadWords)?, numbers))
    }
}
