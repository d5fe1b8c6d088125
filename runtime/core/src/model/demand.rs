//! The demanded next state of a robot, `e^{i+1}`: what a step function returns.

use nalgebra::{Matrix3, Matrix4, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::model::beside::{BESIDE_WORDS, Beside, Goal};
use crate::model::driver::Regulators;
use crate::model::joints::{JointVector, MAX_JOINTS};
use crate::model::load::Load;
use crate::model::pose::{AngleAxis, Pose, Zyz};
use crate::model::robot::Robot;
use crate::model::shape::Shape;
use crate::model::signals::{Channel, Level, OUTPUT_WORDS, Output, Outputs, Value};
use crate::model::wire::{BadWords, Wire};

/// One representation of the next state of a robot of kind `R`, and optionally the tool that it refers to, the value of
/// the robot's redundancy, the regulators' parameter sets, values for the robot's outputs, and what it carries.
///
/// All poses are of the tool frame E in the world W, lengths in metres, angles in radians. The EDP converts;
/// only joint coordinates depend on the kind of robot.
#[derive(Debug)]
pub struct Demand<R: Robot> {
    pub(crate) coordinates: Coordinates<R>,
    pub(crate) tool: Option<Pose>,
    pub(crate) redundancy: Option<f64>,
    pub(crate) regulators: Option<Regulators>,
    pub(crate) outputs: Outputs,
    beside: Beside,
}

/// The coordinates of a demand.
#[derive(Debug)]
pub(crate) enum Coordinates<R: Robot> {
    Hold,
    Joints(R::Joints),
    Pose(Pose),
    Displacement(Pose),
}

// Derived implementations would require the same traits of `R`, which is only a name here.
impl<R: Robot> Clone for Demand<R> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<R: Robot> Copy for Demand<R> {}
impl<R: Robot> Clone for Coordinates<R> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<R: Robot> Copy for Coordinates<R> {}
impl<R: Robot> PartialEq for Demand<R> {
    fn eq(&self, other: &Self) -> bool {
        (self.tool, self.redundancy, self.regulators) == (other.tool, other.redundancy, other.regulators)
            && (self.outputs, self.beside) == (other.outputs, other.beside)
            && self.coordinates == other.coordinates
    }
}
impl<R: Robot> PartialEq for Coordinates<R> {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Coordinates::Hold, Coordinates::Hold) => true,
            (Coordinates::Joints(a), Coordinates::Joints(b)) => a == b,
            (Coordinates::Pose(a), Coordinates::Pose(b)) => a == b,
            (Coordinates::Displacement(a), Coordinates::Displacement(b)) => a == b,
            (
                Coordinates::Hold
                | Coordinates::Joints(_)
                | Coordinates::Pose(_)
                | Coordinates::Displacement(_),
                _,
            ) => false,
        }
    }
}

impl<R: Robot> Demand<R> {
    const fn of(coordinates: Coordinates<R>) -> Self {
        Demand {
            coordinates,
            tool: None,
            redundancy: None,
            regulators: None,
            outputs: Outputs::NONE,
            beside: Beside::Nothing,
        }
    }

    /// Stay at the state demanded last.
    #[must_use]
    pub const fn hold() -> Self {
        Self::of(Coordinates::Hold)
    }

    /// Joint positions [rad or m].
    #[must_use]
    pub const fn joints(q: R::Joints) -> Self {
        Self::of(Coordinates::Joints(q))
    }

    /// The pose `X_WE` of the tool in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub const fn pose(X_WE: Pose) -> Self {
        Self::of(Coordinates::Pose(X_WE))
    }

    /// The pose `X_WE` as a homogeneous transform; refused at the EDP when its rotation is not orthonormal and
    /// right-handed to 1e-6.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn homogeneous(X_WE: &Matrix4<f64>) -> Self {
        let R_WE: Matrix3<f64> = X_WE.fixed_view::<3, 3>(0, 0).into_owned();
        let position = Translation3::new(X_WE[(0, 3)], X_WE[(1, 3)], X_WE[(2, 3)]);
        let handedness = if R_WE.determinant() < 0.0 { 2.0 } else { 0.0 };
        let row = X_WE.fixed_view::<1, 4>(3, 0) - nalgebra::RowVector4::new(0.0, 0.0, 0.0, 1.0);
        let defect = (R_WE.transpose() * R_WE - Matrix3::identity()).amax() + row.amax() + handedness;
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(R_WE));
        // The defect travels as the quaternion's norm, which the EDP checks as it does every pose's.
        let rotation = UnitQuaternion::new_unchecked(rotation.into_inner() * (1.0 + defect));
        Self::pose(Pose::from_parts(position, rotation))
    }

    /// The tool's position \[m\] and the ZYZ Euler angles of its orientation.
    #[must_use]
    pub fn position_zyz(position: Vector3<f64>, angles: Zyz) -> Self {
        Self::pose(Pose::from_parts(Translation3::from(position), angles.rotation()))
    }

    /// The tool's position \[m\] and its orientation as a rotation vector.
    #[must_use]
    pub fn position_angle_axis(position: Vector3<f64>, rotation: AngleAxis) -> Self {
        let rotation = if rotation.0.iter().all(|x| x.is_finite()) {
            rotation.rotation()
        } else {
            // Infinite angles have no sine: they stay visible to the EDP's check.
            UnitQuaternion::new_unchecked(Quaternion::new(f64::NAN, f64::NAN, f64::NAN, f64::NAN))
        };
        Self::pose(Pose::from_parts(Translation3::from(position), rotation))
    }

    /// `X_EsE`, the displacement from the pose Es demanded at the start of the instruction, in the tool's own
    /// axes of that moment: the demand is `X_WEs * X_EsE`.
    #[must_use]
    #[allow(non_snake_case)]
    pub const fn displacement(X_EsE: Pose) -> Self {
        Self::of(Coordinates::Displacement(X_EsE))
    }

    /// The joint positions [rad or m], if it demands joint positions.
    #[must_use]
    pub const fn as_joints(&self) -> Option<R::Joints> {
        match self.coordinates {
            Coordinates::Joints(q) => Some(q),
            Coordinates::Hold | Coordinates::Pose(_) | Coordinates::Displacement(_) => None,
        }
    }

    /// The pose `X_WE` of the tool in the world, if it demands a pose.
    #[must_use]
    pub const fn as_pose(&self) -> Option<Pose> {
        match self.coordinates {
            Coordinates::Pose(pose) => Some(pose),
            Coordinates::Hold | Coordinates::Joints(_) | Coordinates::Displacement(_) => None,
        }
    }

    /// The displacement `X_EsE`, if it demands a displacement.
    #[must_use]
    pub const fn as_displacement(&self) -> Option<Pose> {
        match self.coordinates {
            Coordinates::Displacement(pose) => Some(pose),
            Coordinates::Hold | Coordinates::Joints(_) | Coordinates::Pose(_) => None,
        }
    }

    /// The same demand with the tool moved on by `X_EE'` in its own axes; `None` if it demands joint positions or to
    /// hold.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn moved_in_tool(mut self, X_EE: &Pose) -> Option<Self> {
        match &mut self.coordinates {
            Coordinates::Pose(pose) | Coordinates::Displacement(pose) => *pose *= X_EE,
            Coordinates::Hold | Coordinates::Joints(_) => return None,
        }
        // Its motion leads elsewhere, too.
        if !self.beside.is_load() {
            self.beside = Beside::Nothing;
        }
        Some(self)
    }

    /// The same demand for another tool: `X_FE`, the tool frame in the flange frame. It stays in force until
    /// the next demand with a tool.
    #[must_use]
    #[allow(non_snake_case)]
    pub const fn with_tool(mut self, X_FE: Pose) -> Self {
        self.tool = Some(X_FE);
        self
    }

    /// The same pose or displacement with this value of the robot's redundancy, such as a track's position or an
    /// elbow's angle: see [`Robot::inverse_at`] of the kind. Without a value the joints stay near those demanded last.
    #[must_use]
    pub const fn with_redundancy(mut self, value: f64) -> Self {
        self.redundancy = Some(value);
        self
    }

    /// The same demand with these parameter sets for the regulators of the joints, which determine the dynamic
    /// behaviour of the robot. The sets change when the step of the demand begins; the drives reach its position later,
    /// by the cell's delay. The sets stay in force until a demand with other sets. A set that a drive does not have is
    /// a fault.
    #[must_use]
    pub const fn with_regulators(mut self, sets: Regulators) -> Self {
        self.regulators = Some(sets);
        self
    }

    /// The same demand with this value for an output of the robot. It switches when the drives have come to the position that
    /// is demanded with it, and stays so until another demand, or a stop for which the cell declares a value. A demand may
    /// switch several outputs; of two values for one the last counts.
    ///
    /// ```
    /// use mrroc::prelude::*;
    /// use mrroc::robot::{Channel, Output};
    /// use mrroc_robots::Irp6;
    ///
    /// # let arm_output = |_: &str| Output::<bool>::of(Channel::Digital(0)).ok_or("no digital channel");
    /// // In a program: `let vacuum = arm.output("vacuum")?`.
    /// let vacuum = arm_output("vacuum")?;
    /// let grasp = Demand::<Irp6>::hold().with_output(vacuum, true);
    /// assert_ne!(grasp, Demand::hold());
    /// # Ok::<(), &str>(())
    /// ```
    #[must_use]
    pub fn with_output<T: Level>(self, output: Output<T>, value: T) -> Self {
        self.with_value(output.channel(), value.value())
    }

    /// The same with this value for the output of a channel, of its type.
    pub(crate) const fn with_value(mut self, channel: Channel, value: Value) -> Self {
        self.outputs = self.outputs.with(channel, value);
        self
    }

    /// The same demand, and the drives are told that the robot carries this from now on, when the step of the demand begins. It
    /// stays so until another demand with a load. Drives that need not know it ignore it. A demand has the centre and the inertia
    /// to seven digits.
    #[must_use]
    pub fn with_load(mut self, load: Load) -> Self {
        self.beside = Beside::Load(load.into());
        self
    }

    /// The same demand, which also says where the motion leads: to the joint positions, the pose or the displacement of `goal`.
    /// One that the robot cannot reach is refused with this demand, and not when the motion comes to it. So generators name
    /// their goals in their first steps; to move there remains their work. Beside a [load](Self::with_load) there is no room
    /// for a goal.
    ///
    /// Refused are joints beyond their limits, and poses that are certainly out of reach with the tool of this demand: not
    /// those that only a search did not find.
    ///
    /// ```
    /// use mrroc::prelude::*;
    /// use mrroc_robots::{Irp6, Six};
    ///
    /// # let (first, goal) = (Six::repeat(0.001), Six::repeat(0.5));
    /// let demand = Demand::<Irp6>::joints(first).with_goal(Demand::joints(goal));
    /// assert_eq!(demand.as_joints(), Some(first));
    /// ```
    #[must_use]
    pub fn with_goal(mut self, goal: Demand<R>) -> Self {
        let goal = match goal.coordinates {
            Coordinates::Hold => return self,
            Coordinates::Joints(q) => Goal::Joints(q),
            Coordinates::Pose(pose) => Goal::Pose(pose),
            Coordinates::Displacement(pose) => Goal::Displacement(pose),
        };
        if !self.beside.is_load() {
            self.beside = Beside::of_goal(&goal);
        }
        self
    }

    /// The same tool, redundancy, regulators, outputs and load, to where `other` leads.
    ///
    /// ```
    /// use mrroc::prelude::*;
    /// use mrroc_robots::Irp6;
    ///
    /// let held = Demand::<Irp6>::hold().with_tool(Pose::translation(0.0, 0.0, 0.1));
    /// let led = held.led_to(&Demand::displacement(Pose::translation(0.01, 0.0, 0.0)));
    /// assert_eq!(led, Demand::displacement(Pose::translation(0.01, 0.0, 0.0)).with_tool(Pose::translation(0.0, 0.0, 0.1)));
    /// ```
    #[must_use]
    pub fn led_to(mut self, other: &Demand<R>) -> Self {
        self.coordinates = other.coordinates;
        // Its motion leads elsewhere, too.
        if !self.beside.is_load() {
            self.beside = Beside::Nothing;
        }
        self
    }

    /// Where its motion leads, if it says so.
    pub(crate) fn goal(&self) -> Option<Goal<R::Joints>> {
        self.beside.goal()
    }

    /// What the robot is said to carry from now on.
    pub(crate) fn load(&self) -> Option<Load> {
        self.beside.load()
    }
}

/// The pose `X_WE` of the tool in the world, which can be demanded of every kind of robot.
#[allow(non_snake_case)]
impl<R: Robot> From<Pose> for Demand<R> {
    fn from(X_WE: Pose) -> Self {
        Demand::pose(X_WE)
    }
}

const TOOL: u64 = 1 << 8;
const REDUNDANCY: u64 = 1 << 9;
const REGULATORS: u64 = 1 << 10;
const OUTPUTS: u64 = 1 << 11;
const LOAD: u64 = 1 << 12;
const GOAL: u64 = 1 << 13;
const MORE: u64 = TOOL | REDUNDANCY | REGULATORS | OUTPUTS | LOAD | GOAL;

/// Words up to the end of the choices, of the outputs, of the load or the goal.
const CHOSEN: usize = 1 + MAX_JOINTS + 7 + 2;
const SWITCHED: usize = CHOSEN + OUTPUT_WORDS;
const LOADED: usize = SWITCHED + BESIDE_WORDS;

impl<R: Robot> Demand<R> {
    /// The layout depends on the kind of robot through its name and its number of joints.
    const KIND_LAYOUT: u64 = crate::model::wire::layout_hash(R::Joints::LEN as u64, R::KIND);
}

impl<R: Robot> Wire for Demand<R> {
    const LEN: usize = LOADED;
    const LAYOUT: u64 =
        crate::model::wire::layout_hash(Self::KIND_LAYOUT, "mrroc::generator::Demand with goals");
    const SHAPE: &'static Shape = &Shape::Demand;

    #[inline]
    fn put(&self, words: &mut [u64]) {
        let (head, body) = words.split_at_mut(1);
        head[0] = match &self.coordinates {
            Coordinates::Hold => 0,
            Coordinates::Joints(q) => {
                for (word, q) in body.iter_mut().zip(q.as_slice()) {
                    *word = q.to_bits();
                }
                1
            }
            Coordinates::Pose(pose) => {
                pose.put(body);
                2
            }
            Coordinates::Displacement(pose) => {
                pose.put(body);
                3
            }
        };
        if self.says_more() {
            self.put_choices(words);
        }
    }

    /// Its coordinates; the tool, what is chosen with it, the outputs, the load or the goal, up to the last that is there.
    #[inline]
    fn used(&self) -> usize {
        if self.says_more() {
            return match (self.beside.is_nothing(), self.outputs.is_none()) {
                (false, _) => LOADED,
                (true, false) => SWITCHED,
                (true, true) => CHOSEN,
            };
        }
        1 + match &self.coordinates {
            Coordinates::Hold => 0,
            Coordinates::Joints(_) => R::Joints::LEN,
            Coordinates::Pose(_) | Coordinates::Displacement(_) => Pose::LEN,
        }
    }

    #[inline]
    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let (&head, body) = words.split_first().ok_or(BadWords)?;
        // Each is made where it is returned: it is large.
        match head {
            0 => Ok(Demand::hold()),
            1 => {
                let joints = body.get(..R::Joints::LEN).ok_or(BadWords)?;
                Ok(Demand::joints(R::Joints::from_joints(|i| f64::from_bits(joints[i]))))
            }
            2 => Ok(Demand::pose(Pose::get(body)?)),
            3 => Ok(Demand::displacement(Pose::get(body)?)),
            _ => Self::get_choices(head, words),
        }
    }
}

/// What most demands do not say, so it is kept apart from what all do.
impl<R: Robot> Demand<R> {
    /// Whether it says anything but coordinates.
    #[inline]
    fn says_more(&self) -> bool {
        self.tool.is_some()
            || self.redundancy.is_some()
            || self.regulators.is_some()
            || !self.outputs.is_none()
            || !self.beside.is_nothing()
    }

    #[cold]
    fn put_choices(&self, words: &mut [u64]) {
        let (body, choices) = words[1 + MAX_JOINTS..LOADED].split_at_mut(7);
        let (choices, outputs) = choices.split_at_mut(2);
        let (outputs, beside) = outputs.split_at_mut(OUTPUT_WORDS);
        let mut more = 0;
        if let Some(tool) = &self.tool {
            more |= TOOL;
            tool.put(body);
        }
        if let Some(redundancy) = self.redundancy {
            more |= REDUNDANCY;
            choices[0] = redundancy.to_bits();
        }
        if let Some(regulators) = self.regulators {
            more |= REGULATORS;
            choices[1] = regulators.to_word();
        }
        if !self.outputs.is_none() {
            more |= OUTPUTS;
            self.outputs.put(outputs);
        }
        more |= match self.beside {
            Beside::Nothing => 0,
            Beside::Load(_) => LOAD,
            Beside::Goal(..) => GOAL,
        };
        self.beside.put(beside);
        words[0] |= more;
    }

    #[cold]
    fn get_choices(head: u64, words: &[u64]) -> Result<Self, BadWords> {
        let part = |from: usize, to: usize| words.get(from..to).ok_or(BadWords);
        let coordinates = part(1, words.len())?;
        let mut demand = match head & !MORE {
            0 => Demand::hold(),
            1 => {
                let joints = part(1, 1 + R::Joints::LEN)?;
                Demand::joints(R::Joints::from_joints(|i| f64::from_bits(joints[i])))
            }
            2 => Demand::pose(Pose::get(coordinates)?),
            3 => Demand::displacement(Pose::get(coordinates)?),
            _ => return Err(BadWords),
        };
        if head & (TOOL | REDUNDANCY | REGULATORS) != 0 {
            let choices = part(1 + MAX_JOINTS, CHOSEN)?;
            demand.tool = if head & TOOL == 0 { None } else { Some(Pose::get(choices)?) };
            demand.redundancy = (head & REDUNDANCY != 0).then(|| f64::from_bits(choices[7]));
            demand.regulators = (head & REGULATORS != 0).then(|| Regulators::from_word(choices[8]));
        }
        if head & OUTPUTS != 0 {
            demand.outputs = Outputs::get(part(CHOSEN, SWITCHED)?)?;
        }
        if head & LOAD != 0 {
            demand.beside = Beside::get_load(part(SWITCHED, LOADED)?)?;
        } else if head & GOAL != 0 {
            demand.beside = Beside::get_goal(part(SWITCHED, LOADED)?)?;
        }
        Ok(demand)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::signals::{Channel, Value};
    use crate::model::wire::WORDS;
    use crate::tests::slide::{One, Slide};

    #[test]
    fn the_words_that_are_sent_of_a_demand_say_all_of_it_and_none_of_them_is_too_many() {
        let pose = Pose::translation(1.0, -2.0, 3.0);
        let forms = [
            Demand::<Slide>::hold(),
            Demand::joints(One::new(0.5)),
            Demand::pose(pose),
            Demand::displacement(pose),
        ];
        let sent = [1, 2, 8, 8];
        let output = Output::<f64>::of(Channel::Analog(1)).expect("an analog one");
        let switched = Demand::<Slide>::hold().with_output(output, 0.25).outputs;
        assert_eq!(switched.value(Channel::Analog(1)), Some(Value::Analog(0.25)));
        let chosen: [fn(Demand<Slide>) -> Demand<Slide>; 7] = [
            |demand| demand,
            |demand| demand.with_tool(Pose::translation(0.0, 0.0, 0.1)),
            |demand| demand.with_redundancy(-0.25),
            |demand| demand.with_regulators(Regulators::default()),
            |demand| Demand {
                outputs: Outputs::NONE.with(Channel::Digital(3), Value::Digital(false)),
                ..demand
            },
            |demand| demand.with_load(Load::point(1.0, Vector3::z())),
            |demand| demand.with_goal(Demand::joints(One::new(0.75))),
        ];
        let whole = [0, 18, 18, 18, 24, 34, 34];
        for (form, sent) in forms.into_iter().zip(sent) {
            for (i, chosen) in chosen.iter().enumerate() {
                let demand = chosen(form);
                // Words of an earlier demand are still there.
                let mut words = [u64::MAX; WORDS];
                demand.put(&mut words);
                let used = demand.used();
                assert_eq!(used, if i == 0 { sent } else { whole[i] }, "{demand:?}");
                assert_eq!(Demand::get(&words[..used]), Ok(demand));
                assert_eq!(Demand::<Slide>::get(&words[..used - 1]), Err(BadWords), "{demand:?}");
            }
        }
    }

    #[test]
    fn a_goal_is_told_to_seven_digits_and_takes_no_room_of_its_own() {
        let pose = Pose::translation(1.0 / 3.0, -2.0, 3.0);
        let near = |a: &Pose, b: &Pose| (a.translation.vector - b.translation.vector).norm() < 1e-6;
        let told = |goal| Demand::<Slide>::hold().with_goal(goal).goal();
        assert!(matches!(told(Demand::pose(pose)), Some(Goal::Pose(at)) if near(&at, &pose)));
        assert!(matches!(told(Demand::displacement(pose)), Some(Goal::Displacement(at)) if near(&at, &pose)));
        assert_eq!(told(Demand::joints(One::new(0.75))), Some(Goal::Joints(One::new(0.75))));
        assert_eq!(told(Demand::hold()), None);
        // A load is told in any case.
        let loaded = Demand::<Slide>::hold().with_load(Load::point(1.0, Vector3::z()));
        assert_eq!(loaded.with_goal(Demand::pose(pose)), loaded);
        assert_eq!(size_of::<Beside>(), size_of::<Option<crate::model::load::CompactLoad>>());
    }
}
