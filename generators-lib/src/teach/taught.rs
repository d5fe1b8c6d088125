//! What was taught.

use std::path::Path;

use mrroc::fault::{FaultKind, Name};
use mrroc::pose::{AngleAxis, Zyz};
use mrroc::prelude::*;
use mrroc::robot::{JointVector, MAX_JOINTS};
use mrroc::suggestion::suggestion;
use nalgebra::{Translation3, Vector3};

/// The most coordinates of a pose.
pub const MAX_COORDINATES: usize = MAX_JOINTS;

/// What the coordinates mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// Motor angles \[rad\]: readable, but only the robot's own transmission knows where they lead.
    Motor,
    /// Joint positions [rad or m].
    Joint,
    /// Position \[m\] and ZYZ Euler angles \[rad\] of the tool.
    Zyz,
    /// Position \[m\] and rotation vector \[rad\] of the tool.
    AngleAxis,
}

/// What the coordinates count from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The robot's zero, or the world.
    Absolute,
    /// The pose before: joint by joint, or in its tool frame.
    Relative,
}

/// One pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaughtPose {
    /// Share of the largest velocity, > 0, <= 1.
    pub velocity: f64,
    /// Share of the largest acceleration, > 0, <= 1.
    pub acceleration: f64,
    pub(super) coordinates: [f64; MAX_COORDINATES],
    pub(super) count: usize,
    pub(super) name: Option<Name>,
}

impl TaughtPose {
    /// Of up to [`MAX_COORDINATES`] coordinates, with shares of velocity and acceleration; `None` where there are more, none, or
    /// a number is out of range.
    #[must_use]
    pub fn new(velocity: f64, acceleration: f64, coordinates: &[f64]) -> Option<Self> {
        let is_share = |x: f64| x > 0.0 && x <= 1.0;
        let fits = (1..=MAX_COORDINATES).contains(&coordinates.len());
        if !(fits
            && is_share(velocity)
            && is_share(acceleration)
            && coordinates.iter().all(|x| x.is_finite()))
        {
            return None;
        }
        let mut all = [0.0; MAX_COORDINATES];
        all[..coordinates.len()].copy_from_slice(coordinates);
        Some(TaughtPose { velocity, acceleration, coordinates: all, count: coordinates.len(), name: None })
    }

    /// The same pose with a name.
    #[must_use]
    pub fn named(self, name: Name) -> Self {
        TaughtPose { name: Some(name), ..self }
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> Option<Name> {
        self.name
    }

    /// A pose `X_WE` of the tool, as position and rotation vector.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn of_pose(velocity: f64, acceleration: f64, X_WE: &Pose) -> Option<Self> {
        let p = X_WE.translation.vector;
        let r = AngleAxis::of(&X_WE.rotation).0;
        Self::new(velocity, acceleration, &[p.x, p.y, p.z, r.x, r.y, r.z])
    }

    /// The coordinates.
    #[must_use]
    pub fn coordinates(&self) -> &[f64] {
        &self.coordinates[..self.count]
    }

    /// As joint positions, where there is one for each.
    #[must_use]
    pub fn joints<J: JointVector>(&self) -> Option<J> {
        (self.count == J::LEN).then(|| J::from_joints(|i| self.coordinates[i]))
    }

    /// As a pose or displacement of the tool, where `space` says so and there are six coordinates.
    #[must_use]
    pub fn pose(&self, space: Space) -> Option<Pose> {
        let &[x, y, z, a, b, c] = self.coordinates() else { return None };
        let rotation = match space {
            Space::Zyz => Zyz { alpha: a, beta: b, gamma: c }.rotation(),
            Space::AngleAxis => AngleAxis(Vector3::new(a, b, c)).rotation(),
            Space::Motor | Space::Joint => return None,
        };
        Some(Pose::from_parts(Translation3::new(x, y, z), rotation))
    }
}

/// A sequence of taught poses. Edit it as the list that it is; [`Display`](core::fmt::Display) and
/// [`FromStr`](core::str::FromStr) write and read its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Taught {
    /// What the coordinates mean.
    pub space: Space,
    /// What they count from.
    pub reference: Reference,
    /// The poses, in order.
    pub poses: Vec<TaughtPose>,
}

impl Taught {
    /// Reads a file of taught poses, such as those that a panel keeps of a robot.
    ///
    /// # Errors
    /// `Config`: the file cannot be read, or has a line that is wrong.
    pub fn read(file: &Path) -> Result<Taught, Fault> {
        let refused = |why: &dyn core::fmt::Display| {
            Fault::new(FaultKind::Config).text(&format!("taught poses of {}: {why}", file.display()))
        };
        let text = std::fs::read_to_string(file).map_err(|why| refused(&why))?;
        text.parse().map_err(|why| refused(&why))
    }

    /// The poses of these names, in this order: a pose may come more than once.
    ///
    /// ```
    /// use mrroc_generators::teach::Taught;
    ///
    /// let file = "space joint\nreference absolute\nhome = 0.5 0.5 : 0 -1.57\npick = 0.2 0.2 : 0.4 -1.2\n";
    /// let taught: Taught = file.parse()?;
    /// let there_and_back = taught.select(&["pick", "home"])?;
    /// assert_eq!(there_and_back.poses[1].coordinates(), [0.0, -1.57]);
    /// assert!(taught.select(&["pich"]).is_err_and(|fault| fault.message().contains("did you mean `pick`?")));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// `Config`: there is no pose of one of the names.
    pub fn select(&self, names: &[&str]) -> Result<Taught, Fault> {
        let find = |name: &&str| {
            let named = |pose: &&TaughtPose| pose.name.as_ref().is_some_and(|known| known.as_str() == *name);
            self.poses.iter().find(named).copied().ok_or_else(|| {
                let known: Vec<String> =
                    self.poses.iter().filter_map(|pose| Some(pose.name?.to_string())).collect();
                let help = match known.is_empty() {
                    true => "no pose has a name: teach it at the panel".to_owned(),
                    false => suggestion(name, &known, "there are"),
                };
                Fault::new(FaultKind::Config).text(&format!("no pose `{name}` is taught: {help}"))
            })
        };
        Ok(Taught { poses: names.iter().map(find).collect::<Result<_, _>>()?, ..self.clone() })
    }

    /// Where its poses lead from the joint positions `q` [rad or m] and the pose `X_WE`, as demands, the first one last: a generator takes them
    /// from the end. What a robot cannot be told, and all that comes after it, is left out.
    ///
    /// ```
    /// use mrroc::prelude::*;
    /// use mrroc_generators::teach::{Reference, Space, Taught, TaughtPose};
    /// use mrroc_robots::{Irp6, Six};
    ///
    /// let turn = TaughtPose::new(0.5, 0.5, &[0.1, 0.0, 0.0, 0.0, 0.0, 0.0]).expect("shares of 1");
    /// let taught = Taught { space: Space::Joint, reference: Reference::Relative, poses: vec![turn, turn] };
    /// let goals = taught.goals::<Irp6>((Six::zeros(), Pose::identity()));
    /// assert_eq!(goals, [Demand::joints(Six::x() * 0.2), Demand::joints(Six::x() * 0.1)]);
    /// ```
    #[must_use]
    #[allow(non_snake_case)]
    pub fn goals<R: Robot>(&self, (mut q, mut X_WE): (R::Joints, Pose)) -> Vec<Demand<R>> {
        let relative = self.reference == Reference::Relative;
        let goal = |pose: &TaughtPose| match self.space {
            Space::Motor => None,
            Space::Joint => pose.joints::<R::Joints>().map(|to| {
                q = if relative { q + to } else { to };
                Demand::joints(q)
            }),
            space @ (Space::Zyz | Space::AngleAxis) => pose.pose(space).map(|to| {
                X_WE = if relative { X_WE * to } else { to };
                Demand::pose(X_WE)
            }),
        };
        let mut goals: Vec<_> = self.poses.iter().map_while(goal).collect();
        goals.reverse();
        goals
    }
}

/// What the panel says by which a tool is jogged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jogging {
    /// Velocity along the tool's axes [m/s].
    pub along: Vector3<f64>,
    /// Angular velocity about them [rad/s].
    pub about: Vector3<f64>,
    /// Whether the button is pressed that records: once for each time.
    pub record: bool,
    /// Whether the session is over.
    pub done: bool,
}
