//! What a robot carries, as its drives are told.

use nalgebra::{Matrix3, Vector3};

use crate::model::pose::Pose;
use crate::model::wire::{BadWords, Wire, layout_hash};

/// What a robot carries on its flange, its tool included: mass, centre of mass and inertia. Drives that regulate by a model
/// of their robot need to know it.
///
/// ```
/// use mrroc::nalgebra::{Matrix3, Vector3};
/// use mrroc::robot::Load;
///
/// let hand = Load { mass: 0.9, centre: Vector3::new(0.0, 0.0, 0.06), inertia: Matrix3::identity() * 1e-3 };
/// assert!(hand.fault().is_none());
/// assert!(Load { mass: -1.0, ..hand }.fault().is_some());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass in the flange frame F \[m\].
    pub centre: Vector3<f64>,
    /// Inertia about the centre of mass, in the axes of the flange \[kg m²\]: symmetric.
    pub inertia: Matrix3<f64>,
}

impl Load {
    /// Nothing on the flange.
    pub const NONE: Load = Load {
        mass: 0.0,
        centre: Vector3::new(0.0, 0.0, 0.0),
        inertia: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    /// A body that is small for its distance from the flange: mass \[kg\] and centre in the flange frame \[m\].
    #[must_use]
    pub const fn point(mass: f64, centre: Vector3<f64>) -> Load {
        Load { mass, centre, ..Load::NONE }
    }

    /// Why it is the load of no body: a negative mass, an inertia that no body has; `None` if it is one.
    ///
    /// The principal moments of a body are not negative, and none is larger than the sum of the two others.
    #[must_use]
    pub fn fault(&self) -> Option<&'static str> {
        let Load { mass, centre, inertia } = self;
        if !(mass.is_finite() && *mass >= 0.0) {
            return Some("its mass is negative, or no number");
        }
        if !centre.iter().all(|x| x.is_finite()) {
            return Some("its centre of mass is no place");
        }
        if !inertia.iter().all(|x| x.is_finite()) {
            return Some("its inertia is no number");
        }
        let scale = inertia.amax().max(f64::MIN_POSITIVE);
        if (inertia - inertia.transpose()).amax() > ASYMMETRY * scale {
            return Some("its inertia is not symmetric");
        }
        let moments = inertia.symmetric_eigenvalues();
        // Seven digits are what a demand carries of it.
        let round_off = 1e-6 * scale;
        if moments.min() < -round_off || 2.0 * moments.max() > moments.sum() + round_off {
            return Some(
                "no body has its inertia: a moment is negative, or larger than the sum of the two others",
            );
        }
        None
    }
}

/// A load as a demand carries it. Every demand has room for one and is copied in every step, so it is small: centre and inertia
/// have seven digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CompactLoad {
    mass: f64,
    centre: [f32; 3],
    /// xx, xy, xz, yy, yz, zz.
    inertia: [f32; 6],
}

impl From<Load> for CompactLoad {
    fn from(load: Load) -> CompactLoad {
        let Load { mass, centre, inertia } = load;
        let upper = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|place| inertia[place] as f32);
        // One that is not symmetric stays none: whoever gets it refuses what is no number.
        let is_symmetric = (inertia - inertia.transpose()).amax() <= ASYMMETRY * inertia.amax();
        CompactLoad {
            mass,
            centre: [centre.x as f32, centre.y as f32, centre.z as f32],
            inertia: if is_symmetric { upper } else { [f32::NAN; 6] },
        }
    }
}

impl From<CompactLoad> for Load {
    fn from(load: CompactLoad) -> Load {
        let [x, y, z] = load.centre.map(f64::from);
        let i = load.inertia.map(f64::from);
        Load {
            mass: load.mass,
            centre: Vector3::new(x, y, z),
            inertia: Matrix3::new(i[0], i[1], i[2], i[1], i[3], i[4], i[2], i[4], i[5]),
        }
    }
}

/// By how much an inertia may differ from its transpose, as a share.
const ASYMMETRY: f64 = 1e-9;

/// Words of a load.
pub const LOAD_WORDS: usize = 10;

impl Wire for Load {
    const LEN: usize = LOAD_WORDS;
    const LAYOUT: u64 = layout_hash(0, "mrroc::robot::Load");

    fn put(&self, words: &mut [u64]) {
        let Load { mass, centre, inertia } = self;
        let upper = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|place| inertia[place]);
        let numbers = [*mass, centre.x, centre.y, centre.z].into_iter().chain(upper);
        words.iter_mut().zip(numbers).for_each(|(word, x)| *word = x.to_bits());
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let words = words.get(..LOAD_WORDS).ok_or(BadWords)?;
        let x = |i: usize| f64::from_bits(words[i]);
        Ok(Load {
            mass: x(0),
            centre: Vector3::new(x(1), x(2), x(3)),
            inertia: Matrix3::new(x(4), x(5), x(6), x(5), x(7), x(8), x(6), x(8), x(9)),
        })
    }
}

/// A tool of a cell: where its tip is on the flange, and what it weighs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    /// `X_FE`, the tool frame in the flange frame.
    pub frame: Pose,
    /// What the flange carries with this tool.
    pub load: Load,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_is_that_of_a_body_or_says_why_not() {
        // A cuboid of 2 kg with edges 0.1, 0.2, 0.3 m: m (b² + c²) / 12 and so on.
        let (m, [a, b, c]) = (2.0, [0.1_f64, 0.2, 0.3]);
        let moments = Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) * (m / 12.0);
        let cuboid = Load { mass: m, centre: Vector3::zeros(), inertia: Matrix3::from_diagonal(&moments) };
        assert_eq!(cuboid.fault(), None);
        // A thin rod is at the limit: two equal moments and a third of 0.
        let rod = Matrix3::from_diagonal(&Vector3::new(0.01, 0.01, 0.0));
        assert_eq!(Load { inertia: rod, ..cuboid }.fault(), None);
        assert_eq!(Load::NONE.fault(), None);
        assert_eq!(Load::point(1.0, Vector3::z()).fault(), None);

        let odd = [
            Load { mass: -0.1, ..cuboid },
            Load { mass: f64::NAN, ..cuboid },
            Load { centre: Vector3::new(0.0, f64::INFINITY, 0.0), ..cuboid },
            Load { inertia: Matrix3::from_diagonal(&Vector3::new(0.01, 0.01, 0.03)), ..cuboid },
            Load { inertia: Matrix3::from_diagonal(&Vector3::new(0.01, -0.01, 0.01)), ..cuboid },
            Load { inertia: Matrix3::new(1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), ..cuboid },
            Load { inertia: Matrix3::repeat(f64::NAN), ..cuboid },
        ];
        for load in odd {
            assert!(load.fault().is_some(), "{load:?}");
        }
    }

    #[test]
    fn the_words_of_a_load_say_it() {
        let inertia = Matrix3::new(1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 2.5);
        let load = Load { mass: 3.0, centre: Vector3::new(0.1, -0.2, 0.3), inertia };
        let mut words = [u64::MAX; LOAD_WORDS];
        load.put(&mut words);
        assert_eq!(Load::get(&words), Ok(load));
        assert_eq!(Load::get(&words[1..]), Err(BadWords));
    }
}
