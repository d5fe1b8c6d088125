//! A serial chain as a robot.

use std::path::Path;

use mrroc::prelude::*;
use mrroc::robot::{JointKind, Limits, LinkMesh, NoInverse, Tool};
use nalgebra::{SVector, Vector3};

use super::chain::{Chain, Mover, Segment};
use super::closed::{Closed, joints};
use super::description::text_of;
use super::document::{Tree, parsed, shown};
use super::drives::Drives;
use super::error::UrdfError;
use super::export::exported;
use super::motion::Linkage;
use super::newton;
use super::rounded::{Rounded, check_near};
use crate::models::calibration::ChainCalibration;
use crate::models::kinematics::{Jacobian, Kinematics};
use crate::models::local::{Local, NoCalibration};

/// A serial chain of `N` moving joints, 1 to 8, read from a URDF.
///
/// ```
/// use mrroc_robots::Serial;
/// # let text = r#"<robot name="r"><link name="base"/><link name="tool"/>
/// #   <joint name="turn" type="revolute"><parent link="base"/><child link="tool"/><axis xyz="0 0 1"/>
/// #   <limit lower="-1" upper="1" velocity="2"/></joint></robot>"#;
/// let robot = Serial::<1>::from_urdf(text, "base", "tool")?.with_acceleration([5.0].into())?;
/// # Ok::<(), mrroc_robots::UrdfError>(())
/// ```
///
/// **Frames.** B is the base link, F (the flange) the tip link, W the world; [`Serial::with_base`] places B in it.
/// Coordinates are numbered from base to tip, mimic joints not counted.
///
/// **Read:** the joints between base and tip: `type` revolute, continuous, prismatic or fixed; `<origin>`
/// (`xyz`, and `rpy` or from version 1.1 `quat_xyzw`; the identity where it is not written), `<axis>` (x where it is
/// not written), `<limit>`, `<mimic>`; for simulated drives `<dynamics>` and the links' `<inertial>`; for panels the
/// meshes of `<visual>` ([`Serial::with_meshes`]). Collisions,
/// transmissions, soft limits of safety controllers, and joints off the chain are not read. Numbers and
/// spelling are checked strictly: what would give another joint than the one written is refused, with a [`UrdfError`]
/// that names it.
///
/// **Mimic joints** follow a joint of the chain: their motion is part of the kinematics of the joint that they
/// follow, whose limits are narrowed so that theirs are kept too.
///
/// **Limits** come from `<limit lower upper velocity>`. None of them has a default. A continuous joint has no
/// position limits; the runtime's must be finite, so it is given a thousand turns in either direction (2000 pi rad) and is
/// never wrapped: inverse kinematics stays on the turn of the seed. [`Serial::with_positions`] narrows the limits. URDF
/// before 1.2 knows no acceleration limits: [`SerialBuilder::with_acceleration`] demands them.
///
/// **Inverse kinematics.** Three families of arms whose joints all turn are recognised from their axes (to 1e-12) and solved
/// in closed form; [`Robot::inverse`] then gives the solution nearest to the seed, whatever the limits:
///
/// | joints | axes | solutions |
/// |---|---|---|
/// | 6 | ortho-parallel with a spherical wrist: most industrial arms | 8 |
/// | 6 | axes 2, 3, 4 parallel, axes 5 and 6 meeting: UR3 to UR30 and their like | 8 |
/// | 7 | spherical shoulder and spherical wrist, axis 4 with the same nearest point to both: KUKA LBR iiwa | 16 at an arm angle |
///
/// With seven joints a path keeps the **arm angle** ([`Serial::arm_angle`]) of the seed, so a closed path of the flange is a
/// closed path of the joints; the nearest solution may turn axis 4 the other way round, which is half a turn of that
/// angle. `Demand::with_redundancy` demands an arm angle. With the wrist on axis 1 the angle is not determined, and axis 4
/// stays as it was as nearly as it can; beside it the elbow may have to swing, and `near_singularity` names the shoulder.
///
/// All other chains, among them seven axes without a spherical wrist (Franka's arms: their wrist is offset by 88 mm), are
/// solved by iteration from the seed, within the limits. Of poses
/// drawn from the whole range, all are found from seeds within 0.01 of every joint [rad or m], and at least 9,999 of
/// 10,000 from seeds within 0.1 (`tests/urdf_inverse.rs`). A pose that is not found is refused as
/// [`NoInverse::NotConverged`], after at most 24 starts of at most 40 steps (some 0.1 ms); one that is farther from the
/// first joint than all links are long is refused at once, as `OutOfReach`.
///
/// Right angles written with few digits (`1.5708`) are not exact right angles. An arm whose axes are within 1e-4 rad and
/// 1e-4 m of one of the three families is solved by the closed form of the nearest exact geometry, corrected in a few steps to
/// 1e-10 of its own: all solutions, on their branches, and the same arm angle along a path. Where that fails (on a singularity,
/// or at the edge of the range) [`Robot::inverse`] iterates.
///
/// **Simulation.** [`Simulated`](crate::Simulated) runs it with one assumed motor a joint, large enough for its limits. The
/// gear keeps the motor within 250 rad/s and 500 rad/s²; the inertia is that of the posture that has most; `effort`
/// (above 0) bounds the lasting torque; `<dynamics>` adds to the friction; the links' weight loads the motor in any
/// posture, gravity along -z of the world. Links without `<inertial>` have no mass.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Serial<const N: usize> {
    pub(super) movers: Vec<Mover>,
    pub(super) segments: Vec<Segment>,
    linkage: Linkage,
    pub(super) drives: Drives<N>,
    /// Pose of the first joint that moves in the base.
    pub(super) X_BJ: Pose,
    /// Pose of the flange in the last joint that moves.
    pub(super) X_tip: Pose,
    limits: Limits<SVector<f64, N>>,
    /// Largest possible distance of the tip from the first joint \[m\].
    reach: f64,
    /// The closed form, where there is one, or that of an exact geometry so near that the difference is corrected.
    closed: Option<Closed>,
    rounded: Option<Rounded>,
    /// The arm that this one differs from by its calibration.
    nominal: Option<Box<Serial<N>>>,
    /// What its joints are off by, beside its dimensions.
    local: Option<Box<Local<N>>>,
    /// The files of its links' visible shapes.
    pub(super) meshes: Vec<LinkMesh>,
}

/// A chain that still lacks its limits of acceleration, which a URDF does not give.
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a robot is made by with_acceleration"]
pub struct SerialBuilder<const N: usize> {
    chain: Chain,
}

impl<const N: usize> SerialBuilder<N> {
    /// The robot whose joints are accelerated by at most this [rad/s² or m/s²], each finite and > 0.
    ///
    /// # Errors
    /// [`UrdfError::BadCallerLimit`], or [`UrdfError::AboveFile`] where a file of URDF 1.2 allows less.
    #[allow(non_snake_case)]
    pub fn with_acceleration(self, acceleration: SVector<f64, N>) -> Result<Serial<N>, UrdfError> {
        check(&self.chain.movers, "acceleration", &acceleration, |mover| mover.acceleration)?;
        let drives = Drives::of(&self.chain, &acceleration);
        let Chain { movers, segments, X_tip, .. } = self.chain;
        let limits = Limits {
            lower: SVector::from_fn(|i, _| movers[i].range.0),
            upper: SVector::from_fn(|i, _| movers[i].range.1),
            velocity: SVector::from_fn(|i, _| movers[i].velocity),
            acceleration,
            jerk: None,
        };
        let X_BJ = segments.first().map_or_else(Pose::identity, |first| first.X_before);
        let closed = Closed::of(&segments, &X_tip);
        let reach = reach(&movers, &segments, &X_tip);
        let linkage = Linkage::new(&segments, &X_tip);
        let rounded = rounded::<N>(&closed, &segments, &X_tip, &linkage);
        Ok(Serial {
            movers,
            segments,
            linkage,
            drives,
            X_BJ,
            X_tip,
            limits,
            reach,
            closed,
            rounded,
            nominal: None,
            local: None,
            meshes: Vec::new(),
        })
    }

    /// The accelerations that a file of URDF 1.2 states for all joints [rad/s² or m/s²]; `None` where it leaves one out.
    #[must_use]
    pub fn stated_acceleration(&self) -> Option<SVector<f64, N>> {
        let mut stated = SVector::<f64, N>::zeros();
        for (mover, value) in self.chain.movers.iter().zip(stated.iter_mut()) {
            *value = mover.acceleration?;
        }
        Some(stated)
    }

    /// Names of the moving joints, from base to tip.
    pub fn joint_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.chain.movers.iter().map(|mover| mover.name.as_str())
    }
}

/// Round-off by which a pose may exceed the reach, as a part of it.
const ROUND_OFF: f64 = 1e-12;

/// How far beyond the range of the nearest exact geometry a pose may be for the arm itself to be asked, as a part of it.
const EDGE: f64 = 1e-3;

/// How far the flange of a calibration's design may be from that of the arm \[m\]: files round their numbers.
const SAME_DESIGN: f64 = 1e-4;

/// How far from the seed a solution of a calibrated arm may be without being looked for elsewhere [rad or m].
const BESIDE: f64 = 0.5;

/// Sum of the lengths of all links after the first joint, slides drawn out \[m\], and not 0.
#[allow(non_snake_case)]
fn reach(movers: &[Mover], segments: &[Segment], X_tip: &Pose) -> f64 {
    let links = segments.iter().skip(1).map(|segment| segment.X_before.translation.vector.norm());
    let slides = segments.iter().filter(|segment| segment.kind == JointKind::Prismatic).map(|segment| {
        let at = |q: f64| (segment.multiplier * q + segment.offset).abs();
        movers.get(segment.leader).map_or(0.0, |mover| at(mover.range.0).max(at(mover.range.1)))
    });
    let reach = links.chain(slides).sum::<f64>() + X_tip.translation.vector.norm();
    if reach > 1e-3 { reach } else { 1.0 }
}

/// The correction of a closed form for a chain that has none of its own.
#[allow(non_snake_case)]
fn rounded<const N: usize>(
    closed: &Option<Closed>,
    segments: &[Segment],
    X_tip: &Pose,
    linkage: &Linkage,
) -> Option<Rounded> {
    if closed.is_some() { None } else { Rounded::of::<N>(segments, X_tip, linkage) }
}

/// Checks limits that the caller gives.
fn check<const N: usize>(
    movers: &[Mover],
    what: &'static str,
    given: &SVector<f64, N>,
    stated: impl Fn(&Mover) -> Option<f64>,
) -> Result<(), UrdfError> {
    for (mover, value) in movers.iter().zip(given.iter().copied()) {
        let joint = || shown(&mover.name);
        if !value.is_finite() || value <= 0.0 {
            return Err(UrdfError::BadCallerLimit { joint: joint(), what, value });
        }
        if let Some(limit) = stated(mover).filter(|limit| value > *limit) {
            return Err(UrdfError::AboveFile { joint: joint(), what, value, limit });
        }
    }
    Ok(())
}

impl<const N: usize> Serial<N> {
    /// The chain from link `base` to link `tip` of a URDF's text, without its limits of acceleration.
    ///
    /// # Errors
    /// [`UrdfError`] for everything that would make another robot than the one written.
    pub fn from_urdf(text: &str, base: &str, tip: &str) -> Result<SerialBuilder<N>, UrdfError> {
        let document = parsed(text)?;
        let chain = Chain::between(&Tree::of(&document)?, base, tip, Some(N))?;
        Ok(SerialBuilder { chain })
    }

    /// The chain from link `base` to link `tip` of a URDF file, without its limits of acceleration.
    ///
    /// # Errors
    /// [`UrdfError`], also when the file cannot be read.
    pub fn from_urdf_file(
        path: impl AsRef<Path>,
        base: &str,
        tip: &str,
    ) -> Result<SerialBuilder<N>, UrdfError> {
        Self::from_urdf(&text_of(path.as_ref())?, base, tip)
    }

    /// The same robot with its base link at `X_WB` in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn with_base(mut self, X_WB: Pose) -> Self {
        if let Some(first) = self.segments.first_mut() {
            first.X_before = X_WB * self.X_BJ;
        }
        self.linkage = Linkage::new(&self.segments, &self.X_tip);
        self.closed = Closed::of(&self.segments, &self.X_tip);
        self.nominal = self.nominal.map(|nominal| Box::new(nominal.with_base(X_WB)));
        self.rounded = self
            .calibrated()
            .or_else(|| rounded::<N>(&self.closed, &self.segments, &self.X_tip, &self.linkage));
        self
    }

    /// The same robot, as one that differs from a nominal one by its calibration, some millimetres and hundredths of a radian, where its
    /// own axes have no closed form. Its forward kinematics stays its own. Its inverse kinematics begins with the closed form of
    /// the nominal one and corrects that, in four to six steps nearly everywhere, to 1e-10 of its own poses; on the branches of
    /// the nominal one, which also names its singularities. Where that leads farther than 0.5 from the seed in any joint, or
    /// nowhere (beside a singularity, at the edge of the range), it iterates from the seed and takes what is nearer.
    ///
    /// # Errors
    /// [`UrdfError::NotNear`] where it is another robot, [`UrdfError::NoClosedForm`].
    pub fn calibrated_from(mut self, nominal: Serial<N>) -> Result<Self, UrdfError> {
        check_near::<N>(&self.linkage, &nominal.linkage)?;
        if nominal.closed.is_none() {
            return Err(UrdfError::NoClosedForm);
        }
        self.nominal = Some(Box::new(nominal));
        self.rounded = self.calibrated();
        Ok(self)
    }

    /// The same robot with the dimensions of a calibration, its base where it was, and its [local correction](crate::LocalCorrection) if it has one. Its
    /// inverse kinematics begins with the closed form of this one, where that has one ([`Serial::calibrated_from`]); else it iterates.
    ///
    /// # Errors
    /// [`NoCalibration`]: it is the calibration of another robot, or one that this robot cannot take.
    #[allow(non_snake_case)]
    pub fn calibrated_by(self, calibration: &ChainCalibration) -> Result<Self, NoCalibration> {
        let no = |what: String| Err(NoCalibration(what));
        let joints = calibration.design.len();
        if joints != N || self.segments.len() != N {
            return no(format!("it is the calibration of an arm with {joints} joints, this one has {N}"));
        }
        if calibration.encoders.iter().flatten().any(|number| *number != 0.0) {
            return no(
                "it has errors of encoders, which are not corrected here: calibrate with --detail geometry"
                    .to_owned(),
            );
        }
        let with = |frames: &[Pose], tip: Pose| {
            let mut arm = self.clone();
            let X_WB = self.X_WB();
            for (segment, frame) in arm.segments.iter_mut().zip(frames) {
                // What a coordinate is 0 at stays as this robot says it.
                segment.X_before = *frame;
            }
            arm.X_BJ = frames.first().copied().unwrap_or_else(Pose::identity);
            arm.X_tip = tip;
            arm.closed = None;
            arm.rounded = None;
            arm.nominal = None;
            arm.local = None;
            arm.reach = reach(&arm.movers, &arm.segments, &arm.X_tip);
            arm.with_base(X_WB)
        };
        let design = with(&calibration.design, calibration.tip);
        let apart = design.linkage.apart::<N>(&self.linkage);
        if apart > SAME_DESIGN {
            return no(format!(
                "it is the calibration of another arm: by its design the flange is up to {:.1} mm from where this arm has it",
                1e3 * apart
            ));
        }
        let (frames, tip) = calibration.calibrated();
        let mut arm = with(&frames, tip);
        if self.form().is_some() {
            arm.nominal = Some(Box::new(self));
            arm.rounded = arm.calibrated();
        }
        if let Some(local) = &calibration.local {
            arm.local = Some(Box::new(Local::of(local, |i| arm.movers[i].kind)?));
        }
        Ok(arm)
    }

    fn calibrated(&self) -> Option<Rounded> {
        let nominal = self.nominal.as_ref()?.form()?;
        if self.closed.is_some() { None } else { Some(Rounded::calibrated(nominal)) }
    }

    /// The same robot with limits of jerk [rad/s³ or m/s³], each finite and > 0.
    ///
    /// # Errors
    /// [`UrdfError::BadCallerLimit`], or [`UrdfError::AboveFile`] where a file of URDF 1.2 allows less.
    pub fn with_jerk(mut self, jerk: SVector<f64, N>) -> Result<Self, UrdfError> {
        check(&self.movers, "jerk", &jerk, |mover| mover.jerk)?;
        self.limits.jerk = Some(jerk);
        Ok(self)
    }

    /// The same robot with narrower position limits [rad or m]: within those of the file, of endless joints within a
    /// thousand turns.
    ///
    /// # Errors
    /// [`UrdfError::CallerRange`].
    pub fn with_positions(
        mut self,
        lower: SVector<f64, N>,
        upper: SVector<f64, N>,
    ) -> Result<Self, UrdfError> {
        for (i, mover) in self.movers.iter().enumerate().take(N) {
            let lower = lower[i];
            let upper = upper[i];
            let (lowest, highest) = mover.range;
            let within = lowest <= lower && lower < upper && upper <= highest;
            if !within {
                let joint = shown(&mover.name);
                return Err(UrdfError::CallerRange { joint, lower, upper, lowest, highest });
            }
        }
        self.limits.lower = lower;
        self.limits.upper = upper;
        Ok(self)
    }

    /// Names of the moving joints, from base to tip.
    pub fn joint_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.movers.iter().map(|mover| mover.name.as_str())
    }

    /// The joints that move, mimic joints too.
    pub(super) fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Pose of the base in the world.
    #[allow(non_snake_case)]
    pub(super) fn X_WB(&self) -> Pose {
        self.segments.first().map_or_else(Pose::identity, |first| first.X_before * self.X_BJ.inverse())
    }

    /// Whether its joints stand elsewhere than its encoders read, by what a [`LocalCorrection`](crate::LocalCorrection) says.
    pub(super) fn has_local_correction(&self) -> bool {
        self.local.is_some()
    }

    /// Inverse kinematics by iteration.
    #[allow(non_snake_case)]
    fn iterate(&self, X_WF: &Pose, near: &SVector<f64, N>) -> Result<SVector<f64, N>, NoInverse> {
        let first =
            self.segments.first().map_or_else(Vector3::zeros, |first| first.X_before.translation.vector);
        let distance = (X_WF.translation.vector - first).norm();
        if distance > self.reach * (1.0 + ROUND_OFF) {
            return Err(NoInverse::OutOfReach { distance, min: 0.0, max: self.reach });
        }
        newton::solve(&self.linkage, &self.limits, self.reach, X_WF, near)
            .map_err(|error| NoInverse::NotConverged { error, tolerance: newton::GOOD })
    }

    /// The solution to which the iteration from the seed comes, if that is nearer to it than `other`. The nominal arm lacks
    /// a branch at the edge of the range, or has it elsewhere beside a singularity, where a calibrated one goes on.
    #[allow(non_snake_case)]
    fn nearer(
        &self,
        X_WF: &Pose,
        near: &SVector<f64, N>,
        other: Option<&SVector<f64, N>>,
    ) -> Option<SVector<f64, N>> {
        let found = self.iterate(X_WF, near).ok()?;
        let is_nearer = other.is_none_or(|other| (found - near).amax() < (other - near).amax());
        is_nearer.then_some(found)
    }

    /// Where the joints stand at a pose.
    #[allow(non_snake_case)]
    fn standing(&self, X_WF: &Pose, near: &SVector<f64, N>) -> Result<SVector<f64, N>, NoInverse> {
        match (&self.closed, &self.rounded) {
            (Some(arm), _) => arm.inverse(X_WF, near),
            (None, Some(arm)) if self.nominal.is_some() => {
                let found = arm.inverse(&self.linkage, X_WF, near);
                match found {
                    Ok(q) if (q - near).amax() < BESIDE => Ok(q),
                    _ => self.nearer(X_WF, near, found.ok().as_ref()).map_or(found, Ok),
                }
            }
            // On a singularity, or at the edge of the range, the exact geometry may have no solution where the arm has one.
            (None, Some(arm)) => arm.inverse(&self.linkage, X_WF, near).or_else(|error| match error {
                NoInverse::OutOfReach { distance, min, max }
                    if !((min - EDGE * max)..=(max * (1.0 + EDGE))).contains(&distance) =>
                {
                    Err(error)
                }
                _ => self.iterate(X_WF, near).map_err(|_| error),
            }),
            (None, None) => self.iterate(X_WF, near),
        }
    }

    /// Where the joints stand when encoders read `q`: there, but for what a local correction says.
    fn stand(&self, q: &SVector<f64, N>) -> SVector<f64, N> {
        self.local.as_ref().map_or(*q, |local| local.stand(q))
    }

    /// What encoders read when the joints stand at `p`.
    fn read(&self, p: &SVector<f64, N>) -> SVector<f64, N> {
        self.local.as_ref().map_or(*p, |local| local.read(p))
    }

    /// Whether the arm was recognised as one with a closed form. If so, its inverse kinematics finds all solutions; if not,
    /// it iterates from the seed and finds one.
    #[must_use]
    pub fn is_closed_form(&self) -> bool {
        self.form().is_some()
    }

    /// The closed form of the chain, or of the exact geometry nearest to it.
    fn form(&self) -> Option<&Closed> {
        self.closed.as_ref().or_else(|| self.rounded.as_ref().map(Rounded::nearest))
    }

    /// The arm angle \[rad\] at `q` \[rad\], -pi to pi, of a seven-axis arm with a spherical shoulder and a spherical wrist:
    /// by how much axis 4 is turned about the line from shoulder to wrist, by the right hand, from where the elbow lies
    /// in the plane through axis 1 and the wrist. `None` for other chains, and in closed form only.
    #[must_use]
    pub fn arm_angle(&self, q: &SVector<f64, N>) -> Option<f64> {
        self.form().and_then(|arm| arm.redundancy(&self.stand(q)))
    }
}

impl<const N: usize> Robot for Serial<N> {
    const KIND: &'static str = "urdf";

    type Joints = SVector<f64, N>;

    fn joint(&self, i: usize) -> JointKind {
        self.movers.get(i).map_or(JointKind::Revolute, |mover| mover.kind)
    }

    fn limits(&self) -> &Limits<Self::Joints> {
        &self.limits
    }

    fn forward(&self, q: &Self::Joints) -> Pose {
        let q = &self.stand(q);
        match &self.closed {
            Some(Closed::OrthoParallel(arm)) => arm.forward(&joints(q)),
            _ => self.linkage.forward(q),
        }
    }

    /// Visits the frames `X_WL` that the links carry, from base to flange: the base B, the frame of every joint that
    /// moves (mimic joints too), turned or drawn out, its z along the axis, and the flange.
    #[allow(non_snake_case)]
    fn frames(&self, q: &Self::Joints, visit: &mut dyn FnMut(&Pose)) {
        let q = &self.stand(q);
        let mut X_WL = self.segments.first().map_or_else(Pose::identity, |first| first.X_before);
        visit(&(X_WL * self.X_BJ.inverse()));
        for (i, segment) in self.segments.iter().enumerate() {
            if i > 0 {
                X_WL *= segment.X_before;
            }
            let value = segment.multiplier * q[segment.leader] + segment.offset;
            X_WL *= match segment.kind {
                JointKind::Revolute => Pose::rotation(Vector3::z() * value),
                JointKind::Prismatic => Pose::translation(0.0, 0.0, value),
            };
            visit(&X_WL);
        }
        visit(&(X_WL * self.X_tip));
    }

    fn meshes(&self) -> &[LinkMesh] {
        &self.meshes
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Self::Joints) -> Result<Self::Joints, NoInverse> {
        self.standing(X_WF, &self.stand(near)).map(|p| self.read(&p))
    }

    /// Of an arm with seven joints in closed form the solution at this arm angle \[rad\] ([`Serial::arm_angle`]).
    #[allow(non_snake_case)]
    fn inverse_at(
        &self,
        X_WF: &Pose,
        redundancy: f64,
        near: &Self::Joints,
    ) -> Result<Self::Joints, NoInverse> {
        let near = &self.stand(near);
        let found = match (&self.closed, &self.rounded) {
            (Some(arm), _) => arm.inverse_at(X_WF, redundancy, near),
            (None, Some(arm)) => arm.inverse_at(&self.linkage, X_WF, redundancy, near),
            (None, None) => Err(NoInverse::NotRedundant),
        };
        found.map(|p| self.read(&p))
    }

    fn near_singularity(&self, q: &Self::Joints) -> Option<&'static str> {
        self.form().and_then(|arm| arm.near_singularity(q))
    }

    fn urdf(&self, name: &str, tool: &Tool) -> Option<String> {
        exported(self, name, tool)
    }
}

impl<const N: usize> Kinematics<N> for Serial<N> {
    /// Largest possible distance of the flange from the first joint \[m\], > 0: the sum of the links. Inverse kinematics by
    /// iteration divides errors of position by it to compare them with those of orientation \[rad\].
    fn reach(&self) -> f64 {
        self.reach
    }

    fn jacobian(&self, q: &SVector<f64, N>) -> Jacobian<N> {
        match &self.local {
            None => self.linkage.jacobian(q).1,
            Some(local) => {
                let (p, slope) = local.stand_with_slope(q);
                self.linkage.jacobian(&p).1 * slope
            }
        }
    }

    /// Of an arm in closed form all solutions, at most eight; a joint that is undetermined stays as in `near`. Of all other
    /// chains the one solution that [`Robot::inverse`] finds from `near`.
    #[allow(non_snake_case)]
    fn solutions(
        &self,
        X_WF: &Pose,
        near: &SVector<f64, N>,
        visit: &mut dyn FnMut(&SVector<f64, N>),
    ) -> Result<(), NoInverse> {
        let near = &self.stand(near);
        let visit = &mut |p: &SVector<f64, N>| visit(&self.read(p));
        match (&self.closed, &self.rounded) {
            (Some(arm), _) => arm.solutions(X_WF, near, visit),
            (None, Some(arm)) if self.nominal.is_some() => {
                let mut nearest: Option<SVector<f64, N>> = None;
                let found = arm.solutions(&self.linkage, X_WF, near, &mut |q| {
                    if nearest.is_none_or(|nearest| (q - near).amax() < (nearest - near).amax()) {
                        nearest = Some(*q);
                    }
                    visit(q);
                });
                if nearest.is_some_and(|nearest| (nearest - near).amax() < BESIDE) {
                    return found;
                }
                match self.nearer(X_WF, near, nearest.as_ref()) {
                    Some(q) => {
                        visit(&q);
                        Ok(())
                    }
                    None => found,
                }
            }
            (None, Some(arm)) => arm.solutions(&self.linkage, X_WF, near, visit),
            (None, None) => self.iterate(X_WF, near).map(|q| visit(&q)),
        }
    }
}
