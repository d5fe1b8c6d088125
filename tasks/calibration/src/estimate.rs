//! From sights to a calibrated cell: the problem, and how good its solution is.

use mrroc::pose::Pose;
use mrroc_calibration::{
    Angles, ArmId, Fit, Freedom, Irp6Arm, NoFit, Noise, PostureId, Problem, Settings, TargetId,
};
use mrroc_robots::{Irp6, Six};
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::scene::{ARMS, BALLS, BAR, NAMES, Scene, bar_ends, believed_bases, believed_theodolites};
use crate::theodolite::LEVEL;

/// What was sighted.
#[derive(Clone, Debug, PartialEq)]
pub enum Sighted {
    /// A ball of an arm, with what its encoders read \[rad\].
    Ball {
        /// Which arm.
        arm: usize,
        /// Which of its balls.
        ball: usize,
        /// The arm's posture, counted for itself.
        posture: usize,
    },
    /// An end of the scale bar.
    End(usize),
}

/// A sight: the mean of both faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// Which theodolite.
    pub theodolite: usize,
    /// What it sighted.
    pub of: Sighted,
    /// Horizontal angle and elevation \[rad\].
    pub read: [f64; 2],
}

/// Everything that was measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sights {
    /// By arm what its encoders read in each posture \[rad\].
    pub postures: [Vec<Six>; ARMS],
    /// The sights.
    pub sights: Vec<Sight>,
}

/// A solved cell.
pub struct Estimate {
    /// The solution.
    pub fit: Fit,
    /// The arms.
    pub arms: [ArmId; ARMS],
    /// The balls of each.
    pub balls: [[TargetId; 3]; ARMS],
    /// The problem.
    pub problem: Problem,
}

/// Finds the arms' dimensions, bases and balls, and the second theodolite's place.
///
/// # Errors
/// [`NoFit`].
pub fn estimate(measured: &Sights) -> Result<Estimate, NoFit> {
    let mut problem = Problem::new();
    let bases = believed_bases();
    let arms: [ArmId; ARMS] = core::array::from_fn(|i| {
        problem.arm(NAMES[i], Irp6Arm::new(Irp6::nominal()), bases[i], Freedom::FRAME)
    });
    let balls: [[TargetId; 3]; ARMS] = core::array::from_fn(|arm| {
        core::array::from_fn(|ball| {
            let place = Pose::translation(BALLS[ball][0], BALLS[ball][1], BALLS[ball][2]);
            problem.target(
                &format!("{} ball {}", NAMES[arm], ball + 1),
                Some(arms[arm]),
                place,
                Freedom::POINT,
            )
        })
    });
    let ends = bar_ends()
        .map(|end| problem.target("bar", None, Pose::translation(end.x, end.y, end.z), Freedom::POINT));
    problem.bar(ends, BAR.0, BAR.1);
    let level = |freedom: Freedom| freedom.within(3..5, LEVEL);
    let south = Freedom { free: [true, true, true, false, false, true], ..Freedom::FIXED };
    let freedoms = [level(Freedom::FIXED), level(south)];
    let theodolites: [_; 2] = core::array::from_fn(|i| {
        let name = ["north", "south"][i];
        let noise = Noise::Unknown(vec![1e-5; 2]);
        problem.instrument(name, Angles::both_faces(), None, believed_theodolites()[i], freedoms[i], noise)
    });
    let postures: [Vec<PostureId>; ARMS] = core::array::from_fn(|arm| {
        measured.postures[arm].iter().map(|q| problem.posture(arms[arm], q.as_slice())).collect()
    });
    for sight in &measured.sights {
        let instrument = theodolites[sight.theodolite];
        match sight.of {
            Sighted::Ball { arm, ball, posture } => {
                problem.measure(instrument, balls[arm][ball], &[postures[arm][posture]], &sight.read);
            }
            Sighted::End(end) => problem.measure(instrument, ends[end], &[], &sight.read),
        }
    }
    let fit = problem.fit(&Settings { tolerance: 1e-10, ..Settings::default() })?;
    Ok(Estimate { fit, arms, balls, problem })
}

/// How good an estimate is: errors of balls at postures that were not used.
#[derive(Clone, Copy, Debug)]
pub struct Accuracy {
    /// Root mean square in the world, which the theodolites define \[m\].
    pub rms: f64,
    /// The largest \[m\].
    pub max: f64,
    /// What the covariance foretells of the root mean square \[m\].
    pub foretold: f64,
    /// Root mean square of the arm by itself, its base where that fits best \[m\].
    pub own: f64,
}

impl Estimate {
    /// Errors of all balls of an arm at postures that were not used, in the world.
    #[must_use]
    pub fn accuracy(&self, scene: &Scene, arm: usize, postures: &[Six]) -> Accuracy {
        let (mut squares, mut max, mut foretold, mut count) = (0.0, 0.0_f64, 0.0, 0);
        let mut pairs = Vec::new();
        for q in postures {
            let joints = scene.joints(arm, q);
            for ball in 0..BALLS.len() {
                let frame = self.problem.frame_of(self.balls[arm][ball]);
                let (there, spread) = self.fit.place(self.arms[arm], q.as_slice(), frame);
                let truly = scene.ball(arm, ball, &joints);
                let off = (there.translation.vector - truly).norm();
                pairs.push((there.translation.vector, truly));
                squares += off * off;
                max = max.max(off);
                foretold += spread.fixed_view::<3, 3>(0, 0).trace();
                count += 1;
            }
        }
        let n = f64::from(count);
        Accuracy { rms: (squares / n).sqrt(), max, foretold: (foretold / n).sqrt(), own: own(&pairs) }
    }

    /// How far the base of the right arm is from where the estimate has it in the left one.
    #[must_use]
    pub fn bases(&self, scene: &Scene) -> Bases {
        let [left, right] = self.arms.map(|arm| self.problem.base_of(arm));
        let (found, spread) = self.fit.between(left, right);
        let truth = base_of(scene, 0).inv_mul(&base_of(scene, 1));
        let off = mrroc_calibration::between(&found, &truth);
        // Along the axes of the left base, as the covariance is.
        let within = |i: &usize| off[*i].abs() < 2.0 * spread[(*i, *i)].sqrt();
        Bases {
            within: (0..6).filter(within).count(),
            length: off.fixed_rows::<3>(0).norm(),
            angle: off.fixed_rows::<3>(3).norm(),
            length_sigma: spread.fixed_view::<3, 3>(0, 0).trace().sqrt(),
            angle_sigma: spread.fixed_view::<3, 3>(3, 3).trace().sqrt(),
        }
    }
}

/// How well the place of one base in the other is found: errors, and standard deviations that the covariance foretells of them.
#[derive(Clone, Copy, Debug)]
pub struct Bases {
    /// Of the position \[m\].
    pub length: f64,
    /// Of the orientation \[rad\].
    pub angle: f64,
    /// Foretold \[m\].
    pub length_sigma: f64,
    /// Foretold \[rad\].
    pub angle_sigma: f64,
    /// How many of the six numbers, along the axes of the left base, are within two standard deviations.
    pub within: usize,
}

/// Root mean square of the distances of pairs of points, after the rigid motion that makes it least (Kabsch 1976).
fn own(pairs: &[(Vector3<f64>, Vector3<f64>)]) -> f64 {
    let n = pairs.len() as f64;
    let (a, b) = pairs
        .iter()
        .fold((Vector3::zeros(), Vector3::zeros()), |sum, pair| (sum.0 + pair.0 / n, sum.1 + pair.1 / n));
    let moment: Matrix3<f64> = pairs.iter().map(|pair| (pair.1 - b) * (pair.0 - a).transpose()).sum();
    let rotation = Rotation3::from_matrix_eps(&moment, 1e-12, 100, Rotation3::identity());
    let squares: f64 = pairs.iter().map(|pair| (rotation * (pair.0 - a) - (pair.1 - b)).norm_squared()).sum();
    (squares / n).sqrt()
}

/// Where the base of an arm truly is, at the zero that its programs believe in: of its turn and that of the column only the sum can be told.
fn base_of(scene: &Scene, arm: usize) -> Pose {
    let mut base = None;
    mrroc::robot::Robot::frames(&scene.arms[arm], &Six::zeros(), &mut |frame| {
        base.get_or_insert(*frame);
    });
    let column = |arm: &Irp6| arm.transmission().column.offset;
    let turn = column(&scene.arms[arm]) - column(&Irp6::nominal());
    base.unwrap_or_else(Pose::identity) * Pose::rotation(nalgebra::Vector3::z() * turn)
}
