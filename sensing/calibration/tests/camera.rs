//! Cameras from chessboards: as OpenCV finds them from the same corners (`tests/reference/chessboard.py`), and from images that the simulated camera of
//! `mrroc-sensors` makes, of which the truth is known.

use mrroc::pose::Pose;
use mrroc_calibration::photo::Photo;
use mrroc_calibration::{
    Eye, Held, Intrinsics, NoFit, Seen as SeenBy, board_in_camera, camera_of, eye, intrinsics, square_seen,
};
use mrroc_sensors::aggregation::{Board, Grey, NoBoard, Pattern};
use mrroc_sensors::camera::{Camera, Lens, Plane};
use mrroc_sensors::form::{Form, Piece};
use mrroc_sensors::physics::Imager;
use mrroc_sensors::scene::{Scene, Solid};
use mrroc_sensors::view::{Seen, View};
use nalgebra::{Point3, Vector2, Vector3};

const BOARD: Board = Board { corners: [9, 6], square: 0.025 };

/// What OpenCV finds: fx, fy, cx, cy, k1, k2, p1, p2, k3, and their standard deviations.
fn opencv() -> (f64, Vec<f64>, Vec<f64>) {
    let value: serde_json::Value =
        serde_json::from_str(include_str!("reference/chessboard.json")).expect("JSON");
    let list = |key: &str| -> Vec<f64> {
        value[key].as_array().expect("a list").iter().filter_map(serde_json::Value::as_f64).collect()
    };
    (value["rms"].as_f64().expect("rms"), list("values"), list("sigmas"))
}

fn values(found: &Intrinsics) -> [f64; 9] {
    let Camera { focal: [fx, fy], centre: [cx, cy], lens, .. } = found.camera;
    let Lens { radial: [k1, k2, k3], tangential: [p1, p2] } = lens;
    [fx, fy, cx, cy, k1, k2, p1, p2, k3]
}

#[test]
fn intrinsics_from_opencvs_corners_of_real_photos_are_opencvs() {
    let text = include_str!("reference/chessboard.csv");
    let rows = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let corner = |row: Vec<&str>| Vector2::new(row[2].parse().expect("u"), row[3].parse().expect("v"));
    let corners: Vec<Vector2<f64>> = rows.map(corner).collect();
    let seen: Vec<Vec<Vector2<f64>>> = corners.chunks(54).map(<[_]>::to_vec).collect();
    assert_eq!(seen.len(), 13);
    let found = intrinsics([640, 480], &BOARD, &seen).expect("a camera");
    let (rms, expected, sigmas) = opencv();
    assert!((rms - 0.41).abs() < 0.005 && (found.rms - rms).abs() < 1e-5, "{} {rms}", found.rms);
    for (i, own) in values(&found).into_iter().enumerate() {
        assert!((own - expected[i]).abs() < 0.01 * sigmas[i], "{i}: {own}, OpenCV's {}", expected[i]);
        // OpenCV divides by numbers less parameters, this crate the same.
        assert!((found.sigma[i] / sigmas[i] - 1.0).abs() < 0.02, "{i}: {} {}", found.sigma[i], sigmas[i]);
    }
    // Photos of one name from two folders, and names with characters that TOML and Rust quote differently.
    let names = ["a.png", "a.png", "zero\u{200b}width.png", "tab\t \"quoted\" \\.png"].map(String::from);
    let text = found.text(&names, &BOARD, "2026-11-24");
    assert_eq!(camera_of(&text), Ok(found.camera));
    let table = toml::de::DeTable::parse(&text).expect("TOML");
    let toml::de::DeValue::Array(photos) = table.get_ref()["left"].get_ref()["photos"].get_ref() else {
        panic!("no photos in {text}")
    };
    for (photo, name) in photos.iter().zip(&names) {
        assert_eq!(photo.get_ref()[0].get_ref().as_str(), Some(name.as_str()));
    }
    assert_eq!(photos.len(), names.len());
}

/// A chessboard over the belt, seen from above: z of the board points down.
struct Chessboard {
    squares: Vec<(Form, f64)>,
    pose: Pose,
}

impl Chessboard {
    fn new(board: &Board, pose: Pose) -> Self {
        let side = board.square;
        let piece = |i: f64, j: f64, w: f64, h: f64| {
            let lower = Vector3::new(i * side, j * side, 0.0);
            Form::new([Piece::Block { lower, upper: lower + Vector3::new(w * side, h * side, 0.001) }])
        };
        let [across, down] = board.corners.map(|n| n as i32 + 1);
        let mut squares = Vec::new();
        for i in 0..across {
            for j in 0..down {
                let shade = if (i + j) % 2 == 0 { 0.06 } else { 0.85 };
                squares.push((piece(f64::from(i - 1), f64::from(j - 1), 1.0, 1.0), shade));
            }
        }
        let (across, down) = (f64::from(across), f64::from(down));
        for (i, j, w, h) in [
            (-2.0, -2.0, across + 2.0, 1.0),
            (-2.0, down - 1.0, across + 2.0, 1.0),
            (-2.0, -1.0, 1.0, down),
            (across - 1.0, -1.0, 1.0, down),
        ] {
            squares.push((piece(i, j, w, h), 0.85));
        }
        Self { squares, pose }
    }
}

impl Scene for Chessboard {
    fn now(&self) -> f64 {
        1.0
    }

    fn each_solid(&self, _: &mut dyn FnMut(&Solid<'_>)) {}
}

impl View for Chessboard {
    fn each_form(&self, visit: &mut dyn FnMut(&Seen<'_>)) {
        for (form, reflectance) in &self.squares {
            visit(&Seen {
                form,
                pose: self.pose,
                velocity: Vector3::zeros(),
                angular_velocity: Vector3::zeros(),
                reflectance: *reflectance,
            });
        }
    }

    fn surface(&self, _: f64) -> f64 {
        0.0
    }
}

/// A camera whose lens bends as much as that of the photos.
const CAMERA: Camera = Camera {
    size: [640, 480],
    focal: [560.0, 557.0],
    centre: [330.0, 236.0],
    lens: Lens { radial: [-0.24, 0.1, 0.0], tangential: [0.001, -0.0005] },
};

/// Looks down from 0.45 m.
fn over_the_belt() -> Pose {
    Pose::translation(0.0, 0.0, 0.45) * Pose::rotation(Vector3::x() * core::f64::consts::PI)
}

/// Where the board is in the camera, with its middle at a place \[m\], turned by a rotation vector.
fn held(at: [f64; 3], turn: [f64; 3]) -> Pose {
    let middle = Pose::translation(0.1, 0.0625, 0.0);
    Pose::new(Vector3::from(at), Vector3::from(turn)) * middle.inverse()
}

fn photo(plane: &Plane, board: &Board, in_camera: &Pose, seed: u64) -> Vec<u8> {
    let mut image = Vec::new();
    let view = Chessboard::new(board, plane.X_FC * in_camera);
    Imager::over(plane.clone(), seed).expose(&view, 1.0, &mut image);
    image
}

fn held_in_many_poses() -> Vec<Pose> {
    vec![
        held([0.0, 0.0, 0.36], [0.0, 0.0, 0.0]),
        held([0.02, 0.01, 0.34], [0.5, 0.0, 0.1]),
        held([0.0, 0.02, 0.36], [0.1, 0.6, 0.0]),
        held([0.03, -0.02, 0.36], [0.0, -0.6, 3.0]),
        held([0.01, 0.0, 0.38], [0.4, 0.4, 1.5]),
        held([0.05, 0.04, 0.37], [-0.3, -0.5, -0.4]),
    ]
}

#[test]
fn a_camera_is_found_from_its_own_noisy_images() {
    let plane = Plane::new(CAMERA, over_the_belt());
    let mut seen = Vec::new();
    let (mut squares, mut count) = (0.0, 0.0);
    for (i, pose) in held_in_many_poses().iter().enumerate() {
        let image = photo(&plane, &BOARD, pose, 7 + i as u64);
        let corners = BOARD.seen(&Grey::new(640, 480, &image).expect("an image"));
        let corners = corners.unwrap_or_else(|why| panic!("photo {i}: {why}"));
        for (corner, point) in corners.iter().zip(BOARD.points()) {
            // In the board's own order: it has ends.
            let truth = CAMERA.project(&(pose * Point3::from(point)).coords).expect("ahead");
            let off = (corner - truth).norm();
            assert!(off < 0.3, "photo {i}: {off} px");
            squares += off * off;
            count += 1.0;
        }
        seen.push(corners);
    }
    let rms = f64::sqrt(squares / count);
    assert!(rms < 0.08, "{rms} px");
    let found = intrinsics(CAMERA.size, &BOARD, &seen).expect("a camera");
    assert!(found.unseen.is_empty(), "{:?}", found.unseen);
    let truth = [560.0, 557.0, 330.0, 236.0, -0.24, 0.1, 0.001, -0.0005, 0.0];
    for (i, (own, truth)) in values(&found).into_iter().zip(truth).enumerate() {
        assert!(
            (own - truth).abs() < 4.0 * found.sigma[i],
            "{i}: {own} +- {}, truly {truth}",
            found.sigma[i]
        );
    }
    assert!(found.sigma[0] < 1.0 && found.rms < 0.12, "{found}");
}

#[test]
fn a_board_that_leaves_the_image_or_has_other_corners_is_told() {
    let plane = Plane::new(CAMERA, over_the_belt());
    let told = |board: &Board, pose: &Pose| {
        let image = photo(&plane, &BOARD, pose, 3);
        board.seen(&Grey::new(640, 480, &image).expect("an image"))
    };
    let middle = held([0.0, 0.0, 0.36], [0.2, 0.0, 0.1]);
    let larger = Board { corners: [10, 6], ..BOARD };
    assert_eq!(told(&larger, &middle), Err(NoBoard::Other { found: 54, across: 9, down: 6, wanted: 60 }));
    let beside = held([0.16, 0.0, 0.36], [0.0, 0.0, 0.0]);
    assert!(matches!(told(&BOARD, &beside), Err(NoBoard::Other { found: 10..=48, .. })));
    let away = held([0.9, 0.0, 0.36], [0.0, 0.0, 0.0]);
    assert_eq!(told(&BOARD, &away), Err(NoBoard::Nothing));
}

#[test]
fn photos_of_a_board_that_is_never_tilted_do_not_tell_the_focal_length() {
    let seen: Vec<Vec<Vector2<f64>>> = [0.3, 0.35, 0.4]
        .into_iter()
        .map(|far| {
            let pose = held([0.0, 0.0, far], [0.0, 0.0, far]);
            let simple = Camera { lens: Lens::default(), ..CAMERA };
            let pixel =
                |point: Vector3<f64>| simple.project(&(pose * Point3::from(point)).coords).expect("ahead");
            BOARD.points().map(pixel).collect()
        })
        .collect();
    let told = match intrinsics(CAMERA.size, &BOARD, &seen) {
        Ok(found) => found.unseen.join("; "),
        Err(why) => why.to_string(),
    };
    assert!(told.contains("camera f"), "{told}");
}

/// `tests/reference/charuco.py`: a board that OpenCV has drawn, and where its corners truly are.
#[test]
fn corners_of_a_charuco_board_are_seen_in_opencvs_order_though_markers_are_hidden() {
    let photo = Photo::parse(include_bytes!("reference/charuco.png")).expect("a photo");
    let truth: Vec<Vector2<f64>> = include_str!("reference/charuco.csv")
        .lines()
        .skip(1)
        .filter_map(|row| row.split_once(','))
        .map(|(u, v)| Vector2::new(u.parse().expect("u"), v.parse().expect("v")))
        .collect();
    let board = Pattern::parse("charuco:8x6:30mm:22mm:DICT_5X5_100").expect("a board");
    assert_eq!((board.points().len(), truth.len(), board.has_ends()), (35, 35, true));
    let off = |grey: &[u8]| {
        let seen = board.seen(&Grey::new(photo.size[0], photo.size[1], grey).expect("an image"));
        let seen = seen.unwrap_or_else(|why| panic!("{why}"));
        seen.iter().zip(&truth).map(|(own, truth)| (own - truth).norm()).fold(0.0, f64::max)
    };
    assert!(off(&photo.grey) < 0.2, "{}", off(&photo.grey));
    // A finger on the marker between the first four corners, which it does not touch.
    let mut hidden = photo.grey.clone();
    let middle = (truth[0] + truth[1] + truth[7] + truth[8]) / 4.0;
    for (i, grey) in hidden.iter_mut().enumerate() {
        let at = Vector2::new((i % photo.size[0]) as f64, (i / photo.size[0]) as f64);
        if (at - middle).norm() < 8.0 {
            *grey = 128;
        }
    }
    assert!(hidden != photo.grey && off(&hidden) < 0.2, "{}", off(&hidden));
    let other = Pattern::parse("charuco:8x6:30mm:22mm:DICT_4X4_50").expect("a board");
    let seen = other.seen(&Grey::new(photo.size[0], photo.size[1], &photo.grey).expect("an image"));
    assert!(matches!(seen, Err(NoBoard::Markers { wanted: 24, .. })), "{seen:?}");
    for wrong in [
        "charuco:8x6:30mm:22mm",
        "charuco:8x6:22mm:30mm:DICT_5X5_100",
        "charuco:8x6:30mm:22mm:DICT_5X6_100",
        "circles:7x6",
    ] {
        assert!(Pattern::parse(wrong).is_err(), "{wrong}");
    }
}

/// `tests/reference/tilted.py`: OpenCV's corners of rendered photos of a camera with 1000 pixels of focal length, by the board's tilt in degrees.
fn tilted(by: &str) -> Vec<Vec<Vector2<f64>>> {
    let rows = include_str!("reference/tilted.csv").lines().skip(1).map(|line| line.split(',').collect());
    let rows = rows.filter(|row: &Vec<&str>| row[0] == by);
    let corners: Vec<Vector2<f64>> =
        rows.map(|row| Vector2::new(row[2].parse().expect("u"), row[3].parse().expect("v"))).collect();
    corners.chunks(54).map(<[_]>::to_vec).collect()
}

#[test]
fn photos_that_hardly_tell_the_focal_length_are_told_by_what_they_leave_unknown() {
    let size = [1280, 960];
    let told = intrinsics(size, &BOARD, &tilted("30")).expect("a camera");
    assert!(told.is_known(), "{:?}", told.unsure);
    let [fx, fy] = told.camera.focal;
    assert!((fx - 1000.0).abs() < 1.0 && (fy - 1000.0).abs() < 1.0, "{told}");
    for by in ["0", "2"] {
        match intrinsics(size, &BOARD, &tilted(by)) {
            Ok(found) => {
                assert!(!found.is_known(), "{by} degrees: {found}");
                let unsure = found.unseen.iter().chain(&found.unsure);
                assert!(unsure.into_iter().any(|one| one.contains("fx")), "{by} degrees: {found:?}");
            }
            // No minimum: nothing in these photos tells one focal length from another.
            Err(why) => assert!(matches!(why, NoFit::NoMinimum(_)), "{by} degrees: {why}"),
        }
        let advice = Held::of(size, &BOARD, &tilted(by)).to_string();
        assert!(advice.contains("tilt the board by about 30 degrees"), "{advice}");
    }
}

/// A camera on a hand, and one beside the arm that looks at a board on the hand.
#[test]
fn a_camera_on_the_hand_or_beside_the_arm_is_found_from_pixels() {
    let in_camera = held_in_many_poses();
    let eye_pose = Pose::new(Vector3::new(0.06, -0.02, 0.05), Vector3::new(0.1, 0.0, 1.5));
    let board_pose = Pose::new(Vector3::new(0.5, 0.1, 0.02), Vector3::new(0.0, 0.1, 2.0));
    let pixels = |pose: &Pose| -> Vec<Vector2<f64>> {
        BOARD.points().map(|p| CAMERA.project(&(pose * Point3::from(p)).coords).expect("ahead")).collect()
    };
    for mounted in [Eye::OnFlange, Eye::Fixed] {
        let seen: Vec<SeenBy> = in_camera
            .iter()
            .map(|pose| {
                // Of the camera on the flange F: X_WF X_FC X_CB = X_WB; of a fixed one: X_WC X_CB = X_WF X_FB.
                let flange = match mounted {
                    Eye::OnFlange => board_pose * pose.inverse() * eye_pose.inverse(),
                    Eye::Fixed => eye_pose * pose * board_pose.inverse(),
                };
                SeenBy { flange, corners: pixels(pose) }
            })
            .collect();
        let found = eye(&CAMERA, &BOARD, mounted, &seen).expect("a camera");
        let off = eye_pose.inv_mul(&found.frame);
        assert!(off.translation.vector.norm() < 1e-7 && off.rotation.angle() < 1e-7, "{mounted:?} {off}");
        assert!(found.unseen.is_empty() && found.pixels < Some(1e-6), "{found:?}");
        // A board that was printed at 96 % is found, and its true size.
        assert_eq!(square_seen(&CAMERA, &BOARD, mounted, &seen), Ok(None));
        let believed = Board { square: 0.026, ..BOARD };
        let square = square_seen(&CAMERA, &believed, mounted, &seen).expect("a size").expect("another one");
        assert!((square - 0.025).abs() < 2e-6, "{mounted:?} {square}");
        // Of poses that are those of something else the board is not accused.
        let other = if mounted == Eye::Fixed { Eye::OnFlange } else { Eye::Fixed };
        assert_eq!(square_seen(&CAMERA, &BOARD, other, &seen), Ok(None));
    }
    let in_camera = in_camera[3];
    let back = board_in_camera(&CAMERA, &BOARD, &pixels(&in_camera)).expect("a pose").inv_mul(&in_camera);
    assert!(back.translation.vector.norm() < 1e-9 && back.rotation.angle() < 1e-9, "{back}");
}
