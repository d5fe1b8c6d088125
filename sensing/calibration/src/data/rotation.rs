//! How a table writes orientations.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// A convention to write an orientation in columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Spelling {
    /// Quaternion, scalar first or last.
    Wxyz,
    Xyzw,
    /// Axis times angle.
    Vector,
    /// Three turns about these axes (0 to 2), which move with the body or are fixed.
    Euler([usize; 3], Turning),
    /// 3 x 3, by rows.
    Matrix,
}

/// Whether the axes of successive turns move with the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turning {
    Moving,
    Fixed,
}

/// What may be written for it.
pub(super) const HELP: &str = "write \"quaternion wxyz\", \"quaternion xyzw\", \"rotation vector\", \"matrix\" (nine columns by rows), or three \
                               turns in their order, about axes that move with the body or stay, such as \"euler zyx moving\" or \"euler xyz fixed\"";

impl Spelling {
    pub(crate) fn parse(text: &str) -> Option<Self> {
        match text {
            "quaternion wxyz" => return Some(Self::Wxyz),
            "quaternion xyzw" => return Some(Self::Xyzw),
            "rotation vector" => return Some(Self::Vector),
            "matrix" => return Some(Self::Matrix),
            _ => {}
        }
        let rest = text.strip_prefix("euler ")?;
        let (letters, turning) = rest.split_once(' ')?;
        let turning = match turning {
            "moving" => Turning::Moving,
            "fixed" => Turning::Fixed,
            _ => return None,
        };
        let axes: Option<Vec<usize>> = letters.chars().map(|letter| "xyz".find(letter)).collect();
        let axes: [usize; 3] = axes?.try_into().ok()?;
        (axes[0] != axes[1] && axes[1] != axes[2]).then_some(Self::Euler(axes, turning))
    }

    /// How many columns it takes.
    pub(super) const fn columns(self) -> usize {
        match self {
            Self::Wxyz | Self::Xyzw => 4,
            Self::Vector | Self::Euler(..) => 3,
            Self::Matrix => 9,
        }
    }

    /// Whether its numbers are angles.
    pub(crate) const fn is_angles(self) -> bool {
        matches!(self, Self::Vector | Self::Euler(..))
    }

    /// The orientation, or why there is none.
    pub(crate) fn read(self, numbers: &[f64]) -> Result<UnitQuaternion<f64>, String> {
        match self {
            Self::Wxyz => quaternion(numbers[0], &numbers[1..]),
            Self::Xyzw => quaternion(numbers[3], numbers),
            Self::Vector => {
                Ok(UnitQuaternion::from_scaled_axis(Vector3::new(numbers[0], numbers[1], numbers[2])))
            }
            Self::Euler(axes, turning) => {
                let turn = |i: usize| UnitQuaternion::from_scaled_axis(Vector3::ith(axes[i], numbers[i]));
                Ok(match turning {
                    Turning::Moving => turn(0) * turn(1) * turn(2),
                    Turning::Fixed => turn(2) * turn(1) * turn(0),
                })
            }
            Self::Matrix => {
                let matrix = Matrix3::from_row_slice(numbers);
                let off = (matrix * matrix.transpose() - Matrix3::identity()).amax();
                if off > 1e-2 || matrix.determinant() < 0.0 {
                    return Err(format!("a matrix that is no rotation: it is off by {off:.3}"));
                }
                Ok(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&matrix)))
            }
        }
    }
}

fn quaternion(w: f64, xyz: &[f64]) -> Result<UnitQuaternion<f64>, String> {
    let read = Quaternion::new(w, xyz[0], xyz[1], xyz[2]);
    let norm = read.norm();
    if (norm - 1.0).abs() > 1e-2 {
        return Err(format!("a quaternion of length {norm:.4}, not 1"));
    }
    Ok(UnitQuaternion::new_normalize(read))
}
