//! Bars that stand on a floor, by images of them.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use mrroc_sensors::aggregation::{Bars, BarsKnown, NoBars};
use mrroc_sensors::camera::{Camera, Lens, Plane};
use mrroc_sensors::form::{Form, Piece};
use mrroc_sensors::physics::Imager;
use mrroc_sensors::scene::{Scene, Solid};
use mrroc_sensors::view::{Seen, View};
use nalgebra::{Translation3, UnitQuaternion, Vector2, Vector3};

const KNOWN: BarsKnown =
    BarsKnown { sides: [0.1, 0.075], thickness: 2e-3, height: 0.012, loose: 4e-3, cell: 4e-4 };

/// Bars at `X_FM`, as lower left and upper right corners.
struct Standing {
    bars: Vec<([Vector2<f64>; 2], Form)>,
    pose: Pose,
}

impl Standing {
    fn new(bars: &[[f64; 4]], pose: Pose) -> Self {
        let form = |[x0, y0, x1, y1]: [f64; 4]| {
            let (lower, upper) = (Vector3::new(x0, y0, 0.0), Vector3::new(x1, y1, KNOWN.height));
            ([lower.xy(), upper.xy()], Form::new([Piece::Block { lower, upper }]))
        };
        Self { bars: bars.iter().map(|bar| form(*bar)).collect(), pose }
    }
}

impl Scene for Standing {
    fn now(&self) -> f64 {
        0.0
    }

    fn each_solid(&self, _: &mut dyn FnMut(&Solid<'_>)) {}
}

impl View for Standing {
    fn each_form(&self, visit: &mut dyn FnMut(&Seen<'_>)) {
        for (_, form) in &self.bars {
            let (velocity, angular_velocity) = (Vector3::zeros(), Vector3::zeros());
            visit(&Seen { form, pose: self.pose, velocity, angular_velocity, reflectance: 0.8 });
        }
    }

    fn surface(&self, _: f64) -> f64 {
        0.0
    }
}

/// 0.6 m over the floor, not over the middle: 2.4 pixels in a millimetre.
fn camera() -> Plane {
    let lens = Lens { radial: [-0.1, 0.03, 0.0], tangential: [5e-4, -3e-4] };
    let camera = Camera { size: [380, 340], focal: [1411.0, 1413.0], centre: [188.0, 171.0], lens };
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    Plane::new(camera, Pose::from_parts(Translation3::new(0.01, -0.006, 0.6), down))
}

/// The frame of a maze of 4 by 3 cells, in pieces of which none lies in another.
const FRAME: [[f64; 4]; 4] = [
    [-0.001, -0.001, 0.101, 0.001],
    [-0.001, 0.074, 0.101, 0.076],
    [-0.001, 0.001, 0.001, 0.074],
    [0.099, 0.001, 0.101, 0.074],
];

fn at(x: f64, y: f64, turn: f64) -> Pose {
    Pose::from_parts(
        Translation3::new(x - 0.05, y - 0.0375, 0.0),
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn),
    )
}

fn look(bars: &[[f64; 4]], truly: Pose) -> Result<Bars, NoBars> {
    let camera = camera();
    let mut image = Vec::new();
    Imager::over(camera.clone(), 7).expose(&Standing::new(bars, truly), 0.0, &mut image);
    Bars::find(&camera, &image, &at(0.0, 0.0, 0.0), &KNOWN)
}

#[test]
fn bars_and_posts_are_found_where_they_stand() {
    // Two walls that end free, one at the frame, and a post.
    let inner = [
        [0.024, 0.024, 0.051, 0.026],
        [0.074, 0.024, 0.076, 0.051],
        [0.024, 0.049, 0.026, 0.074],
        [0.049, 0.049, 0.051, 0.051],
    ];
    let bars = [&FRAME[..], &inner[..]].concat();
    for truly in [at(0.0, 0.0, 0.0), at(2.5e-3, -1.5e-3, 0.015), at(-1e-3, 2e-3, -0.017)] {
        let found = look(&bars, truly).expect("seen");
        let off = truly.inv_mul(&found.X_FM);
        assert!(off.translation.vector.norm() < 1e-4 && off.rotation.angle() < 1e-3, "{off}");
        assert_eq!(found.boxes.len(), bars.len(), "{:?}", found.boxes);
        for &[x0, y0, x1, y1] in &bars {
            let wall = [Vector2::new(x0, y0), Vector2::new(x1, y1)];
            // Walls that end at another one end where that does.
            let miss = |seen: &[Vector2<f64>; 2]| {
                let axis = usize::from(x1 - x0 < y1 - y0);
                let across = (seen[0] - wall[0])[1 - axis].abs().max((seen[1] - wall[1])[1 - axis].abs());
                let (low, high) = (seen[0][axis] - wall[0][axis], seen[1][axis] - wall[1][axis]);
                // The frame's upright pieces begin behind its level ones, but are seen as going through them.
                let ends = |off: f64| off.abs().min((off.abs() - 2e-3).abs());
                across.max(ends(low)).max(ends(high))
            };
            let nearest = found.boxes.iter().map(miss).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1.5e-4, "{wall:?}: {nearest} m, {:?}", found.boxes);
        }
    }
}

#[test]
fn a_frame_without_a_side_and_an_empty_floor_are_named() {
    let error = look(&FRAME[..3], at(0.0, 0.0, 0.0)).expect_err("no right side");
    assert_eq!(error, NoBars::NoFrame { side: "right" });
    assert!(matches!(look(&[], at(0.0, 0.0, 0.0)), Err(NoBars::Dark { .. })));
}
