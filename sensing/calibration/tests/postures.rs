//! Postures that `calibrate poses` chooses: what is foretold of them comes true, what must be kept is kept, and what cannot be is refused.

use std::path::Path;

use mrroc::pose::Pose;
use mrroc::random::Noise as Random;
use mrroc_calibration::data::{Data, Described, Plan, Scales};
use mrroc_calibration::trials::{Errors, Trial, lengths};
use mrroc_calibration::*;
use nalgebra::{Point3, Vector3};

const SIGMA: f64 = 2e-5;
const BALLS: [(&str, [f64; 3]); 3] =
    [("A", [0.05, 0.0, 0.06]), ("B", [-0.03, 0.045, 0.03]), ("C", [-0.02, -0.05, 0.09])];

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/tests/reference/urdf")
}

/// The header of a table: the URDF arm, a tracker, three balls on the flange.
fn header() -> String {
    let mut text = "# robot = \"three_parallel.urdf\"\n# tip = \"wrist_3\"\n# [joints]\n\
                    # columns = [\"q1\", \"q2\", \"q3\", \"q4\", \"q5\", \"q6\"]\n# unit = \"deg\"\n# signs = [1, -1, 1, 1, 1, 1]\n\
                    # [[measures]]\n# instrument = \"tracker\"\n# kind = \"point\"\n# columns = [\"x\", \"y\", \"z\"]\n# unit = \"mm\"\n\
                    # sigma = 0.02\n# point = { column = \"ball\" }\n"
        .to_owned();
    for (name, [x, y, z]) in BALLS {
        text += &format!("# [points.{name}]\n# position = [{x}, {y}, {z}]\n# unit = \"m\"\n");
    }
    text
}

fn plan(text: &str) -> Result<Plan, String> {
    let file = folder().join("plan.csv").display().to_string();
    Plan::parse(&file, text).map_err(|why| why.to_string())
}

fn chosen(text: &str, wanted: &Wanted) -> Result<Postures, String> {
    Postures::choose(plan(text)?, wanted).map_err(|why| why.to_string())
}

fn of(count: usize, seed: u64) -> Wanted {
    Wanted { count, seed, ..Wanted::default() }
}

/// An arm that is off as far as the tolerances say, and what the tracker reads of it.
struct Truth {
    model: ChainArm,
    values: Vec<f64>,
    balls: Vec<Vector3<f64>>,
    random: Random,
}

impl Truth {
    fn new(seed: u64) -> Self {
        let arm = Described::urdf(&folder().join("three_parallel.urdf"), None, "wrist_3").expect("a URDF");
        let model = arm.chain.with(Detail::Geometry, &Tolerances::default());
        let mut random = Random::seeded(seed);
        let tolerance = |parameter: &Parameter| parameter.tolerance.expect("each has one");
        let values = Arm::parameters(&model).iter().map(|one| tolerance(one) * random.normal()).collect();
        let mut three = |at: [f64; 3]| Vector3::from(at).map(|axis| axis + 1e-3 * random.normal());
        let balls = BALLS.map(|(_, at)| three(at)).to_vec();
        Self { model, values, balls, random }
    }

    /// Fills in a table, with noise of so many standard deviations.
    fn measured(&mut self, table: &str, noise: f64) -> String {
        let place = Pose::new(Vector3::new(1.502, 0.3, -0.2), Vector3::new(0.1, 0.2, 2.1));
        let mut filled = String::new();
        for line in table.lines() {
            let cells: Vec<&str> = line.split(',').collect();
            let Some(ball) = BALLS.iter().position(|(name, _)| *name == cells[0]) else {
                filled += &format!("{line}\n");
                continue;
            };
            assert_eq!(&cells[7..], ["", "", ""], "nothing is measured yet");
            let mut q: Vec<f64> =
                cells[1..7].iter().map(|cell| cell.parse::<f64>().expect("a number").to_radians()).collect();
            q[1] = -q[1];
            let seen = place * Arm::flange(&self.model, &q, &self.values) * Point3::from(self.balls[ball]);
            let mm = seen.coords.map(|axis| 1e3 * (axis + noise * SIGMA * self.random.normal()));
            filled += &format!("{},{:.6},{:.6},{:.6}\n", cells[..7].join(","), mm.x, mm.y, mm.z);
        }
        filled
    }
}

fn data(text: &str) -> Data {
    let file = folder().join("filled.csv").display().to_string();
    Data::parse(&file, text).unwrap_or_else(|why| panic!("{why}"))
}

/// Arms drawn from the tolerances, by seeds: the root mean square over them of what is off at postures that were neither chosen nor chosen from.
#[test]
fn postures_that_are_chosen_measured_and_calibrated_leave_the_error_that_was_foretold() {
    let postures = chosen(&header(), &of(16, 1)).expect("a plan");
    let unseen = chosen(&header(), &of(40, 99)).expect("another").table;
    let mut squares = 0.0;
    for seed in 1..=4 {
        let mut truth = Truth::new(seed);
        let measured = data(&truth.measured(&postures.table, 1.0));
        assert_eq!((measured.postures(), measured.measurements()), (16, 48));
        let trial = Trial::of(&measured, Detail::Geometry, 1.0, Scales::Declared).expect("a fit");
        let information = trial.fit.information();
        let Told { rank, unknowns, .. } = postures.chosen;
        assert_eq!((information.rank, information.parameters()), (rank, unknowns), "seed {seed}");
        let exact = data(&truth.measured(&unseen, 0.0));
        let other = measured.with_rows_of(&exact, &trial.stated).expect("the same names");
        let errors = lengths(&other, &trial.fit.foretold(&other)).into_iter().map(|(_, error)| error);
        squares += Errors::of(errors).rms.powi(2) / 4.0;
    }
    let ratio = squares.sqrt() / postures.chosen.error;
    assert!((1.0 / 1.5..1.5).contains(&ratio), "{ratio} of {:?}", postures.chosen);
}

/// By half as many for the same error on an arm that is seen badly: `tasks/calibration/tests/accuracy.rs`. A tracker leaves less to gain.
#[test]
fn chosen_postures_tell_more_than_as_many_at_random() {
    let ratio = |seed| {
        let postures = chosen(&header(), &of(16, seed)).expect("a plan");
        assert_eq!(postures.chosen.rank, postures.random.rank);
        assert!(!postures.unseen.is_empty(), "the base and joint 1 cannot be told apart");
        postures.chosen.error / postures.random.error
    };
    let ratios: Vec<f64> = (1..4).map(ratio).collect();
    assert!(ratios.iter().all(|ratio| *ratio < 1.0), "{ratios:?}");
}

/// The floor, the range and the face of each point that a row names, by the arm's own kinematics.
#[test]
fn floor_range_and_face_are_kept_by_every_row() {
    let text = header() + "# [instruments.tracker]\n# position = [1500, 300, 400]\n# unit = \"mm\"\n";
    let (floor, range, most) = (0.1, [0.8, 1.6], 1.0);
    let facing = Some((Vector3::z_axis(), most));
    let wanted = Wanted { floor: Some(floor), range: Some(range), facing, ..of(12, 3) };
    let postures = chosen(&text, &wanted).expect("a plan");
    let arm = Described::urdf(&folder().join("three_parallel.urdf"), None, "wrist_3").expect("a URDF");
    let model = arm.chain.with(Detail::Frames, &Tolerances::default());
    let mut rows = 0;
    for line in postures.table.lines() {
        let cells: Vec<&str> = line.split(',').collect();
        let Some((_, at)) = BALLS.iter().find(|(name, _)| *name == cells[0]) else { continue };
        let mut q: Vec<f64> =
            cells[1..7].iter().map(|cell| cell.parse::<f64>().expect("a number").to_radians()).collect();
        q[1] = -q[1];
        let flange = Arm::flange(&model, &q, &[]);
        let ball = flange * Point3::from(*at);
        let sight = Vector3::new(1.5, 0.3, 0.4) - ball.coords;
        assert!(flange.translation.z > floor - 1e-6 && ball.z > floor - 1e-6, "{line}");
        assert!(range[0] - 1e-6 < sight.norm() && sight.norm() < range[1] + 1e-6, "{line}");
        assert!((flange.rotation * Vector3::z()).angle(&sight) < most + 1e-6, "{line}");
        rows += 1;
    }
    assert!(rows >= 12);
}

/// Two links of 0.5 m with balls of 0.1 m at both ends: folded, the last ball meets the first.
#[test]
fn links_that_would_meet_are_not_chosen_where_the_urdf_says_their_shapes() {
    let ball = |at: f64, radius: f64| {
        format!(
            "<collision><origin xyz=\"{at} 0 0\"/><geometry><sphere radius=\"{radius}\"/></geometry></collision>"
        )
    };
    let link = |name: &str, shape: String| format!("<link name=\"{name}\">{shape}</link>");
    let joint = |name: &str, at: f64, parent: &str, child: &str, most: f64| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><origin xyz=\"{at} 0 0\"/><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <axis xyz=\"0 0 1\"/><limit lower=\"-{most}\" upper=\"{most}\" effort=\"1\" velocity=\"1\"/></joint>"
        )
    };
    let urdf = format!(
        "<robot name=\"two\">{}{}{}{}{}</robot>",
        link("base", ball(0.0, 0.1)),
        link("upper", String::new()),
        link("fore", ball(0.5, 0.1)),
        joint("shoulder", 0.0, "base", "upper", 3.1),
        joint("elbow", 0.5, "upper", "fore", 3.1)
    );
    let folder = std::env::temp_dir().join(format!("mrroc-postures-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("two.urdf"), urdf).expect("written");
    let text = "# robot = \"two.urdf\"\n# tip = \"fore\"\n# [joints]\n# columns = [\"q1\", \"q2\"]\n# unit = \"rad\"\n\
                # [[measures]]\n# kind = \"point\"\n# columns = [\"x\", \"y\", \"z\"]\n# unit = \"mm\"\n# sigma = 0.02\n# point = \"tip\"\n\
                # [points.tip]\n# position = [0.5, 0, 0.1]\n# unit = \"m\"\n";
    let plan = Plan::parse(&folder.join("plan.csv").display().to_string(), text);
    let postures = Postures::choose(plan.expect("a plan"), &of(40, 1)).expect("postures");
    std::fs::remove_dir_all(folder).expect("removed");
    assert_eq!(postures.no_clearance, None);
    let rows = postures.table.lines().filter(|line| !line.starts_with(['#', 'q']));
    let elbows: Vec<f64> =
        rows.map(|row| row.split(',').nth(1).expect("q2").parse().expect("a number")).collect();
    assert_eq!(elbows.len(), 40);
    // The distance of both balls' centres is 2 x 0.5 m x |cos(q2 / 2)|, and 0.2 m are their radii.
    assert!(elbows.iter().all(|q| (0.5 * q).cos().abs() > 0.2), "{elbows:?}");
}

/// What is wrong, and a part of what is said of it and of what to do.
#[test]
fn what_cannot_be_chosen_is_refused_with_what_to_do() {
    let text = header();
    for (from, to, told, help) in [
        ("# sigma = 0.02\n", "", "how well `tracker` measures is not said", "write sigma = "),
        ("# position = [0.05, 0, 0.06]\n", "", "nobody says where the point `A` is", "[points.A]"),
        ("kind = \"point\"", "kind = \"points\"", "`points`", "did you mean `point`?"),
        (
            "columns = [\"x\", \"y\", \"z\"]\n# unit = \"mm\"\n# sigma = 0.02",
            "columns = [\"d\"]\n# unit = \"mm\"\n# sigma = 0.02",
            "1 columns, where 3 are read",
            "write x, y, z",
        ),
    ] {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text, "{from}");
        let why = plan(&changed).err().expect(told);
        assert!(why.contains(told) && why.contains(help), "{from} -> {to}: {why}");
    }
    let refused = |text: &str, wanted: &Wanted| chosen(text, wanted).expect_err("refused");
    let why = refused(&text, &of(0, 1));
    assert!(why.contains("0 postures are wanted, of 3 to 200") && why.contains("--count 30"), "{why}");
    let near = Wanted { range: Some([0.5, 1.0]), ..of(10, 1) };
    let why = refused(&text, &near);
    assert!(
        why.contains("nobody says where `tracker` stands") && why.contains("[instruments.tracker]"),
        "{why}"
    );
    let far = text.clone() + "# [instruments.tracker]\n# position = [30, 0, 0]\n# unit = \"m\"\n";
    let why = refused(&far, &near);
    assert!(why.contains("`tracker` sees no point in any of") && why.contains("--range"), "{why}");
    let why = refused(&text, &Wanted { floor: Some(2.0), ..of(10, 1) });
    assert!(why.contains("0 postures of") && why.contains("below the floor"), "{why}");

    // Limits of a DH arm are in its own table.
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data/positioner.toml");
    let arm = std::fs::read_to_string(example).expect("a file");
    let none = arm.lines().filter(|line| !line.starts_with("limits")).collect::<Vec<_>>().join("\n");
    let arm = Described::dh_text("arm.toml", &none).expect("an arm");
    assert!(arm.limits.iter().all(Option::is_none));
    let turned = none.replacen("[[joints]]", "[[joints]]\nlimits = [90, -90]", 1);
    let why = Described::dh_text("arm.toml", &turned).expect_err("turned round").to_string();
    assert!(why.contains("the lower one first"), "{why}");
}
