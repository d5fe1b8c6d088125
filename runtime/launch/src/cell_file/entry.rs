//! A robot and a sensor as the cell file describes them.

use core::ops::Range;
use core::time::Duration;
use std::rc::Rc;

use mrroc_core::cell::CellError;
use mrroc_core::pose::Pose;
use mrroc_core::robot::JointVector;
use mrroc_core::robot::Robot;
use mrroc_core::sensor::VspMode;

use super::error::Source;

/// A value and where it stands in the text.
#[derive(Clone, Debug)]
pub(super) struct At<T> {
    pub value: T,
    pub span: Range<usize>,
}

/// A robot of a cell file, from which the set-up of its kind is made.
#[derive(Clone, Debug)]
pub struct RobotEntry {
    pub(super) source: Rc<Source>,
    pub(super) name: At<String>,
    pub(super) kind: At<String>,
    pub(super) start: Option<At<Vec<At<f64>>>>,
    pub(super) homed: Option<At<bool>>,
    pub(super) base: Option<Pose>,
    pub(super) tool: Option<Pose>,
}

impl RobotEntry {
    /// The robot's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name.value
    }

    /// The kind that the file gives it.
    #[must_use]
    pub fn kind(&self) -> &str {
        &self.kind.value
    }

    /// `base`: the pose of the robot's base in the world, `X_WB` [m, rad]; the world's origin by default.
    #[must_use]
    pub fn base(&self) -> Pose {
        self.base.unwrap_or_else(Pose::identity)
    }

    /// `tool`: the pose of the tool on the flange, `X_FE`; the flange by default. The robot gets this tool even if the
    /// set-up does not use it.
    #[must_use]
    pub fn tool(&self) -> Pose {
        self.tool.unwrap_or_else(Pose::identity)
    }

    /// `homed`: whether the drives know where the robot is when the cell starts; true by default.
    #[must_use]
    pub fn is_homed(&self) -> bool {
        self.homed.as_ref().is_none_or(|homed| homed.value)
    }

    /// The same with drives that know where the robot is.
    pub(super) fn homed(&self) -> RobotEntry {
        RobotEntry { homed: None, ..self.clone() }
    }

    /// Refuses `homed = false` for a kind whose drives know where the robot is anyway.
    pub(super) fn refuse_unhomed(&self) -> CellError {
        let span = self.homed.as_ref().map_or(&self.kind.span, |homed| &homed.span);
        let what = format!("the drives of kind `{}` know where the robot is", self.kind());
        self.source.complain(span, what, "leave `homed` out, or write homed = true".to_owned()).into()
    }

    /// `start`: the joint positions at which a simulated robot of this kind starts [rad or m].
    ///
    /// # Errors
    /// The file has no `start`, it has another number of joints, or a joint is outside the robot's position limits. A
    /// kind refuses other impossible positions itself, by [`RobotEntry::refuse_start`].
    pub fn start<R: Robot>(&self, robot: &R) -> Result<R::Joints, CellError> {
        let joints = R::Joints::LEN;
        let Some(start) = &self.start else {
            let what = format!("robot `{}` has no `start`", self.name());
            let mut units: Vec<_> = (0..joints).map(|i| robot.joint(i).unit(0)).collect();
            units.dedup();
            let help = format!("write start = [..], {joints} joint positions [{}]", units.join(", "));
            return Err(self.source.complain(&self.name.span, what, help).into());
        };
        if start.value.len() != joints {
            let what = format!("`start` has {} numbers, {} has {joints} joints", start.value.len(), R::KIND);
            let help = format!("write one joint position for each: {joints} numbers");
            return Err(self.source.complain(&start.span, what, help).into());
        }
        let limits = robot.limits();
        for (i, At { value, span }) in start.value.iter().enumerate() {
            let (lower, upper) = (limits.lower[i], limits.upper[i]);
            // Limits whose range is empty are reported by the cell, which checks them.
            if lower < upper && !(lower..=upper).contains(value) {
                let unit = robot.joint(i).unit(0);
                let what = format!("`start` of joint {} is {value} {unit}, outside its limits", i + 1);
                let help = format!("write a number from {lower:.4} to {upper:.4} {unit}");
                return Err(self.source.complain(span, what, help).into());
            }
        }
        Ok(R::Joints::from_joints(|i| start.value[i].value))
    }

    /// Refuses the `start` for a reason that limits of single joints cannot express, such as motors that several joints
    /// share: `what` is wrong with it, and `help` says what to write.
    #[must_use]
    pub fn refuse_start(&self, what: String, help: String) -> CellError {
        let span = self.start.as_ref().map_or(&self.name.span, |start| &start.span);
        self.source.complain(span, what, help).into()
    }

    pub(super) fn unknown_kind(&self, known: &[&str]) -> CellError {
        let what = format!("no kind of robot `{}`", self.kind());
        let help = mrroc_core::suggestion::suggestion(self.kind(), known, "the program knows");
        self.source.complain(&self.kind.span, what, help).into()
    }
}

/// A sensor of a cell file.
#[derive(Clone, Debug)]
pub(super) struct SensorEntry {
    pub name: String,
    pub of: Option<String>,
    pub readers: Option<Vec<String>>,
    pub every: Option<u32>,
    pub stale_after: Option<Duration>,
    pub mode: VspMode,
    pub latency: Duration,
}
