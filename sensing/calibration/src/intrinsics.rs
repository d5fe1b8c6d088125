//! What a camera is: focal lengths, centre and distortion, from photos of a chessboard or a grid of circles in several positions.
//!
//! The start is that of Zhang (*A flexible new technique for camera calibration*, 2000): each photo of a plane is a homography, and the axes of the plane are
//! perpendicular and of one length. Then everything is one problem, with [`Pixels`] as the device and each photo's board as a target.

use core::fmt;

use mrroc::pose::Pose;
use mrroc_sensors::aggregation::Pattern;
use mrroc_sensors::camera::{Camera, Lens};
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, UnitQuaternion, Vector2, Vector3};
use toml::de::{DeTable, DeValue};

use crate::file::quoted;
use crate::fit::NoFit;
use crate::known::{LENS, SEEING_PIXELS};
use crate::least_squares::Settings;
use crate::pixels::{List, Pixels, names, numbers};
use crate::problem::{Freedom, Noise, Problem};

/// What was found of a camera.
#[derive(Clone, Debug)]
pub struct Intrinsics {
    /// The camera.
    pub camera: Camera,
    /// The standard deviations of fx, fy, cx, cy \[pixel\], k1, k2, p1, p2, k3.
    pub sigma: [f64; 9],
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// By photo, where the board is in the camera.
    pub boards: Vec<Pose>,
    /// By photo, the root mean square of what is left of its corners \[pixel\].
    pub left: Vec<f64>,
    /// The same of all.
    pub rms: f64,
    /// What these photos do not tell, by name.
    pub unseen: Vec<String>,
    /// What they tell too badly, by name, with how well: more than [`LENS`] of a focal length.
    pub unsure: Vec<String>,
    /// How well the lens is known at the image's corners \[pixel\], if the board was never near them and it is no better than that.
    pub beside: Option<f64>,
}

/// The camera that saw a board like this: `seen` are its corners in each photo \[pixel\], in the order of [`Pattern::points`].
///
/// # Errors
/// [`NoFit`]: [`NoFit::Empty`] without photos, or of corners that are no picture of a board.
pub fn intrinsics(
    size: [usize; 2],
    board: impl Into<Pattern>,
    seen: &[Vec<Vector2<f64>>],
) -> Result<Intrinsics, NoFit> {
    let points = board.into().points();
    let planes: Vec<Matrix3<f64>> = seen.iter().filter_map(|corners| homography(&points, corners)).collect();
    if planes.len() < seen.len() {
        return Err(NoFit::Empty);
    }
    let centre = size.map(|pixels| 0.5 * (pixels as f64 - 1.0));
    let wide = size[0].max(size[1]) as f64;
    // Boards that are hardly tilted say nothing of the focal length: then usual ones are tried.
    let usual = [0.8, 1.5, 3.0].map(|share| [share * wide; 2]);
    let mut why = NoFit::Empty;
    let mut best: Option<Intrinsics> = None;
    for focal in zhang(&planes, centre).into_iter().chain(usual) {
        let about = Camera { size, focal, centre, lens: Lens::default() };
        match fitted(&about, &points, &planes, seen) {
            Ok(found) if found.is_known() => return Ok(found),
            // A minimum that says little may be one of several: another start may lead to a lower one.
            Ok(found) if best.as_ref().is_none_or(|best| found.rms < best.rms) => best = Some(found),
            Ok(_) => {}
            Err(no) => why = no,
        }
    }
    best.ok_or(why)
}

/// A board is tilted enough from one photo to another \[rad\], and large enough as a share of the image's longer side.
const ENOUGH_TILT: f64 = 0.6;
const ENOUGH_SHARE: f64 = 0.5;

/// From so little tilt on a board that is not quite flat tells another focal length \[rad\].
const LITTLE_TILT: f64 = 0.35;

/// How boards were held before a camera of which nothing is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// By how much one photo's board is tilted against that of another, at most \[rad\]; as a camera with a usual lens would see it.
    pub tilt: f64,
    /// How much of the image's longer side the largest board covers, 0 to 1.
    pub share: f64,
    /// Photos.
    pub photos: usize,
}

impl Held {
    /// Of corners in photos, as [`intrinsics`] takes them.
    #[must_use]
    pub fn of(size: [usize; 2], board: impl Into<Pattern>, seen: &[Vec<Vector2<f64>>]) -> Self {
        let points = board.into().points();
        let wide = size[0].max(size[1]) as f64;
        let centre = size.map(|pixels| 0.5 * (pixels as f64 - 1.0));
        let usual = Camera { size, focal: [wide; 2], centre, lens: Lens::default() };
        let rays = |corners: &Vec<Vector2<f64>>| -> Vec<Vector2<f64>> {
            corners.iter().map(|pixel| usual.ray(pixel, None)).collect()
        };
        let pose = |corners| in_camera(&homography(&points, &rays(corners))?);
        let normals: Vec<Vector3<f64>> =
            seen.iter().filter_map(pose).map(|pose| pose.rotation * Vector3::z()).collect();
        let of = |normal: &Vector3<f64>| normals.iter().map(|other| normal.angle(other)).fold(0.0, f64::max);
        let extent = |corners: &Vec<Vector2<f64>>| {
            let along = |axis: usize| {
                let all = || corners.iter().map(|corner| corner[axis]);
                all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
            };
            along(0).max(along(1))
        };
        Self {
            tilt: normals.iter().map(of).fold(0.0, f64::max),
            share: seen.iter().map(extent).fold(0.0, f64::max) / wide,
            photos: seen.len(),
        }
    }
}

impl Held {
    /// A note on photos that tell all, though not reliably.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        (self.tilt < LITTLE_TILT).then(|| {
            format!(
                "note: from one photo to another the board is tilted by {:.0} degrees at most: if it is not quite flat, the focal length is off by more than is said; tilt it by about \
                 30 degrees to all sides",
                self.tilt.to_degrees()
            )
        })
    }
}

impl fmt::Display for Held {
    /// What a photographer should do otherwise.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut advice = Vec::new();
        if self.tilt < ENOUGH_TILT || self.share >= ENOUGH_SHARE {
            advice.push(format!(
                "tilt the board by about 30 degrees, in some photos to the left, in some to the right, up and down (from one of these photos to another it is tilted by {:.0} \
                 degrees at most)",
                self.tilt.to_degrees()
            ));
        }
        if self.share < ENOUGH_SHARE {
            let percent = 100.0 * self.share;
            advice.push(format!(
                "bring it nearer, so that it fills most of the image (it covers {percent:.0} % of the image's longer side at most)"
            ));
        }
        if self.photos < 10 {
            advice.push(format!("take ten photos or more (these are {})", self.photos));
        }
        f.write_str(&advice.join("; "))
    }
}

/// Where a board is in a camera that is known, from its corners in one photo \[pixel\]; `None` if they are no picture of it.
#[must_use]
pub fn board_in_camera(camera: &Camera, board: impl Into<Pattern>, corners: &[Vector2<f64>]) -> Option<Pose> {
    let points = board.into().points();
    let rays: Vec<Vector2<f64>> = corners.iter().map(|pixel| camera.ray(pixel, None)).collect();
    in_camera(&homography(&points, &rays)?)
}

fn fitted(
    about: &Camera,
    points: &[Vector3<f64>],
    planes: &[Matrix3<f64>],
    seen: &[Vec<Vector2<f64>>],
) -> Result<Intrinsics, NoFit> {
    let device = Pixels::unknown(*about, points.iter().copied());
    let mut problem = Problem::new();
    let noise = Noise::Unknown(vec![0.5; 2 * points.len()]);
    let camera = problem.instrument("camera", device.clone(), None, Pose::identity(), Freedom::FIXED, noise);
    let [fx, fy] = about.focal;
    let [cx, cy] = about.centre;
    let into = Matrix3::new(1.0 / fx, 0.0, -cx / fx, 0.0, 1.0 / fy, -cy / fy, 0.0, 0.0, 1.0);
    let mut boards = Vec::new();
    for (i, (corners, plane)) in seen.iter().zip(planes).enumerate() {
        let start = in_camera(&(into * plane)).ok_or(NoFit::Empty)?;
        let board = problem.target(&format!("board {}", i + 1), None, start, Freedom::FRAME);
        let read: Vec<f64> = corners.iter().flat_map(|pixel| [pixel.x, pixel.y]).collect();
        problem.measure(camera, board, &[], &read);
        boards.push(problem.frame_of(board));
    }
    let fit = problem.fit(&Settings::default())?;
    let left: Vec<f64> = fit.residuals().map(|(_, _, raw)| rms(raw)).collect();
    let mean = left.iter().map(|one| one * one).sum::<f64>() / left.len().max(1) as f64;
    let columns: Vec<usize> = fit
        .found()
        .enumerate()
        .filter(|(_, one)| one.parameter.name.starts_with("camera "))
        .map(|(i, _)| i)
        .collect();
    let covariance =
        DMatrix::from_fn(columns.len(), columns.len(), |i, j| fit.covariance()[(columns[i], columns[j])]);
    let sigma: [f64; 9] = core::array::from_fn(|i| fit.constant_sigma(camera, i).unwrap_or(f64::INFINITY));
    let found = device.camera(fit.constants(camera));
    // Corners may by accident fit better than anybody sees them.
    let noise = fit.noise(camera).first().copied().unwrap_or(0.0);
    let floor = (SEEING_PIXELS / noise.max(f64::MIN_POSITIVE)).max(1.0);
    let sure =
        Sure { camera: &found, sigma: sigma.map(|sigma| floor * sigma), covariance: &covariance, floor };
    let (unsure, beside) = (sure.unsure(seen), sure.beside());
    Ok(Intrinsics {
        camera: found,
        unsure,
        beside,
        sigma,
        covariance,
        boards: boards.into_iter().map(|frame| fit.frame(frame)).collect(),
        left,
        rms: mean.sqrt(),
        unseen: fit.unseen().iter().map(ToString::to_string).collect(),
    })
}

/// How well a camera is known.
struct Sure<'c> {
    camera: &'c Camera,
    sigma: [f64; 9],
    covariance: &'c DMatrix<f64>,
    floor: f64,
}

impl Sure<'_> {
    fn unsure(&self, seen: &[Vec<Vector2<f64>>]) -> Vec<String> {
        let [fx, fy] = self.camera.focal;
        let mut unsure = Vec::new();
        let names = ["fx", "fy", "cx", "cy"];
        for ((name, sigma), focal) in names.into_iter().zip(self.sigma).zip([fx, fy, fx, fy]) {
            let most = LENS * focal.abs();
            let is_sure = sigma <= most;
            if !is_sure {
                unsure.push(format!("{name} is known to {sigma:.0} px only, of {most:.0} px at most"));
            }
        }
        let (most, far) = (LENS * fx.abs().min(fy.abs()), self.farthest(seen));
        let sigma = far.map_or(0.0, |far| self.bent(&far));
        let is_sure = sigma <= most;
        if !is_sure {
            unsure.push(format!(
                "k1, k2, k3, p1, p2: where the board was seen farthest from the middle, by how much the lens bends is known to {sigma:.0} px only, of {most:.0} px at most"
            ));
        }
        unsure
    }

    fn beside(&self) -> Option<f64> {
        let [w, h] = self.camera.size.map(|pixels| pixels as f64 - 1.0);
        let corners = [[0.0, 0.0], [w, 0.0], [0.0, h], [w, h]];
        let far = self.farthest(&[corners.map(|[u, v]| Vector2::new(u, v)).to_vec()])?;
        let sigma = self.bent(&far);
        let is_sure = sigma <= LENS * self.camera.focal[0].abs();
        (!is_sure).then_some(sigma)
    }

    /// The corner that is farthest from the centre, as a ray that the lens has not bent yet, about.
    fn farthest(&self, seen: &[Vec<Vector2<f64>>]) -> Option<Vector2<f64>> {
        let Camera { focal: [fx, fy], centre: [cx, cy], .. } = *self.camera;
        let all = seen.iter().flatten();
        all.map(|at| Vector2::new((at.x - cx) / fx, (at.y - cy) / fy))
            .max_by(|a, b| a.norm().total_cmp(&b.norm()))
    }

    /// The standard deviation of what the lens does there [pixel].
    fn bent(&self, ray: &Vector2<f64>) -> f64 {
        if self.covariance.nrows() != 9 {
            return f64::INFINITY;
        }
        let (a, b, q) = (ray.x, ray.y, ray.norm_squared());
        let by = |own: f64, tangential: [f64; 2]| {
            DVector::from_column_slice(&[q * own, q * q * own, tangential[0], tangential[1], q * q * q * own])
        };
        let (u, v) = (by(a, [2.0 * a * b, q + 2.0 * a * a]), by(b, [q + 2.0 * b * b, 2.0 * a * b]));
        let lens = self.covariance.view((4, 4), (5, 5));
        let [fx, fy] = self.camera.focal;
        let variance = fx * fx * (lens * &u).dot(&u) + fy * fy * (lens * &v).dot(&v);
        self.floor * variance.max(0.0).sqrt()
    }
}

/// The root mean square of the distances of pixels.
fn rms(raw: &[f64]) -> f64 {
    (2.0 * raw.iter().map(|one| one * one).sum::<f64>() / raw.len().max(1) as f64).sqrt()
}

/// The homography that maps points of the plane z = 0 to pixels, by least squares with both in units of their spread (Hartley 1997).
fn homography(points: &[Vector3<f64>], pixels: &[Vector2<f64>]) -> Option<Matrix3<f64>> {
    if points.len() != pixels.len() || points.len() < 4 {
        return None;
    }
    let unit = |all: &[Vector2<f64>]| {
        let n = all.len() as f64;
        let mean = all.iter().sum::<Vector2<f64>>() / n;
        let spread = (all.iter().map(|one| (one - mean).norm_squared()).sum::<f64>() / n).sqrt();
        (spread > 0.0 && spread.is_finite()).then(|| {
            let s = spread.recip();
            Matrix3::new(s, 0.0, -s * mean.x, 0.0, s, -s * mean.y, 0.0, 0.0, 1.0)
        })
    };
    let flat: Vec<Vector2<f64>> = points.iter().map(|point| point.xy()).collect();
    let (from, to) = (unit(&flat)?, unit(pixels)?);
    let mut normal = DMatrix::zeros(9, 9);
    for (point, pixel) in flat.iter().zip(pixels) {
        let p = from * point.push(1.0);
        let q = to * pixel.push(1.0);
        for (axis, along) in [(0, q.x), (1, q.y)] {
            let mut row = DMatrix::zeros(1, 9);
            for k in 0..3 {
                row[3 * axis + k] = p[k];
                row[6 + k] = -along * p[k];
            }
            normal += row.transpose() * row;
        }
    }
    let eigen = normal.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let h = eigen.eigenvectors.column(least);
    let plane = Matrix3::new(h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8]);
    Some(to.try_inverse()? * plane * from)
}

/// fx and fy \[pixel\] from pictures of planes, with the centre of the image as that of the lens: the plane's axes are perpendicular, and as long.
fn zhang(planes: &[Matrix3<f64>], [cx, cy]: [f64; 2]) -> Option<[f64; 2]> {
    let (mut normal, mut right) = (nalgebra::Matrix2::zeros(), Vector2::zeros());
    for plane in planes {
        let shifted = Matrix3::new(1.0, 0.0, -cx, 0.0, 1.0, -cy, 0.0, 0.0, 1.0) * plane;
        let (a, b) = (shifted.column(0), shifted.column(1));
        let scale = a.norm() * b.norm();
        let sums = [
            (Vector2::new(a[0] * b[0], a[1] * b[1]), a[2] * b[2]),
            (Vector2::new(a[0] * a[0] - b[0] * b[0], a[1] * a[1] - b[1] * b[1]), a[2] * a[2] - b[2] * b[2]),
        ];
        for (row, rest) in sums {
            let row: Vector2<f64> = row / scale;
            normal += row * row.transpose();
            right -= row * (rest / scale);
        }
    }
    let squares = normal.try_inverse()? * right;
    let focal = [squares.x, squares.y].map(|square| square.recip().sqrt());
    focal.iter().all(|one| one.is_finite()).then_some(focal)
}

/// The pose of a plane in a camera from its homography to rays (a, b).
fn in_camera(plane: &Matrix3<f64>) -> Option<Pose> {
    let (x, y, t) =
        (plane.column(0).into_owned(), plane.column(1).into_owned(), plane.column(2).into_owned());
    let scale = (x.norm() * y.norm()).sqrt();
    // The board is ahead.
    let scale = if t.z < 0.0 { -scale } else { scale };
    let (x, y, t) = (x / scale, y / scale, t / scale);
    let about = Matrix3::from_columns(&[x, y, x.cross(&y)]);
    let svd = about.svd(true, true);
    let turn = Rotation3::from_matrix_unchecked(svd.u? * svd.v_t?);
    let pose = Pose::from_parts(t.into(), UnitQuaternion::from_rotation_matrix(&turn));
    pose.translation.vector.iter().all(|number| number.is_finite()).then_some(pose)
}

impl Intrinsics {
    /// Whether these photos tell all of the camera, and well enough.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.unseen.is_empty() && self.unsure.is_empty()
    }

    /// The text of a calibration file: what [`camera_of`] reads, and what else is known.
    #[must_use]
    pub fn text(&self, photos: &[String], board: impl Into<Pattern>, made: &str) -> String {
        let board = board.into();
        let (what, step) = match board {
            Pattern::Chessboard(_) | Pattern::Charuco(_) => ("corners", "square"),
            Pattern::Circles(_) => ("circles", "step"),
        };
        let Camera { size, focal, centre, lens } = self.camera;
        let mut text = format!(
            "# A camera: u = fx a + cx, v = fy b + cy [pixel] of a ray that the lens has bent to (a, b); the middle of the first pixel is (0, 0).\n\
             # Distortion as OpenCV writes it: radial k1, k2, k3, tangential p1, p2.\n\
             model = \"camera\"\nsize = {size:?}\nfocal = {focal:?}\ncentre = {centre:?}\nradial = {:?}\ntangential = {:?}\n\
             made = {made:?}\n\n[board]\n{what} = {:?}\n{step} = {:?} # m\n\n\
             # What is left of corners [pixel], in all and photo by photo.\n[left]\nrms = {:?}\nphotos = [\n",
            lens.radial,
            lens.tangential,
            board.count(),
            board.step(),
            self.rms
        );
        for (photo, left) in photos.iter().zip(&self.left) {
            text.push_str(&format!("    [{}, {left:?}],\n", quoted(photo)));
        }
        text.push_str("]\n");
        let named: Vec<&str> = names().map(|(name, _)| name).collect();
        text.push_str(&format!(
            "\n[parameters]\nnames = {named:?}\n{}values = {}\n",
            match self.beside {
                None => String::new(),
                Some(sigma) => format!(
                    "# In the image's corners k1, k2, k3, p1, p2 are known to this only [pixel].\nunknown_in_corners = {sigma:.1}\n"
                ),
            },
            List(&numbers(&self.camera))
        ));
        text.push_str(&format!("sigmas = {}\ncovariance = [\n", List(&self.sigma)));
        for row in self.covariance.row_iter() {
            let row: Vec<f64> = row.iter().copied().collect();
            text.push_str(&format!("    {},\n", List(&row)));
        }
        text.push_str("]\n");
        text
    }
}

impl fmt::Display for Intrinsics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for ((name, unit), (value, sigma)) in names().zip(numbers(&self.camera).into_iter().zip(self.sigma)) {
            let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
            let decimals = if unit.is_empty() { 5 } else { 3 };
            writeln!(f, "{:21} {value:12.decimals$}   known to {sigma:.decimals$}", format!("{name}{unit}"))?;
        }
        writeln!(f, "left: {:.3} px rms", self.rms)?;
        match self.beside {
            None => Ok(()),
            Some(sigma) => writeln!(
                f,
                "unknown: k1, k2, k3, p1, p2 beside where the board was: in the image's corners the lens is known to {sigma:.0} px only; hold the board there, too"
            ),
        }
    }
}

/// Reads a camera from the text of its calibration file.
///
/// # Errors
/// What is wrong with it.
pub fn camera_of(text: &str) -> Result<Camera, String> {
    let help = "help: name a file that `calibrate camera` has written";
    let table = DeTable::parse(text).map_err(|why| format!("it is no TOML: {}\n {help}", why.message()))?;
    let table = table.get_ref();
    let model = table.get("model").and_then(|model| model.get_ref().as_str());
    if model != Some("camera") {
        return Err(format!("its `model` is not \"camera\"\n {help}"));
    }
    fn list<const N: usize>(table: &DeTable<'_>, name: &str) -> Option<[f64; N]> {
        let DeValue::Array(list) = table.get(name)?.get_ref() else { return None };
        let number = |value: &DeValue<'_>| match value {
            DeValue::Float(number) => number.as_str().parse().ok().filter(|number: &f64| number.is_finite()),
            DeValue::Integer(number) => number.as_str().parse().ok(),
            _ => None,
        };
        let numbers: Option<Vec<f64>> = list.iter().map(|value| number(value.get_ref())).collect();
        numbers?.try_into().ok()
    }
    let read = || {
        let (focal, centre) = (list::<2>(table, "focal")?, list::<2>(table, "centre")?);
        let size = list::<2>(table, "size")?.map(|side| side as usize);
        let lens = Lens { radial: list(table, "radial")?, tangential: list(table, "tangential")? };
        let sane = focal.iter().all(|one| *one > 0.0) && size.iter().all(|side| *side > 0);
        sane.then_some(Camera { size, focal, centre, lens })
    };
    read().ok_or_else(|| {
        format!("its `size`, `focal`, `centre`, `radial` or `tangential` are missing or no numbers\n {help}")
    })
}
