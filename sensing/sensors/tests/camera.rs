//! The simulated camera: where things appear, how bright, how sharp and how noisy.

use mrroc::pose::Pose;
use mrroc_sensors::camera::{Camera, Plane};
use mrroc_sensors::form::{Form, Piece};
use mrroc_sensors::physics::{Dark, Imager};
use mrroc_sensors::scene::{Scene, Solid};
use mrroc_sensors::view::{Seen, View};
use nalgebra::Vector3;

/// A plate on the belt, which moves, at the scene's time 1 s.
struct Plate {
    form: Form,
    speed: f64,
}

impl Scene for Plate {
    fn now(&self) -> f64 {
        1.0
    }

    fn each_solid(&self, _: &mut dyn FnMut(&Solid<'_>)) {}
}

impl View for Plate {
    fn each_form(&self, visit: &mut dyn FnMut(&Seen<'_>)) {
        visit(&Seen {
            form: &self.form,
            pose: Pose::identity(),
            velocity: Vector3::x() * self.speed,
            angular_velocity: Vector3::zeros(),
            reflectance: 0.8,
        });
    }

    fn surface(&self, before: f64) -> f64 {
        -self.speed * before
    }
}

fn plane() -> Plane {
    Plane::new(
        Camera::MRROCPP,
        Pose::translation(0.0, 0.0, 0.85) * Pose::rotation(Vector3::x() * core::f64::consts::PI),
    )
}

/// A plate of 60 x 40 mm, flat on the belt.
fn plate(speed: f64) -> Plate {
    let lower = Vector3::new(-0.03, -0.02, -0.001);
    Plate { form: Form::new([Piece::Block { lower, upper: Vector3::new(0.03, 0.02, 0.0) }]), speed }
}

fn image(imager: Imager, view: &Plate, time: f64) -> Vec<u8> {
    let (mut imager, mut image) = (imager, Vec::new());
    imager.expose(view, time, &mut image);
    image
}

/// Columns in which a row passes half of the brightness of the plate, by linear interpolation.
fn edges(image: &[u8], row: usize) -> [f64; 2] {
    let row = &image[row * 768..(row + 1) * 768];
    let bright = f64::from(row[384]);
    let dark = f64::from(row[100]);
    let half = 0.5 * (bright + dark);
    let passes = |i: &usize| (f64::from(row[*i]) > half) != (f64::from(row[i + 1]) > half);
    let at = |i: usize| i as f64 + (half - f64::from(row[i])) / (f64::from(row[i + 1]) - f64::from(row[i]));
    let (first, last) =
        ((0..767).find(passes).expect("an edge"), (0..767).rev().find(passes).expect("an edge"));
    [at(first), at(last)]
}

#[test]
fn edges_appear_where_the_model_projects_them_to_a_fraction_of_a_pixel() {
    let plane = plane();
    let rows = [260, 287, 320];
    let image = image(Imager::over(plane.clone(), 3), &plate(0.0), 1.0);
    for row in rows {
        let [left, right] = edges(&image, row);
        // The point of the edge that appears in this row, by bisection along it.
        let expected = |x: f64| {
            let (mut a, mut b) = (-0.02, 0.02);
            for _ in 0..50 {
                let middle = 0.5 * (a + b);
                let at = plane.project(&Vector3::new(x, middle, 0.0)).expect("ahead");
                if at.y > row as f64 { a = middle } else { b = middle }
            }
            plane.project(&Vector3::new(x, a, 0.0)).expect("ahead").x
        };
        let off = [left - expected(-0.03), right - expected(0.03)];
        assert!(off.iter().all(|off| off.abs() < 0.3), "row {row}: {off:?} pixels");
    }
}

#[test]
fn what_moves_is_seen_where_it_was_and_blurred_by_its_motion_during_the_exposure() {
    let plane = plane();
    let still = image(Imager::over(plane.clone(), 3), &plate(0.0), 1.0);
    // 10 ms ago, at 0.2 m/s: 2 mm behind, which are 1871.2 / 850 pixels each.
    let moved = image(Imager::over(plane.clone(), 3), &plate(0.2), 0.99);
    let shift = edges(&still, 287)[0] - edges(&moved, 287)[0];
    assert!((shift - 2.0 * 1871.2 / 850.0).abs() < 0.3, "{shift} pixels");
    // A ramp as long as the displacement during 40 ms.
    let long = Imager::over(plane, 3).with_exposure(0.04);
    let blurred = image(long, &plate(0.2), 1.0);
    let row = &blurred[287 * 768..288 * 768];
    let (dark, bright) = (f64::from(row[100]), f64::from(row[384]));
    let between = row[..384].iter().filter(|&&grey| {
        let share = (f64::from(grey) - dark) / (bright - dark);
        share > 0.1 && share < 0.9
    });
    let expected = 8.0 * 1871.2 / 850.0;
    let count = between.count() as f64;
    assert!(count > 0.6 * expected && count < 1.1 * expected, "{count} pixels, a ramp of {expected}");
}

#[test]
fn odd_rows_of_an_interlaced_image_are_those_of_twenty_milliseconds_later() {
    let image = image(Imager::over(plane(), 3).interlaced(), &plate(0.1), 1.0);
    let comb = edges(&image, 287)[0] - edges(&image, 288)[0];
    // 0.1 m/s for 20 ms.
    assert!((comb - 2.0 * 1871.2 / 850.0).abs() < 0.3, "{comb} pixels");
}

#[test]
fn noise_is_that_of_electrons_and_a_dark_camera_sees_next_to_nothing() {
    let (first, second) = {
        let mut imager = Imager::over(plane(), 3);
        let (mut first, mut second) = (Vec::new(), Vec::new());
        imager.expose(&plate(0.0), 1.0, &mut first);
        imager.expose(&plate(0.0), 1.0, &mut second);
        (first, second)
    };
    // In the middle of the plate; two images differ by noise alone (EMVA 1288): twice (shot + read + quantisation).
    let inside = (250..320).flat_map(|row| (350..420).map(move |column| row * 768 + column));
    let (mut count, mut mean, mut square) = (0.0, 0.0, 0.0);
    for index in inside {
        let (a, b) = (f64::from(first[index]), f64::from(second[index]));
        count += 1.0;
        mean += 0.5 * (a + b);
        square += (a - b) * (a - b);
    }
    let (mean, variance) = (mean / count, square / count / 2.0);
    let gain = 255.0 / 10_000.0;
    let expected = gain * gain * (mean / gain + 144.0) + 1.0 / 12.0;
    assert!((variance / expected - 1.0).abs() < 0.08, "variance {variance}, by electrons {expected}");
    let mut imager = Imager::over(plane(), 3);
    imager.darken(0.0, Dark::Covered);
    let dark = image(imager, &plate(0.0), 1.0);
    assert!(dark.iter().all(|grey| *grey <= 3));
}
