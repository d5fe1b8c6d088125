//! Where to start: the frame of an instrument of which nothing is known.
//!
//! A step of the iteration goes far in positions, and no more than about a quarter turn in orientations. So the instrument is tried in the
//! 24 orientations of a cube, each with the arm as it was designed and frames alone to be found, and the best start is taken.

use core::f64::consts::{FRAC_PI_2, PI};

use mrroc::pose::Pose;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::equations::Equations;
use crate::fit::NoFit;
use crate::least_squares::{Settings, minimise};
use crate::loss::Loss;
use crate::problem::{ArmId, FrameId, Freedom, InstrumentId, Problem, Slot};

impl Problem {
    /// Finds about where an instrument stands of which nothing is known, and where its targets are, from its measurements alone; its
    /// device reads positions first (x, y, z), or one distance.
    ///
    /// # Errors
    /// [`NoFit::NoStart`] when no start leads anywhere.
    pub fn find_start(&mut self, instrument: InstrumentId) -> Result<(), NoFit> {
        let no_start = || NoFit::NoStart { instrument: self.instruments[instrument.0].name.clone() };
        let used: Vec<usize> =
            (0..self.measurements.len()).filter(|i| self.measurements[*i].instrument == instrument).collect();
        let frames: Vec<Slot> =
            self.slots().into_iter().filter(|slot| self.belongs(*slot, instrument, &used)).collect();
        let sigma = self.instruments.iter().map(|one| vec![1.0; one.noise.sigma().len()]).collect::<Vec<_>>();
        // What is far off hardly counts: a mistake among the measurements must not choose the start.
        let settings = Settings { loss: Loss::Squares, iterations: 60, tolerance: 1e-6 };
        let mut best: Option<(f64, Vec<Pose>)> = None;
        for rotation in cube() {
            let mut trial = self.clone();
            trial.put(instrument, &used, rotation);
            let equations = Equations::new(&trial, frames.clone(), used.clone(), sigma.clone());
            let Ok(minimum) = minimise(&equations, trial.start(), &settings) else { continue };
            if best.as_ref().is_none_or(|(cost, _)| minimum.cost < *cost) {
                best = Some((minimum.cost, minimum.at.frames));
            }
        }
        let (_, found) = best.ok_or_else(no_start)?;
        for (frame, pose) in self.frames.iter_mut().zip(found) {
            if frame.freedom.free.contains(&true) {
                frame.start = pose;
            }
        }
        Ok(())
    }

    /// Makes a frame in the world the world itself, unless it `is_known` where it is: everything else in the world is told in it from now on, and it
    /// is fixed.
    pub fn anchor(&mut self, frame: FrameId, is_known: bool) {
        if is_known {
            return;
        }
        let world = self.frames[frame.0].start.inverse();
        let on_flange = |id: usize| {
            let targets = self.targets.iter().map(|one| (one.frame, one.on));
            let mut all = targets.chain(self.instruments.iter().map(|one| (one.frame, one.on)));
            all.any(|(own, on)| own.0 == id && on.is_some())
        };
        let moving: Vec<bool> = (0..self.frames.len()).map(|id| !on_flange(id)).collect();
        for (frame, moves) in self.frames.iter_mut().zip(moving) {
            if moves {
                frame.start = world * frame.start;
            }
        }
        self.free(frame, Freedom::FIXED);
    }

    /// Whether a slot is of the frame of this instrument, or of one of its targets.
    fn belongs(&self, slot: Slot, instrument: InstrumentId, used: &[usize]) -> bool {
        let Slot::Frame { frame, .. } = slot else { return false };
        frame == self.instruments[instrument.0].frame.0
            || used.iter().any(|i| self.targets[self.measurements[*i].target.0].frame.0 == frame)
    }

    /// Puts the instrument into an orientation, and where its measurements fit on the mean.
    #[allow(non_snake_case)]
    fn put(&mut self, instrument: InstrumentId, used: &[usize], rotation: UnitQuaternion<f64>) {
        let values = self.start();
        let equations = Equations::new(self, Vec::new(), Vec::new(), Vec::new());
        let flange = |i: usize, on: Option<ArmId>| -> Pose {
            let postures = &self.measurements[i].postures;
            let on = on.and_then(|arm| postures.iter().find(|posture| self.postures[posture.0].arm == arm));
            on.map_or_else(Pose::identity, |posture| {
                equations.flange(&values, &self.postures[posture.0], false).pose
            })
        };
        let own = &self.instruments[instrument.0];
        let mut sum = Vector3::zeros();
        for i in used {
            let measurement = &self.measurements[*i];
            let target = &self.targets[measurement.target.0];
            let X_WT = flange(*i, target.on) * self.frames[target.frame.0].start;
            let X_PT = flange(*i, own.on).inv_mul(&X_WT);
            let read = match &measurement.read[..] {
                [x, y, z, ..] => Vector3::new(*x, *y, *z),
                _ => Vector3::zeros(),
            };
            sum += X_PT.translation.vector - rotation * read;
        }
        let at = Pose::from_parts((sum / used.len() as f64).into(), rotation);
        let frame = own.frame;
        // A full pose tells how its target is turned, too.
        let mut turned = Vec::new();
        for i in used {
            let measurement = &self.measurements[*i];
            let target = &self.targets[measurement.target.0];
            let first = turned.iter().all(|(frame, _)| *frame != target.frame);
            if let [_, _, _, w, x, y, z] = measurement.read[..]
                && first
                && self.frames[target.frame.0].freedom.free[3]
            {
                let R_IT = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
                let R_WT = (flange(*i, own.on) * at).rotation * R_IT;
                let R_FT = flange(*i, target.on).rotation.inverse() * R_WT;
                let position = self.frames[target.frame.0].start.translation;
                turned.push((target.frame, Pose::from_parts(position, R_FT)));
            }
        }
        self.place(frame, at);
        for (frame, pose) in turned {
            self.place(frame, pose);
        }
    }
}

/// The 24 rotations of a cube.
fn cube() -> Vec<UnitQuaternion<f64>> {
    let turn = |axis: Vector3<f64>, angle: f64| UnitQuaternion::from_scaled_axis(axis * angle);
    let sides = [
        UnitQuaternion::identity(),
        turn(Vector3::x(), FRAC_PI_2),
        turn(Vector3::x(), -FRAC_PI_2),
        turn(Vector3::x(), PI),
        turn(Vector3::y(), FRAC_PI_2),
        turn(Vector3::y(), -FRAC_PI_2),
    ];
    let turns = (0..4).map(|k| turn(Vector3::z(), FRAC_PI_2 * f64::from(k)));
    turns.flat_map(|about| sides.map(|side| side * about)).collect()
}
