//! The demanded next state of a robot, `e^{i+1}`: what a step function returns.

use nalgebra::{Matrix4, Vector3};

use crate::joints::{JointVector, MAX_JOINTS};
use crate::pose::Pose;
use crate::robot::Robot;
use crate::wire::{BadWords, Wire};

/// One representation of the next state of a robot of kind `R`, and optionally the tool that it refers to.
///
/// All poses are of the tool frame E in the world W, lengths in metres, angles in radians. The EDP converts;
/// only joint coordinates depend on the kind of robot.
#[derive(Debug, PartialEq)]
pub struct Demand<R: Robot> {
    pub(crate) coordinates: Coordinates<R>,
    pub(crate) tool: Option<Pose>,
}

/// The coordinates of a demand.
#[derive(Debug, PartialEq)]
pub(crate) enum Coordinates<R: Robot> {
    Hold,
    Joints(R::Joints),
    Pose(Pose),
    Homogeneous(Matrix4<f64>),
    EulerZyz { position: Vector3<f64>, angles: [f64; 3] },
    AngleAxis { position: Vector3<f64>, rotation: Vector3<f64> },
    Displacement(Pose),
}

// Derived, these would ask for `R: Copy`; the kind is only a name here.
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

impl<R: Robot> Demand<R> {
    const fn of(coordinates: Coordinates<R>) -> Self {
        Demand { coordinates, tool: None }
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

    /// The pose `X_WE` as a homogeneous transform; refused when its rotation is not orthonormal to 1e-6.
    #[must_use]
    #[allow(non_snake_case)]
    pub const fn homogeneous(X_WE: Matrix4<f64>) -> Self {
        Self::of(Coordinates::Homogeneous(X_WE))
    }

    /// The tool's position [m] and the ZYZ Euler angles (alpha, beta, gamma) [rad] of its orientation.
    #[must_use]
    pub const fn position_zyz(position: Vector3<f64>, angles: [f64; 3]) -> Self {
        Self::of(Coordinates::EulerZyz { position, angles })
    }

    /// The tool's position [m] and its orientation as a rotation vector, axis times angle [rad].
    #[must_use]
    pub const fn position_angle_axis(position: Vector3<f64>, rotation: Vector3<f64>) -> Self {
        Self::of(Coordinates::AngleAxis { position, rotation })
    }

    /// `X_EsE`, the displacement from the pose Es demanded at the start of the instruction, in the tool's own
    /// axes of that moment: the demand is `X_WEs * X_EsE`.
    #[must_use]
    #[allow(non_snake_case)]
    pub const fn displacement(X_EsE: Pose) -> Self {
        Self::of(Coordinates::Displacement(X_EsE))
    }

    /// The same demand for another tool: `X_FE`, the tool frame in the flange frame. It stays in force until
    /// the next demand with a tool.
    #[must_use]
    #[allow(non_snake_case)]
    pub const fn with_tool(mut self, X_FE: Pose) -> Self {
        self.tool = Some(X_FE);
        self
    }
}

const TOOL: u64 = 1 << 8;

impl<R: Robot> Demand<R> {
    /// The layout depends on the kind of robot through its name and its number of joints.
    const KIND_LAYOUT: u64 = crate::wire::layout_hash(R::Joints::LEN as u64, R::KIND);
}

impl<R: Robot> Wire for Demand<R> {
    const LEN: usize = 1 + 16 + 7;
    const LAYOUT: u64 = crate::wire::layout_hash(Self::KIND_LAYOUT, "mrroc::Demand");

    fn put(&self, words: &mut [u64]) {
        let (head, body) = words.split_at_mut(1);
        let (body, tool) = body.split_at_mut(16);
        let kind = match &self.coordinates {
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
            Coordinates::Homogeneous(matrix) => {
                for (word, x) in body.iter_mut().zip(matrix.iter()) {
                    *word = x.to_bits();
                }
                3
            }
            Coordinates::EulerZyz { position, angles } => {
                position.put(body);
                angles.put(&mut body[3..]);
                4
            }
            Coordinates::AngleAxis { position, rotation } => {
                position.put(body);
                rotation.put(&mut body[3..]);
                5
            }
            Coordinates::Displacement(pose) => {
                pose.put(body);
                6
            }
        };
        head[0] = kind;
        if let Some(pose) = &self.tool {
            head[0] |= TOOL;
            pose.put(tool);
        }
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let (&head, body) = words.split_first().ok_or(BadWords)?;
        if body.len() < 16 + 7 {
            return Err(BadWords);
        }
        let coordinates = match head & !TOOL {
            0 => Coordinates::Hold,
            1 => Coordinates::Joints(R::Joints::from_joints(|i| f64::from_bits(body[i.min(MAX_JOINTS - 1)]))),
            2 => Coordinates::Pose(Pose::get(body)?),
            3 => Coordinates::Homogeneous(Matrix4::from_iterator(body[..16].iter().map(|&w| f64::from_bits(w)))),
            4 => Coordinates::EulerZyz { position: Wire::get(body)?, angles: <[f64; 3]>::get(&body[3..])? },
            5 => Coordinates::AngleAxis { position: Wire::get(body)?, rotation: Wire::get(&body[3..])? },
            6 => Coordinates::Displacement(Pose::get(body)?),
            _ => return Err(BadWords),
        };
        let tool = if head & TOOL == 0 { None } else { Some(Pose::get(&body[16..])?) };
        Ok(Demand { coordinates, tool })
    }
}
