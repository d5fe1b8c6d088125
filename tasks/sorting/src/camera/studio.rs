//! Images without a cell: parts that lie anywhere below the camera and pass it at any speed. What a network learns from, and is examined by.

use core::f64::consts::PI;
use std::fmt::Write as _;

use mrroc::pose::{AngleAxis, Pose};
use mrroc::random::Noise;
use mrroc_sensors::aggregation::{Blind, Classifier, DetectedObject, FEATURES, Vision};
use mrroc_sensors::camera::Plane;
use mrroc_sensors::form::Form;
use mrroc_sensors::physics::Imager;
use mrroc_sensors::scene::{Scene, Solid};
use mrroc_sensors::view::{Seen, View};
use nalgebra::{Vector2, Vector3};

use super::kinds::{Kind, classes, kinds, lying, strangers, turned};
use super::layout::{ACROSS, CAMERA, camera};

/// How much larger or smaller than its kind a part may be, as a share ..
pub const TOLERANCE: f64 = 0.007;
/// .. and how much light it scatters.
pub const REFLECTANCE: [f64; 2] = [0.45, 0.95];

/// A part on the belt.
pub struct Lying {
    /// Its kind; `None` of a stranger.
    pub kind: Option<usize>,
    /// In its frame P.
    pub form: Form,
    /// `X_FP`.
    pub pose: Pose,
    /// About z \[rad\].
    pub angle: f64,
    /// How much light it scatters, 0 to 1.
    pub reflectance: f64,
}

impl Lying {
    /// A part whose middle is at a place, so that all of it is about that, whatever its frame is.
    #[must_use]
    pub fn of(kind: Option<usize>, form: Form, [x, y]: [f64; 2], angle: f64, reflectance: f64) -> Self {
        let corners: Vec<_> = form.corners().collect();
        let (least, most) = corners.iter().fold((corners[0], corners[0]), |(a, b), c| (a.inf(c), b.sup(c)));
        let middle = nalgebra::Rotation2::new(angle) * (0.5 * (least + most)).xy();
        Self { kind, form, pose: lying(x - middle.x, y - middle.y, angle), angle, reflectance }
    }
}

/// Parts that pass a sensor at a speed [m/s].
pub struct Passing {
    /// Those.
    pub parts: Vec<Lying>,
    /// [m/s].
    pub speed: f64,
    /// How far the belt has run \[m\].
    pub run: f64,
    /// \[s\].
    pub now: f64,
}

impl Scene for Passing {
    fn now(&self) -> f64 {
        self.now
    }

    fn each_solid(&self, _: &mut dyn FnMut(&Solid<'_>)) {}
}

impl View for Passing {
    fn each_form(&self, visit: &mut dyn FnMut(&Seen<'_>)) {
        for part in &self.parts {
            visit(&Seen {
                form: &part.form,
                pose: part.pose,
                velocity: Vector3::x() * self.speed,
                angular_velocity: Vector3::zeros(),
                reflectance: part.reflectance,
            });
        }
    }

    fn surface(&self, before: f64) -> f64 {
        self.run - self.speed * before
    }
}

/// A thing that was shown, and what was made of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Its kind; `None` of a stranger.
    pub kind: Option<usize>,
    /// As which it was taken; `None` of what was rejected or not found.
    pub taken: Option<usize>,
    /// How likely that was.
    pub score: f64,
    /// How well its outline fitted.
    pub fit: f64,
    /// How far its place was off \[m\].
    pub off: f64,
    /// How far its angle was off \[rad\].
    pub turned: f64,
    /// By what it was told.
    pub features: [f32; FEATURES],
}

/// Takes the nominal camera off where it is believed to be: what its calibration leaves.
#[must_use]
#[allow(non_snake_case)]
pub fn misplaced(believed: &Plane, random: &mut Noise) -> Plane {
    let mut about = |sigma: f64| Vector3::from_fn(|_, _| sigma * random.normal());
    let (shift, turn) = (about(7e-5), about(7e-5));
    let turn = Pose::from_parts(shift.into(), AngleAxis(turn).rotation());
    believed.at(believed.X_FC * turn)
}

/// Shows the empty belt, and then `count` things to a classifier, two to an image, as `seed` draws them; every so many a stranger, if that is not 0.
///
/// # Errors
/// None, as long as there is light.
pub fn examine(
    count: usize,
    seed: u64,
    stranger: usize,
    classifier: Box<dyn Classifier>,
    show: impl FnMut(&[u8], &[DetectedObject]),
) -> Result<Vec<Trial>, Blind> {
    trials(count, seed, stranger, APART, classifier, show)
}

/// Where things are put below the camera along the belt, and by how much they may be off that \[m\].
type Places = (&'static [f64], f64);
/// Two in an image: all of both is in sight.
const APART: Places = (&[-0.075, 0.075], 0.02);
/// Three in an image, of which some stick out of it or touch: enough to learn from.
const CROWDED: Places = (&[-0.112, 0.0, 0.112], 0.004);

fn trials(
    count: usize,
    seed: u64,
    stranger: usize,
    places: Places,
    classifier: Box<dyn Classifier>,
    mut show: impl FnMut(&[u8], &[DetectedObject]),
) -> Result<Vec<Trial>, Blind> {
    const IMAGES: usize = 12;
    let mut random = Noise::seeded(seed);
    let (kinds, strangers) = (kinds(), strangers());
    let believed = camera();
    let mut vision = Vision::new(believed.clone(), classes(), classifier);
    let mut imager: Option<Imager> = None;
    let (mut trials, mut image, mut images) = (Vec::new(), Vec::new(), 0_usize);
    while trials.len() < count {
        if images.is_multiple_of(IMAGES) {
            // Other light, another belt, a camera that is a little elsewhere.
            let seed = (random.uniform() * 1e15) as u64;
            imager = Some(Imager::over(misplaced(&believed, &mut random), seed));
        }
        let Some(imager) = &mut imager else { break };
        if images.is_multiple_of(IMAGES) {
            let empty = Passing { parts: Vec::new(), speed: 0.1, run: 0.0, now: 0.0 };
            imager.expose(&empty, 0.0, &mut image);
            show(&image, &[]);
            vision.teach(&image)?;
        }
        images += 1;
        let from = trials.len();
        let strange = |number: usize| stranger > 0 && number.is_multiple_of(stranger);
        let scene = passing(&kinds, &strangers, (from..).map(strange), places, &mut random);
        imager.expose(&scene, 0.0, &mut image);
        let found = vision.look(&image)?;
        show(&image, &found);
        trials.extend(scene.parts.iter().map(|part| evaluated(part, &kinds, &found)));
    }
    trials.truncate(count);
    Ok(trials)
}

/// Things at these places, each a stranger or not.
fn passing(
    kinds: &[Kind],
    strangers: &[Kind],
    strange: impl Iterator<Item = bool>,
    (places, jitter): Places,
    random: &mut Noise,
) -> Passing {
    let mut parts = Vec::new();
    for (place, is_stranger) in places.iter().zip(strange) {
        let pick =
            |count: usize, random: &mut Noise| ((random.uniform() * count as f64) as usize).min(count - 1);
        let kind = (!is_stranger).then(|| pick(kinds.len(), random));
        let scale = 1.0 + random.between(-TOLERANCE, TOLERANCE);
        let form = match kind {
            Some(kind) => kinds[kind].class.form.scaled(scale),
            None => strangers[pick(strangers.len(), random)].class.form.scaled(scale),
        };
        let angle = random.between(-PI, PI);
        let x = CAMERA[0] + place + random.between(-jitter, jitter);
        let y = random.between(-ACROSS, ACROSS);
        let reflectance = random.between(REFLECTANCE[0], REFLECTANCE[1]);
        parts.push(Lying::of(kind, form, [x, y], angle, reflectance));
    }
    Passing { parts, speed: random.between(0.0, 0.2), run: random.between(0.0, 10.0), now: 0.0 }
}

fn evaluated(part: &Lying, kinds: &[Kind], found: &[DetectedObject]) -> Trial {
    let truly: Vector2<f64> = part.pose.translation.vector.xy();
    let near = |found: &&DetectedObject| (found.place - truly).norm() < 0.045;
    let nearest = found
        .iter()
        .filter(near)
        .min_by(|a, b| (a.place - truly).norm_squared().total_cmp(&(b.place - truly).norm_squared()));
    let Some(found) = nearest else {
        let nothing = Trial {
            kind: part.kind,
            taken: None,
            score: 0.0,
            fit: 0.0,
            off: 0.0,
            turned: 0.0,
            features: [0.0; FEATURES],
        };
        return nothing;
    };
    let turns = part.kind.map_or(0, |kind| kinds[kind].class.turns);
    Trial {
        kind: part.kind,
        taken: found.class,
        score: found.score,
        fit: found.fit,
        off: (found.place - truly).norm(),
        turned: turned(found.angle, part.angle, turns),
        features: found.features,
    }
}

/// A classifier that knows nothing: to collect features.
pub struct Untrained;

impl Classifier for Untrained {
    fn classify(&mut self, _: &[f32]) -> Option<Vec<f32>> {
        None
    }
}

/// A table to train by: the kind, and the features, of so many parts.
///
/// # Errors
/// None, as long as there is light.
pub fn data_set(count: usize, seed: u64) -> Result<String, Blind> {
    let trials = trials(count, seed, 0, CROWDED, Box::new(Untrained), |_, _| ())?;
    let mut table = String::new();
    for trial in trials.iter().filter(|trial| trial.features != [0.0; FEATURES]) {
        let _ = write!(table, "{}", trial.kind.unwrap_or_default());
        trial.features.iter().for_each(|feature| {
            let _ = write!(table, ",{feature:.5}");
        });
        table.push('\n');
    }
    Ok(table)
}
