//! From sights to a calibrated cell: the problem, and how good its solution is.

use mrroc::pose::Pose;
use mrroc_calibration::{
    Angles, ArmId, Compliance, Fit, Freedom, InstrumentId, Irp6Arm, NoFit, Noise, PostureId, Problem,
    Settings, TargetId,
};
use mrroc_robots::{Irp6, Six};
use nalgebra::{Matrix3, Rotation3, Vector3, Vector6};

use crate::scene::{
    ARMS, BALLS, BAR, BARS, NAMES, Scene, bar_ends, believed_bases, believed_theodolites, torques,
};
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
    /// An end of the scale bar in one of its places.
    End {
        /// Which place.
        bar: usize,
        /// Which end.
        end: usize,
    },
    /// The other theodolite: the centre of its telescope.
    Other,
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
    /// By arm what hung on it in each posture \[kg\].
    pub payloads: [Vec<f64>; ARMS],
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

/// The cell as a problem, with everything where it is believed to be, and nothing measured.
pub struct Stated {
    /// The problem.
    pub problem: Problem,
    /// The arms.
    pub arms: [ArmId; ARMS],
    /// The balls of each.
    pub balls: [[TargetId; 3]; ARMS],
    ends: [[TargetId; 2]; BARS],
    theodolites: [InstrumentId; 2],
    telescopes: [TargetId; 2],
}

/// What friction leaves between a motor and its joint, as is believed \[rad\].
pub const SCATTER: f64 = 1e-5;

/// What compliances may be [rad/(N m)], and what comes of the links' weight, of which a fifth more or less is believed.
const COMPLIANCE: f64 = 5e-6;
const OWN: f64 = 0.2 * COMPLIANCE;

/// Joints that bend under all weight, and those of which the arm's own is not known well. Column and N have no weight to bear, T and V only
/// that of a payload.
fn compliances() -> [Compliance; 6] {
    let bends =
        |joint, what, tolerance| Compliance { joint, name: format!("joint {} {what}", joint + 1), tolerance };
    let load = |joint| bends(joint, "compliance", COMPLIANCE);
    let own = |joint| bends(joint, "own weight", OWN);
    [load(1), load(2), load(3), load(4), own(1), own(2)]
}

/// What bends them where the encoders of an arm read `q` \[rad\] with a payload \[kg\] [N m].
#[must_use]
pub fn bending(q: &Six, payload: f64) -> [f64; 6] {
    let (all, own) = (torques(q, payload), torques(q, 0.0));
    [all[1], all[2], all[3], all[4], own[1], own[2]]
}

impl Stated {
    /// The cell, with sights of about this standard deviation \[rad\].
    #[must_use]
    pub fn new(noise: Noise) -> Self {
        let mut problem = Problem::new();
        let bases = believed_bases();
        let arms: [ArmId; ARMS] = core::array::from_fn(|i| {
            let arm = problem.arm(NAMES[i], Irp6Arm::new(Irp6::nominal()), bases[i], Freedom::FRAME);
            problem.scatter(arm, &[SCATTER; 6]);
            problem.compliant(arm, &compliances());
            arm
        });
        let balls: [[TargetId; 3]; ARMS] = core::array::from_fn(|arm| {
            core::array::from_fn(|ball| {
                let place = Pose::translation(BALLS[ball][0], BALLS[ball][1], BALLS[ball][2]);
                let name = format!("{} ball {}", NAMES[arm], ball + 1);
                problem.target(&name, Some(arms[arm]), place, Freedom::POINT)
            })
        });
        let ends = bar_ends().map(|ends| {
            ends.map(|end| {
                problem.target("bar", None, Pose::translation(end.x, end.y, end.z), Freedom::POINT)
            })
        });
        for ends in ends {
            // It is one bar: the mean of all places is no better known than its length.
            problem.bar(ends, BAR.0, BAR.1 * (BARS as f64).sqrt());
        }
        let level = |freedom: Freedom| freedom.within(3..5, LEVEL);
        let south = Freedom { free: [true, true, true, false, false, true], ..Freedom::FIXED };
        let freedoms = [level(Freedom::FIXED), level(south)];
        let theodolites: [_; 2] = core::array::from_fn(|i| {
            let (name, place) = (["north", "south"][i], believed_theodolites()[i]);
            problem.instrument(name, Angles::both_faces(), None, place, freedoms[i], noise.clone())
        });
        let telescopes = theodolites.map(|theodolite| problem.target_at(theodolite));
        Self { problem, arms, balls, ends, theodolites, telescopes }
    }

    /// Adds what was measured.
    pub fn measured(&mut self, measured: &Sights) {
        let problem = &mut self.problem;
        let postures: [Vec<PostureId>; ARMS] = core::array::from_fn(|arm| {
            let both = measured.postures[arm].iter().zip(&measured.payloads[arm]);
            let stated = both.map(|(q, payload)| {
                problem.loaded_posture(self.arms[arm], q.as_slice(), &bending(q, *payload))
            });
            stated.collect()
        });
        for sight in &measured.sights {
            let instrument = self.theodolites[sight.theodolite];
            let (target, posture) = match sight.of {
                Sighted::Ball { arm, ball, posture } => (self.balls[arm][ball], Some(postures[arm][posture])),
                Sighted::End { bar, end } => (self.ends[bar][end], None),
                Sighted::Other => (self.telescopes[1 - sight.theodolite], None),
            };
            problem.measure(instrument, target, posture.as_slice(), &sight.read);
        }
    }
}

/// Finds the arms' dimensions, bases and balls, and the second theodolite's place.
///
/// # Errors
/// [`NoFit`].
pub fn estimate(measured: &Sights) -> Result<Estimate, NoFit> {
    let mut stated = Stated::new(Noise::Unknown(vec![1e-5; 2]));
    stated.measured(measured);
    let Stated { problem, arms, balls, .. } = stated;
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
    /// Errors of all balls of an arm at postures that were not used, in the world, where its joints come to rest anew.
    #[must_use]
    pub fn accuracy(&self, scene: &mut Scene, arm: usize, postures: &[Six]) -> Accuracy {
        let (mut squares, mut max, mut foretold, mut count) = (0.0, 0.0_f64, 0.0, 0);
        let mut pairs = Vec::new();
        for q in postures {
            let joints = scene.come_to_rest(arm, q);
            let torques = bending(q, scene.payload[arm]);
            for ball in 0..BALLS.len() {
                let frame = self.problem.frame_of(self.balls[arm][ball]);
                let (there, spread) = self.fit.place_loaded(self.arms[arm], q.as_slice(), &torques, frame);
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

    /// From where the estimate has the right base in the left one to where that is.
    #[must_use]
    pub fn offset(&self, scene: &Scene) -> Vector6<f64> {
        let [left, right] = self.arms.map(|arm| self.problem.base_of(arm));
        let truth = base_of(scene, 0).inv_mul(&base_of(scene, 1));
        mrroc_calibration::between(&self.fit.between(left, right).0, &truth)
    }

    /// How far the base of the right arm is from where the estimate has it in the left one.
    #[must_use]
    pub fn bases(&self, scene: &Scene) -> Bases {
        let [left, right] = self.arms.map(|arm| self.problem.base_of(arm));
        let (_, spread) = self.fit.between(left, right);
        // Along the axes of the left base, as the covariance is.
        let off = self.offset(scene);
        let square = spread.cholesky().map_or(f64::INFINITY, |root| off.dot(&root.solve(&off)));
        Bases {
            length: off.fixed_rows::<3>(0).norm(),
            angle: off.fixed_rows::<3>(3).norm(),
            length_sigma: spread.fixed_view::<3, 3>(0, 0).trace().sqrt(),
            angle_sigma: spread.fixed_view::<3, 3>(3, 3).trace().sqrt(),
            within: square < TWO_SIGMA,
        }
    }
}

/// The square of a distance within which 95.45 % of six normally distributed numbers are, as of one number within two standard deviations:
/// `scipy.stats.chi2.ppf(0.9545, 6)`.
const TWO_SIGMA: f64 = 12.849;

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
    /// Whether the six numbers together are within the ellipsoid in which 95.45 % are to be.
    pub within: bool,
}

/// Root mean square of the distances of pairs of points, after the rigid motion that makes it least.
fn own(pairs: &[(Vector3<f64>, Vector3<f64>)]) -> f64 {
    let squares: f64 = fitted(pairs).iter().map(|off| off.norm_squared()).sum();
    (squares / pairs.len() as f64).sqrt()
}

/// By pair how far the second point is from the first, after the rigid motion of the first ones that makes these distances least (Kabsch 1976).
#[must_use]
pub fn fitted(pairs: &[(Vector3<f64>, Vector3<f64>)]) -> Vec<Vector3<f64>> {
    let n = pairs.len() as f64;
    let (a, b) = pairs
        .iter()
        .fold((Vector3::zeros(), Vector3::zeros()), |sum, pair| (sum.0 + pair.0 / n, sum.1 + pair.1 / n));
    let moment: Matrix3<f64> = pairs.iter().map(|pair| (pair.1 - b) * (pair.0 - a).transpose()).sum();
    let rotation = Rotation3::from_matrix_eps(&moment, 1e-12, 100, Rotation3::identity());
    pairs.iter().map(|pair| (pair.1 - b) - rotation * (pair.0 - a)).collect()
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
