//! The calibration of one arm: its own Denavit-Hartenberg parameters, measured when it was made.
//!
//! In: what its controller tells ([`primary`](crate::primary)), or a file. Out: the arm, [`UrModel::calibrated`], and the text of
//! that file.
//!
//! **Frames.** The parameters are those of `R_z(q + theta) T_z(d) T_x(a) R_x(alpha)`. Axes 2, 3 and 4 are parallel but for some
//! milliradians, so their common normals lie anywhere: calibrations with d of -92 m, and theta of 0.7 rad, are usual. Here each joint
//! gets the frame on its calibrated axis that is nearest to the nominal one; its turn about the axis is the same. So links are
//! as long as they look.

use core::f64::consts::FRAC_PI_2;
use core::fmt::Write;

use mrroc::pose::Pose;
use mrroc_robots::{Serial, UrdfError};
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};
use toml::de::{DeTable, DeValue};

use crate::models::{JOINTS, UrModel};

/// What no parameter exceeds [m or rad].
const MOST: f64 = 1e4;

/// How far two calibrations of one arm may differ in any parameter [m or rad]: not at all but for the last digit.
const SAME: f64 = 1e-12;

/// The Denavit-Hartenberg parameters of one arm, all finite and within 1e4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Turns about the axes, added to the joint positions \[rad\].
    pub theta: [f64; JOINTS],
    /// Lengths along x \[m\].
    pub a: [f64; JOINTS],
    /// Lengths along the axes \[m\].
    pub d: [f64; JOINTS],
    /// Turns about x \[rad\].
    pub alpha: [f64; JOINTS],
    /// The checksums of its joints, by which the controller knows that it belongs to the arm.
    pub checksum: [u32; JOINTS],
}

/// A file that has no calibration: why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NoCalibration(String);

impl Calibration {
    /// The dimensions that UR publishes for a model.
    #[must_use]
    pub fn nominal(model: UrModel) -> Calibration {
        let [d1, a2, a3, d4, d5, d6] = model.dimensions();
        Calibration {
            theta: [0.0; JOINTS],
            a: [0.0, a2, a3, 0.0, 0.0, 0.0],
            d: [d1, 0.0, 0.0, d4, d5, d6],
            alpha: [FRAC_PI_2, 0.0, 0.0, FRAC_PI_2, -FRAC_PI_2, 0.0],
            checksum: [0; JOINTS],
        }
    }

    /// Itself, if all numbers are those of an arm.
    pub(crate) fn is_sane(self) -> Option<Calibration> {
        let Calibration { theta, a, d, alpha, .. } = &self;
        let sane = [theta, a, d, alpha].into_iter().flatten().all(|number| number.abs() < MOST);
        sane.then_some(self)
    }

    /// Whether this is the calibration of the same arm.
    #[must_use]
    pub fn is_of_the_same_arm(&self, other: &Calibration) -> bool {
        let all = |of: &Calibration| [of.theta, of.a, of.d, of.alpha];
        let (own, others) = (all(self), all(other));
        let mut pairs = own.iter().flatten().zip(others.iter().flatten());
        pairs.all(|(own, other)| (own - other).abs() <= SAME) && self.checksum == other.checksum
    }

    /// The text of its file, with all digits.
    ///
    /// ```
    /// use mrroc_ur::{Calibration, UrModel};
    ///
    /// let calibration = Calibration::nominal(UrModel::Ur5e);
    /// let text = calibration.text(UrModel::Ur5e);
    /// assert!(text.contains("model = \"ur5e\""));
    /// assert_eq!(Calibration::parse(&text), Ok((UrModel::Ur5e, calibration)));
    /// ```
    #[must_use]
    pub fn text(&self, model: UrModel) -> String {
        let mut text = format!(
            "# The calibration of one arm, as its controller tells it: name this file as its `calibration` in cell.toml.\n\
             model = \"{}\"\n",
            model.kind()
        );
        let Calibration { theta, a, d, alpha, checksum } = self;
        for (name, numbers, unit) in
            [("theta", theta, "rad"), ("a", a, "m"), ("d", d, "m"), ("alpha", alpha, "rad")]
        {
            // Writing into a text does not fail. `{:?}` gives back the same number, and always with a point.
            let _ = writeln!(text, "{name} = {numbers:?} # {unit}");
        }
        let _ = writeln!(text, "checksum = {checksum:?}");
        text
    }

    /// Reads such a text: the model, and the calibration.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<(UrModel, Calibration), NoCalibration> {
        let no = |what: &str| NoCalibration(what.to_owned());
        let table = DeTable::parse(text).map_err(|_| no("it is no TOML"))?;
        let table = table.get_ref();
        let kind = table.get("model").and_then(|model| model.get_ref().as_str()).unwrap_or_default();
        // What `calibrate` makes of measurements begins alike.
        if ["chain", "irp6"].contains(&kind) {
            return Err(no(
                "it was measured from outside (`calibrate`), and is not what the controller of this robot tells",
            ));
        }
        let known = ["model", "theta", "a", "d", "alpha", "checksum"];
        if let Some(key) = table.keys().find(|key| !known.contains(&key.get_ref().as_ref())) {
            let key = mrroc::console::quoted(key.get_ref(), 40);
            return Err(NoCalibration(format!("a calibration has no `{key}`")));
        }
        let model = UrModel::ALL.into_iter().find(|model| model.kind() == kind);
        let model =
            model.ok_or_else(|| no("its `model` is none of ur3e, ur5e, ur10e, ur16e, ur20 and ur30"))?;
        let six = |name: &str| -> Result<[f64; JOINTS], NoCalibration> {
            let wrong = || NoCalibration(format!("its `{name}` is not six numbers"));
            let Some(DeValue::Array(array)) = table.get(name).map(|value| value.get_ref()) else {
                return Err(wrong());
            };
            let numbers: Option<Vec<f64>> = array.iter().map(|value| number(value.get_ref())).collect();
            numbers.and_then(|numbers| numbers.try_into().ok()).ok_or_else(wrong)
        };
        let mut checksum = [0; JOINTS];
        for (one, number) in checksum.iter_mut().zip(six("checksum")?) {
            let is_whole = number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number);
            *one = if is_whole {
                number as u32
            } else {
                return Err(no("its `checksum` is not six whole numbers"));
            };
        }
        let read =
            Calibration { theta: six("theta")?, a: six("a")?, d: six("d")?, alpha: six("alpha")?, checksum };
        read.is_sane().map(|read| (model, read)).ok_or_else(|| no("no arm has such lengths or angles"))
    }

    /// The poses of the joints' frames in the base, all joints at 0: z along each axis, the flange last.
    fn frames(&self, nominal: &[Pose; JOINTS]) -> [Pose; JOINTS + 1] {
        let mut link = Pose::identity();
        let mut frames = [Pose::identity(); JOINTS + 1];
        for i in 0..JOINTS {
            let axis = link.rotation * Vector3::z();
            let from = &nominal[i];
            let along = axis.dot(&(from.translation.vector - link.translation.vector));
            let origin = Translation3::from(link.translation.vector + axis * along);
            frames[i] =
                Pose::from_parts(origin, least_turn(&(from.rotation * Vector3::z()), &axis) * from.rotation);
            link *= Pose::rotation(Vector3::z() * self.theta[i])
                * Pose::translation(self.a[i], 0.0, self.d[i])
                * Pose::rotation(Vector3::x() * self.alpha[i]);
        }
        frames[JOINTS] = link;
        frames
    }
}

/// The rotation that takes one unit vector to another, which is nearly the same: half-way between them lies the axis of a half turn.
fn least_turn(from: &Vector3<f64>, to: &Vector3<f64>) -> UnitQuaternion<f64> {
    let across = from.cross(to);
    UnitQuaternion::new_normalize(Quaternion::new(1.0 + from.dot(to), across.x, across.y, across.z))
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Integer(integer) => {
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|whole| whole as f64)
        }
        DeValue::Float(float) => float.as_str().parse().ok().filter(|number: &f64| number.is_finite()),
        DeValue::String(_)
        | DeValue::Boolean(_)
        | DeValue::Datetime(_)
        | DeValue::Array(_)
        | DeValue::Table(_) => None,
    }
}

impl UrModel {
    /// The arm with this calibration, its base at `X_WB` in the world. Its forward kinematics is that of its parameters; its inverse
    /// kinematics begins with the closed form of the nominal arm ([`Serial::calibrated_from`]).
    ///
    /// # Errors
    /// [`UrdfError::NotNear`] where it is the calibration of another model.
    #[allow(non_snake_case)]
    pub fn calibrated(self, X_WB: Pose, calibration: &Calibration) -> Result<Serial<JOINTS>, UrdfError> {
        let frames = calibration.frames(&self.joint_frames());
        let mut before = Pose::identity();
        let steps = frames.map(|frame| {
            let step = before.inv_mul(&frame);
            before = frame;
            let (roll, pitch, yaw) = step.rotation.euler_angles();
            (step.translation.vector.into(), [roll, pitch, yaw])
        });
        let nominal = self.arm(Pose::identity())?;
        let arm = Serial::from_urdf(&self.urdf_of(&steps), "base", "tool0")?;
        Ok(arm.with_acceleration(self.accelerations())?.calibrated_from(nominal)?.with_base(X_WB))
    }
}
