//! The smallest distance of a whole run.

use mrroc::observe::Observation;
use mrroc::robot::MAX_JOINTS;

use super::check::Clearance;
use super::error::{CheckError, Nearest};

/// When bodies were nearest, and which.
#[derive(Clone, Debug, PartialEq)]
pub struct Closest {
    /// Time since the cell started \[s\].
    pub time: f64,
    /// The bodies; without travel and margin.
    pub nearest: Nearest,
}

/// Watches a run of a cell and keeps its smallest distance.
///
/// Give it to `Cell::watch`: `cell.watch(move |seen| dry_run.borrow_mut().observe(seen))`. Robots with other servo periods
/// count as standing between their observations.
pub struct DryRun {
    clearance: Clearance,
    /// The joints of each robot as they were last seen; `None` before the first time.
    joints: Vec<Option<[f64; MAX_JOINTS]>>,
    time: f64,
    is_new: bool,
    closest: Option<Closest>,
    failed: Option<CheckError>,
}

impl DryRun {
    /// A dry run of these robots.
    #[must_use]
    pub fn new(clearance: Clearance) -> Self {
        let joints = vec![None; clearance.robot_count()];
        Self { clearance, joints, time: 0.0, is_new: false, closest: None, failed: None }
    }

    /// Takes the measured joints of a robot; robots that the clearance does not know are left out.
    pub fn observe(&mut self, observation: &Observation<'_>) {
        self.see(observation.time, observation.robot, observation.measured);
    }

    /// Takes a robot's joint positions [rad or m] at a time \[s\] not before the last one.
    pub fn see(&mut self, time: f64, robot: &str, joints: &[f64]) {
        if time > self.time {
            self.look();
            self.time = time;
        }
        let Some(place) = self.clearance.place_of(robot) else { return };
        let mut all = [0.0; MAX_JOINTS];
        all.iter_mut().zip(joints).for_each(|(entry, joint)| *entry = *joint);
        self.joints[place] = Some(all);
        self.is_new = true;
    }

    /// The smallest distance so far; `None` when not every robot has been seen.
    ///
    /// # Errors
    /// The first state that could not be checked.
    pub fn closest(&mut self) -> Result<Option<&Closest>, CheckError> {
        self.look();
        match &self.failed {
            Some(error) => Err(error.clone()),
            None => Ok(self.closest.as_ref()),
        }
    }

    fn look(&mut self) {
        if !core::mem::take(&mut self.is_new) || self.failed.is_some() {
            return;
        }
        if self.joints.iter().any(Option::is_none) {
            return;
        }
        match self.clearance.nearest_of(|robot| self.joints[robot].as_ref().map(|joints| &joints[..])) {
            Ok(nearest) => {
                let is_closer =
                    self.closest.as_ref().is_none_or(|closest| nearest.distance < closest.nearest.distance);
                if is_closer {
                    self.closest = Some(Closest { time: self.time, nearest });
                }
            }
            Err(error) => self.failed = Some(error),
        }
    }
}

/// The smallest distance of a recorded run: times \[s\] in order, each with a robot's name and its joint positions [rad or m].
/// `None` for a run that never shows all robots.
///
/// # Errors
/// The first state that cannot be checked.
pub fn smallest_distance<'a>(
    clearance: Clearance,
    run: impl IntoIterator<Item = (f64, &'a str, &'a [f64])>,
) -> Result<Option<Closest>, CheckError> {
    let mut dry_run = DryRun::new(clearance);
    run.into_iter().for_each(|(time, robot, joints)| dry_run.see(time, robot, joints));
    Ok(dry_run.closest()?.cloned())
}
