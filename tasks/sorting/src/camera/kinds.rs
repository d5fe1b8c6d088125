//! The eight kinds of parts that the camera sorts: their forms, how they are grasped, what they weigh.

use mrroc::prelude::*;
use mrroc_robots::grasp::Body;
use mrroc_sensors::aggregation::PartClass;
use mrroc_sensors::form::{Form, Piece};
use nalgebra::{Matrix3, Vector3};

/// What parts weigh for their size [kg/m³].
const DENSITY: f64 = 1500.0;

/// A kind of parts. Its frame P lies on the belt where it is grasped.
#[derive(Clone, Debug)]
pub struct Kind {
    /// Its class, as vision knows it.
    pub class: PartClass,
    /// The convex outline of what the fingers touch, anticlockwise \[m, P\].
    outline: Vec<[f64; 2]>,
    /// \[m\].
    height: f64,
    /// The fingers close along y of P, turned by this about z \[rad\].
    pub grip: f64,
}

/// How many kinds there are.
pub const KINDS: usize = 8;

/// The kinds, in the order of the network's scores.
#[must_use]
pub fn kinds() -> Vec<Kind> {
    let block = |[a, b, c]: [f64; 3], [d, e, f]: [f64; 3]| Piece::Block {
        lower: Vector3::new(a, b, c),
        upper: Vector3::new(d, e, f),
    };
    let middle = |x: f64, y: f64, z: f64| block([-x / 2.0, -y / 2.0, 0.0], [x / 2.0, y / 2.0, z]);
    let tube = |radius, inner, height| Piece::Tube { radius, inner, height };
    let steps =
        [block([-0.04, -0.027, 0.0], [0.0, 0.027, 0.04]), block([0.0, -0.027, 0.0], [0.04, 0.027, 0.026])];
    // Grasped across its short leg, whose end is 58 mm from the outside of the long one.
    let legs = [
        block([-0.015, -0.029, 0.0], [0.069, 0.001, 0.032]),
        block([-0.015, 0.001, 0.0], [0.015, 0.029, 0.032]),
    ];
    vec![
        Kind::new("block", 2, [middle(0.07, 0.054, 0.04)], box_of(0.07, 0.054), 0.04),
        Kind::new("bar", 2, [middle(0.096, 0.05, 0.03)], box_of(0.096, 0.05), 0.03),
        Kind::new("disc", 0, [tube(0.03, 0.0, 0.036)], round(0.03), 0.036),
        Kind::new("ring", 0, [tube(0.03, 0.014, 0.032)], round(0.03), 0.032),
        Kind::new(
            "dome",
            0,
            [tube(0.029, 0.0, 0.026), Piece::Cap { radius: 0.037_022, centre: 0.002_978, from: 0.026 }],
            round(0.029),
            0.04,
        ),
        Kind {
            grip: core::f64::consts::FRAC_PI_2,
            ..Kind::new(
                "half-cylinder",
                2,
                [Piece::Half { radius: 0.037, half_length: 0.028 }],
                box_of(0.056, 0.074),
                0.037,
            )
        },
        Kind::new("step", 1, steps, box_of(0.08, 0.054), 0.04),
        Kind::new(
            "angle",
            1,
            legs,
            vec![[-0.015, -0.029], [0.069, -0.029], [0.069, 0.001], [0.015, 0.029], [-0.015, 0.029]],
            0.032,
        ),
    ]
}

/// Things that are none of the kinds: a cross, a half of a block, an angle that lies on its other side.
#[must_use]
pub fn strangers() -> Vec<Kind> {
    let block = |a: f64, b: f64, c: f64, d: f64, h: f64| Piece::Block {
        lower: Vector3::new(a, b, 0.0),
        upper: Vector3::new(c, d, h),
    };
    let cross = [block(-0.04, -0.014, 0.04, 0.014, 0.03), block(-0.014, -0.04, 0.014, 0.04, 0.03)];
    let turned_over =
        [block(-0.015, -0.001, 0.069, 0.029, 0.032), block(-0.015, -0.029, 0.015, -0.001, 0.032)];
    let angle = vec![[-0.015, -0.029], [0.015, -0.029], [0.069, -0.001], [0.069, 0.029], [-0.015, 0.029]];
    vec![
        Kind::new("cross", 4, cross, box_of(0.08, 0.08), 0.03),
        Kind::new("cube", 4, [block(-0.022, -0.027, 0.022, 0.027, 0.04)], box_of(0.044, 0.054), 0.04),
        Kind::new("angle, turned over", 1, turned_over, angle, 0.032),
    ]
}

fn box_of(x: f64, y: f64) -> Vec<[f64; 2]> {
    let (x, y) = (0.5 * x, 0.5 * y);
    vec![[-x, -y], [0.0, -y], [x, -y], [x, 0.0], [x, y], [0.0, y], [-x, y], [-x, 0.0]]
}

fn round(radius: f64) -> Vec<[f64; 2]> {
    let corner = |i: usize| (i as f64 * core::f64::consts::TAU / Body::SIDES as f64).sin_cos();
    (0..Body::SIDES).map(corner).map(|(sin, cos)| [radius * cos, radius * sin]).collect()
}

impl Kind {
    fn new(
        name: &'static str,
        turns: u32,
        pieces: impl IntoIterator<Item = Piece>,
        outline: Vec<[f64; 2]>,
        height: f64,
    ) -> Self {
        Self { class: PartClass { name, form: Form::new(pieces), turns }, outline, height, grip: 0.0 }
    }

    /// The convex outline of what the fingers touch, anticlockwise \[m, P\].
    #[must_use]
    pub fn outline(&self) -> &[[f64; 2]] {
        &self.outline
    }

    /// Its form and its body, `scale` times as large, and where P is in the body's frame B, whose axes are those of P.
    #[must_use]
    pub fn made(&self, scale: f64) -> (Form, Body, Vector3<f64>) {
        let (mass, centre, inertia) = masses(&self.class.form);
        let at = |point: &[f64; 2]| [(point[0] - centre.x) * scale, (point[1] - centre.y) * scale];
        let outline: Vec<_> = self.outline.iter().map(at).collect();
        let heights = [-centre.z * scale, (self.height - centre.z) * scale];
        let body = Body::prism(mass * scale.powi(3), inertia * scale.powi(5), &outline, heights);
        (self.class.form.scaled(scale), body, -centre * scale)
    }
}

/// Mass \[kg\], centre of mass \[m\] and inertia about it [kg m²] of a form that is solid below what is seen from above, by columns of 1 mm.
fn masses(form: &Form) -> (f64, Vector3<f64>, Matrix3<f64>) {
    const SIDE: f64 = 1e-3;
    let column = |i: i32, j: i32| {
        let (x, y) = ((f64::from(i) + 0.5) * SIDE, (f64::from(j) + 0.5) * SIDE);
        let hit = form.hit(&Vector3::new(x, y, 1.0), &-Vector3::z())?;
        Some((x, y, 1.0 - hit.distance))
    };
    let columns = (-80..80).flat_map(|i| (-80..80).filter_map(move |j| column(i, j)));
    let (mut mass, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
    for (x, y, height) in columns {
        let part = DENSITY * SIDE * SIDE * height;
        let middle = Vector3::new(x, y, 0.5 * height);
        mass += part;
        first += middle * part;
        second += middle * middle.transpose() * part;
        second +=
            Matrix3::from_diagonal(&Vector3::new(SIDE * SIDE, SIDE * SIDE, height * height)) * (part / 12.0);
    }
    let centre = first / mass;
    let second = second - centre * centre.transpose() * mass;
    (mass, centre, Matrix3::identity() * second.trace() - second)
}

/// The classes, as vision knows them.
#[must_use]
pub fn classes() -> Vec<PartClass> {
    kinds().into_iter().map(|kind| kind.class).collect()
}

/// How far the angle of a part is off, where it looks the same in so many attitudes \[rad\].
#[must_use]
pub fn turned(seen: f64, truly: f64, turns: u32) -> f64 {
    let period = core::f64::consts::TAU / f64::from(turns.max(1));
    let off = seen - truly;
    if turns == 0 { 0.0 } else { (off - period * (off / period).round()).abs() }
}

/// A pose on the belt: P at a place and an angle.
#[must_use]
pub fn lying(x: f64, y: f64, angle: f64) -> Pose {
    Pose::translation(x, y, 0.0) * Pose::rotation(Vector3::z() * angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_are_those_of_geometry() {
        let kinds = kinds();
        let (mass, centre, inertia) = masses(&kinds[0].class.form);
        assert!((mass - DENSITY * 0.07 * 0.054 * 0.04).abs() < 1e-9 && (centre.z - 0.02).abs() < 1e-9);
        assert!((inertia[(2, 2)] - mass * (0.07_f64.powi(2) + 0.054_f64.powi(2)) / 12.0).abs() < 1e-10);
        // A half disc: 4 r / 3 pi.
        let (_, centre, _) = masses(&kinds[5].class.form);
        assert!((centre.z - 4.0 * 0.037 / (3.0 * core::f64::consts::PI)).abs() < 1e-4, "{centre}");
        // The angle: by its two boxes.
        let (_, centre, _) = masses(&kinds[7].class.form);
        let x = (0.084 * 0.03 * 0.027) / (0.084 * 0.03 + 0.03 * 0.028);
        assert!((centre.x - x).abs() < 1e-6, "{centre}");
    }

    #[test]
    fn angles_are_compared_as_the_part_looks() {
        assert!(turned(3.1, -0.02, 2) < 0.022 && turned(3.1, 0.0, 1) > 3.0 && turned(1.0, 0.0, 0) == 0.0);
    }
}
