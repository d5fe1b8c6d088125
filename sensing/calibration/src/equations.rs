//! The residuals of a problem and their derivatives, for the slots that are to be found.
//!
//! Each posture is computed once. Where a target or an instrument moves is a list of twists, one for each column of the Jacobian
//! that moves it; a measurement multiplies the slopes of its device by the difference of two such lists.

use mrroc::pose::Pose;
use nalgebra::{DMatrix, DVector, Vector3, Vector6};

use crate::arm::{at, turned, twist};
use crate::least_squares::LeastSquares;
use crate::problem::{ArmId, FrameId, Posture, Problem, Slot, Values};
use crate::scatter::{Block, Whitening, blocks};

/// A problem with the slots to be found, and the measurements that count.
pub(crate) struct Equations<'p> {
    problem: &'p Problem,
    pub(crate) slots: Vec<Slot>,
    start: Values,
    /// The columns of each block's numbers.
    frames: Vec<[Option<usize>; 6]>,
    arms: Vec<Vec<Option<usize>>>,
    constants: Vec<Vec<Option<usize>>>,
    /// The measurements that count.
    pub(crate) used: Vec<usize>,
    /// By instrument the standard deviations of the residuals.
    sigma: Vec<Vec<f64>>,
    /// Slots with a tolerance, and that.
    tolerances: Vec<(usize, f64)>,
    /// What makes measurements of one posture independent of each other, if arms scatter.
    whitening: Vec<Whitening>,
}

/// A frame that moves with some columns: by each its twist at its origin, along the world's axes.
pub(crate) struct Moving {
    pub(crate) pose: Pose,
    pub(crate) twists: Vec<(usize, Vector6<f64>)>,
}

impl<'p> Equations<'p> {
    pub(crate) fn new(
        problem: &'p Problem,
        slots: Vec<Slot>,
        used: Vec<usize>,
        sigma: Vec<Vec<f64>>,
    ) -> Self {
        let mut frames = vec![[None; 6]; problem.frames.len()];
        let start = problem.start();
        let mut arms: Vec<Vec<Option<usize>>> = start.arms.iter().map(|of| vec![None; of.len()]).collect();
        let mut constants: Vec<Vec<Option<usize>>> =
            start.instruments.iter().map(|of| vec![None; of.len()]).collect();
        let mut tolerances = Vec::new();
        for (column, slot) in slots.iter().enumerate() {
            match *slot {
                Slot::Frame { frame, axis } => frames[frame][axis] = Some(column),
                Slot::Arm { arm, i } => arms[arm][i] = Some(column),
                Slot::Constant { instrument, i } => constants[instrument][i] = Some(column),
            }
            if let Some(tolerance) = problem.parameter(*slot).tolerance {
                tolerances.push((column, tolerance));
            }
        }
        Self {
            problem,
            slots,
            start,
            frames,
            arms,
            constants,
            used,
            sigma,
            tolerances,
            whitening: Vec::new(),
        }
    }

    /// The same, where measurements of one posture share what its joints are off by, as seen from `at_values`.
    pub(crate) fn whitened(mut self, at_values: &Values) -> Self {
        self.whitening = self.blocks(at_values).iter().filter_map(Block::whitening).collect();
        self
    }

    /// The measurements that share what joints are off by, and what they share.
    pub(crate) fn blocks(&self, at_values: &Values) -> Vec<Block> {
        if self.problem.arms.iter().all(|arm| arm.scatter.is_empty()) {
            return Vec::new();
        }
        let mut row = 0;
        let rows = self.used.iter().map(|i| {
            let begin = row;
            row += self.problem.device_of(*i).residuals();
            (*i, begin)
        });
        blocks(self.problem, rows.collect(), |measurement, posture, shares| {
            self.shares(at_values, measurement, posture, shares);
        })
    }

    /// By how much the residuals of a measurement change for a standard deviation of each joint of one of its postures, by column.
    pub(crate) fn shares(&self, at_values: &Values, i: usize, posture: usize, shares: &mut DMatrix<f64>) {
        let problem = self.problem;
        let measurement = &problem.measurements[i];
        let instrument = &problem.instruments[measurement.instrument.0];
        let target = &problem.targets[measurement.target.0];
        let flange = |on: Option<ArmId>| -> Option<Moving> {
            let own = |id: &&crate::PostureId| Some(problem.postures[id.0].arm) == on;
            let id = measurement.postures.iter().find(own)?;
            let mut flange = self.flange(at_values, &problem.postures[id.0], false);
            if id.0 == posture {
                let Posture { arm, q, torques } = &problem.postures[posture];
                let part = &problem.arms[arm.0];
                let values = &at_values.arms[arm.0];
                let mut own = vec![Vector6::zeros(); q.len()];
                part.model.joint_twists(&part.bent(q, torques, values), part.parts(values).0, &mut own);
                let rotation = at_values.frames[part.base.0].rotation;
                let scaled =
                    own.iter().zip(&part.scatter).map(|(one, sigma)| turned(one, &rotation) * *sigma);
                flange.twists = scaled.enumerate().collect();
            }
            Some(flange)
        };
        let (own, carried) = (flange(instrument.on), flange(target.on));
        let place = |on: Option<&Moving>, frame: FrameId| -> Moving {
            let own = at_values.frames[frame.0];
            let Some(on) = on else { return Moving { pose: own, twists: Vec::new() } };
            let pose = on.pose * own;
            let from = pose.translation.vector - on.pose.translation.vector;
            let twists = on.twists.iter().map(|(column, one)| (*column, at(one, &from))).collect();
            Moving { pose, twists }
        };
        let (from, to) = (place(own.as_ref(), instrument.frame), place(carried.as_ref(), target.frame));
        let seen = from.pose.inv_mul(&to.pose);
        let constants = &at_values.instruments[measurement.instrument.0];
        let device = problem.device_of(i);
        let mut slopes = DMatrix::zeros(device.residuals(), 6 + constants.len());
        device.slopes(&seen, constants, &measurement.read, &mut slopes);
        let into = from.pose.rotation.inverse();
        let apart = to.pose.translation.vector - from.pose.translation.vector;
        let sigma = &self.sigma[measurement.instrument.0];
        let slopes = slopes.columns(0, 6);
        let moved = to.twists.iter().map(|(joint, one)| (*joint, *one));
        let moved = moved.chain(from.twists.iter().map(|(joint, one)| (*joint, -at(one, &apart))));
        for (joint, one) in moved {
            let effect = slopes * turned(&one, &into);
            for (row, sigma) in sigma.iter().enumerate().take(effect.len()) {
                shares[(row, joint)] += effect[row] / sigma;
            }
        }
    }

    /// How many residuals are measured, and not believed.
    pub(crate) fn measured(&self) -> usize {
        self.used.iter().map(|i| self.problem.device_of(*i).residuals()).sum::<usize>()
            + self.problem.bars.len()
    }

    /// The flange of an arm in a posture, in the world.
    #[allow(non_snake_case)]
    pub(crate) fn flange(&self, at_values: &Values, posture: &Posture, with_twists: bool) -> Moving {
        let Posture { arm, q, torques } = posture;
        let part = &self.problem.arms[arm.0];
        let X_WB = at_values.frames[part.base.0];
        let values = &at_values.arms[arm.0];
        let (own_values, compliances) = part.parts(values);
        let q = &*part.bent(q, torques, values);
        if !with_twists {
            return Moving { pose: X_WB * part.model.flange(q, own_values), twists: Vec::new() };
        }
        let mut own = vec![Vector6::zeros(); values.len()];
        let (of_model, of_compliances) = own.split_at_mut(own_values.len());
        let X_BF = part.model.linearise(q, own_values, of_model);
        if !compliances.is_empty() {
            let mut by_joint = vec![Vector6::zeros(); q.len()];
            part.model.joint_twists(q, own_values, &mut by_joint);
            for ((twist, (joint, _)), torque) in of_compliances.iter_mut().zip(&part.soft).zip(torques) {
                *twist = by_joint[*joint] * *torque;
            }
        }
        let pose = X_WB * X_BF;
        let from_base = pose.translation.vector - X_WB.translation.vector;
        let mut twists: Vec<(usize, Vector6<f64>)> =
            self.frame_twists(part.base, &X_WB).map(|(column, one)| (column, at(&one, &from_base))).collect();
        let columns = self.arms[arm.0].iter().zip(&own);
        twists.extend(columns.filter_map(|(column, one)| Some(((*column)?, turned(one, &X_WB.rotation)))));
        Moving { pose, twists }
    }

    /// How a frame moves by its own numbers, at its origin along the world's axes, with its pose in the world.
    #[allow(non_snake_case)]
    fn frame_twists(&self, frame: FrameId, X_WF: &Pose) -> impl Iterator<Item = (usize, Vector6<f64>)> {
        let rotation = X_WF.rotation;
        let columns = self.frames[frame.0];
        columns.into_iter().enumerate().filter_map(move |(axis, column)| {
            let along = rotation * Vector3::ith(axis % 3, 1.0);
            let none = Vector3::zeros();
            Some((column?, if axis < 3 { twist(&along, &none) } else { twist(&none, &along) }))
        })
    }

    /// A frame that stands in the world, or on what moves.
    pub(crate) fn mounted(
        &self,
        at_values: &Values,
        on: Option<&Moving>,
        frame: FrameId,
        with_twists: bool,
    ) -> Moving {
        let own = at_values.frames[frame.0];
        let pose = on.map_or(own, |on| on.pose * own);
        let mut twists = Vec::new();
        if with_twists {
            if let Some(on) = on {
                let from = pose.translation.vector - on.pose.translation.vector;
                twists.extend(on.twists.iter().map(|(column, one)| (*column, at(one, &from))));
            }
            twists.extend(self.frame_twists(frame, &pose));
        }
        Moving { pose, twists }
    }

    /// Where one frame of the world is in another, and by column how it moves there, along the axes of that other one.
    pub(crate) fn apart(
        &self,
        at_values: &Values,
        from: FrameId,
        to: FrameId,
    ) -> (Pose, Vec<(usize, Vector6<f64>)>) {
        let [from, to] = [from, to].map(|frame| self.mounted(at_values, None, frame, true));
        let apart = to.pose.translation.vector - from.pose.translation.vector;
        let into = from.pose.rotation.inverse();
        let ahead = to.twists.iter().map(|(column, one)| (*column, turned(one, &into)));
        let back = from.twists.iter().map(|(column, one)| (*column, -turned(&at(one, &apart), &into)));
        (from.pose.inv_mul(&to.pose), ahead.chain(back).collect())
    }

    /// How a standard deviation of each joint moves a frame of an arm, at its origin along the world's axes.
    #[allow(non_snake_case)]
    pub(crate) fn scattered(&self, at_values: &Values, posture: &Posture, X_WT: &Pose) -> Vec<Vector6<f64>> {
        let Posture { arm, q, torques } = posture;
        let part = &self.problem.arms[arm.0];
        if part.scatter.is_empty() {
            return Vec::new();
        }
        let values = &at_values.arms[arm.0];
        let mut own = vec![Vector6::zeros(); q.len()];
        part.model.joint_twists(&part.bent(q, torques, values), part.parts(values).0, &mut own);
        let from = X_WT.translation.vector - self.flange(at_values, posture, false).pose.translation.vector;
        let rotation = at_values.frames[part.base.0].rotation;
        let moved = own.iter().zip(&part.scatter);
        moved.map(|(one, sigma)| at(&turned(one, &rotation), &from) * *sigma).collect()
    }

    fn all(&self, at_values: &Values, residuals: &mut [f64], mut jacobian: Option<&mut DMatrix<f64>>) {
        let problem = self.problem;
        let mut needed = vec![false; problem.postures.len()];
        for i in &self.used {
            for posture in &problem.measurements[*i].postures {
                needed[posture.0] = true;
            }
        }
        let with_twists = jacobian.is_some();
        let flanges: Vec<Option<Moving>> = problem
            .postures
            .iter()
            .zip(&needed)
            .map(|(posture, needed)| needed.then(|| self.flange(at_values, posture, with_twists)))
            .collect();
        if let Some(jacobian) = jacobian.as_deref_mut() {
            jacobian.fill(0.0);
        }
        let mut row = 0;
        let mut slopes = DMatrix::zeros(0, 0);
        let mut foretold = Vec::new();
        for i in &self.used {
            let measurement = &problem.measurements[*i];
            let instrument = &problem.instruments[measurement.instrument.0];
            let target = &problem.targets[measurement.target.0];
            let flange = |on: Option<ArmId>| {
                let on = on?;
                let posture =
                    measurement.postures.iter().find(|posture| problem.postures[posture.0].arm == on)?;
                flanges[posture.0].as_ref()
            };
            let from = self.mounted(at_values, flange(instrument.on), instrument.frame, with_twists);
            let to = self.mounted(at_values, flange(target.on), target.frame, with_twists);
            let seen = from.pose.inv_mul(&to.pose);
            let constants = &at_values.instruments[measurement.instrument.0];
            let device = problem.device_of(*i);
            let k = device.residuals();
            foretold.resize(device.readings(), 0.0);
            device.predict(&seen, constants, &mut foretold);
            device.difference(&measurement.read, &foretold, &mut residuals[row..row + k]);
            let sigma = &self.sigma[measurement.instrument.0];
            for (residual, sigma) in residuals[row..row + k].iter_mut().zip(sigma) {
                *residual /= sigma;
            }
            if let Some(jacobian) = jacobian.as_deref_mut() {
                if slopes.shape() != (k, 6 + constants.len()) {
                    slopes = DMatrix::zeros(k, 6 + constants.len());
                }
                device.slopes(&seen, constants, &measurement.read, &mut slopes);
                let into = from.pose.rotation.inverse();
                let apart = to.pose.translation.vector - from.pose.translation.vector;
                let mut add = |column: usize, one: &Vector6<f64>, sign: f64| {
                    let one = turned(one, &into);
                    for i in 0..k {
                        let slope: f64 = (0..6).map(|axis| slopes[(i, axis)] * one[axis]).sum();
                        jacobian[(row + i, column)] += sign * slope / sigma[i];
                    }
                };
                for (column, one) in &to.twists {
                    add(*column, one, 1.0);
                }
                for (column, one) in &from.twists {
                    add(*column, &at(one, &apart), -1.0);
                }
                for (i, column) in self.constants[measurement.instrument.0].iter().enumerate() {
                    let Some(column) = column else { continue };
                    for (j, sigma) in sigma.iter().enumerate().take(k) {
                        jacobian[(row + j, *column)] += slopes[(j, 6 + i)] / sigma;
                    }
                }
            }
            row += k;
        }
        for bar in &problem.bars {
            let [a, b] =
                bar.ends.map(|end| self.mounted(at_values, None, problem.targets[end.0].frame, with_twists));
            let apart = b.pose.translation.vector - a.pose.translation.vector;
            let length = apart.norm();
            residuals[row] = (bar.length - length) / bar.sigma;
            if let Some(jacobian) = jacobian.as_deref_mut() {
                // Ends that begin in one place part in some direction.
                let along = if length > 0.0 { apart / length } else { Vector3::x() };
                for (end, sign) in [(&a, 1.0), (&b, -1.0)] {
                    for (column, one) in &end.twists {
                        let linear = Vector3::new(one[0], one[1], one[2]);
                        jacobian[(row, *column)] += sign * along.dot(&linear) / bar.sigma;
                    }
                }
            }
            row += 1;
        }
        for (column, tolerance) in &self.tolerances {
            residuals[row] = at_values.get(self.slots[*column], &self.start) / tolerance;
            if let Some(jacobian) = jacobian.as_deref_mut() {
                jacobian[(row, *column)] = 1.0 / tolerance;
            }
            row += 1;
        }
    }

    /// The residuals, each by itself, whatever measurements share.
    pub(crate) fn plain(&self, at_values: &Values) -> DVector<f64> {
        let mut residuals = DVector::zeros(LeastSquares::residuals(self));
        self.all(at_values, residuals.as_mut_slice(), None);
        residuals
    }

    /// By measurement that counts what its instrument read more than foretold [m or rad].
    pub(crate) fn raw(&self, at_values: &Values) -> Vec<(usize, Vec<f64>)> {
        let residuals = self.plain(at_values);
        let mut row = 0;
        let mut raw = Vec::new();
        for i in &self.used {
            let instrument = self.problem.measurements[*i].instrument.0;
            let k = self.problem.device_of(*i).residuals();
            let sigma = &self.sigma[instrument];
            raw.push((*i, (0..k).map(|j| residuals[row + j] * sigma[j]).collect()));
            row += k;
        }
        raw
    }
}

impl LeastSquares for Equations<'_> {
    type At = Values;

    fn parameters(&self) -> usize {
        self.slots.len()
    }

    fn residuals(&self) -> usize {
        self.measured() + self.tolerances.len()
    }

    fn moved(&self, at_values: &Values, step: &[f64]) -> Values {
        at_values.moved(&self.slots, step)
    }

    fn evaluate(&self, at_values: &Values, residuals: &mut [f64]) {
        self.all(at_values, residuals, None);
        self.whitening.iter().for_each(|own| own.apply(residuals));
    }

    fn linearise(&self, at_values: &Values, residuals: &mut [f64], jacobian: &mut DMatrix<f64>) {
        self.all(at_values, residuals, Some(&mut *jacobian));
        for own in &self.whitening {
            own.apply(residuals);
            jacobian.column_iter_mut().for_each(|mut column| own.apply(column.as_mut_slice()));
        }
    }
}
