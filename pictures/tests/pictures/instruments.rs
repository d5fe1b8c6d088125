//! Sensors, inputs and outputs, and the rate of path time in the picture of a run whose values follow from equations.

use std::f64::consts::TAU;
use std::time::Duration;

use mrroc::cell::{InputSetup, OutputSetup, RunPicture};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::robot::{Channel, Output};
use mrroc_pictures::Film;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use nalgebra::Vector3;
use roxmltree::{Document, Node};

/// The length of a step \[s\].
const STEP: f64 = 0.01;

/// A force of 10 N sin(2 pi t) along x, -5 N along z, a torque of 2 N m about y.
struct Wrist;

impl Sensor for Wrist {
    const KIND: &'static str = "wrist";
    type Reading = Wrench;
    type Configuration = ();
}

impl VirtualSensor for Wrist {
    type Kind = Wrist;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Wrench, Fault> {
        let force = 10.0 * (TAU * STEP * order.step as f64).sin();
        Ok(Wrench::new(Vector3::new(force, 0.0, -5.0), Vector3::new(0.0, 2.0, 0.0)))
    }
}

/// Reads in every step that asks, from its first step on; the second half of it says that it is near.
struct Eye;

#[derive(Clone, Copy, Payload)]
struct Looked {
    depth: f64,
    near: bool,
}

impl Sensor for Eye {
    const KIND: &'static str = "eye";
    type Reading = Looked;
    type Configuration = ();
}

impl VirtualSensor for Eye {
    type Kind = Eye;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Looked, Fault> {
        Ok(Looked { depth: 0.5, near: order.step >= 250 })
    }
}

/// Turns the column for so many seconds of path time, reads, and switches an output in its first step.
struct Turn {
    vacuum: Option<Output<bool>>,
    from: Six,
    t: f64,
    duration: f64,
}

fn turn_for(duration: f64, vacuum: Option<Output<bool>>) -> Turn {
    Turn { vacuum, from: Six::zeros(), t: 0.0, duration }
}

#[generator(mp, first = begin)]
fn turn(c: &mut Turn, _v: &Reading<(Wrist, Eye)>, t: Tick) -> Step<(Irp6,)> {
    if c.t >= c.duration {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(c.duration);
    let angle = 0.05 * (1.0 - (TAU * c.t / c.duration).cos());
    let demand = Demand::joints(c.from + Six::x() * angle);
    Step::Next((match c.vacuum.take() {
        Some(vacuum) => demand.with_output(vacuum, true),
        None => demand,
    },))
}

fn begin(c: &mut Turn, e: &State<(Irp6,)>, v: &Reading<(Wrist, Eye)>, t: Tick) -> Step<(Irp6,)> {
    c.from = e.0.demanded().joints;
    turn(c, v, t)
}

struct Pause(u32);

#[condition(mp)]
fn pause(c: &mut Pause) -> bool {
    c.0 = c.0.saturating_sub(1);
    c.0 == 0
}

/// A Move of a second that reads, a Wait of half a second that does not, a Move of a second that reads and switches a
/// vacuum on at once; suspended for a second in between. The switch of the vacuum follows 100 ms after it.
fn picture() -> String {
    let rest = Irp6::READY;
    let arm = RobotSetup::new("arm", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &rest))
        .output(OutputSetup::new("vacuum", Channel::Digital(2)).holds_body())
        .input(
            InputSetup::new("part_is_sucked", Channel::Digital(5))
                .follows("vacuum", Duration::from_millis(100)),
        )
        .input(InputSetup::new("pressure", Channel::Analog(0)));
    let cell = Cell::new(Duration::from_secs_f64(STEP))
        .robot(arm)
        .sensor(SensorSetup::new("wrist", Wrist).of("arm"))
        .sensor(SensorSetup::new("eye", Eye))
        .program(|mp| {
            let mut arm = mp.robot::<Irp6>("arm")?;
            let (mut wrist, mut eye) = (mp.sensor::<Wrist>("wrist")?, mp.sensor::<Eye>("eye")?);
            let vacuum = arm.output::<bool>("vacuum")?;
            mp.move_robots((&mut arm,), (&mut wrist, &mut eye), turn_for(1.0, None))?;
            mp.wait_until((&mut arm,), (), Pause(50))?;
            mp.move_robots((&mut arm,), (&mut wrist, &mut eye), turn_for(1.0, Some(vacuum))).map(drop)
        })
        .on_step(|step, operator| match step {
            200 => operator.suspend(),
            300 => operator.resume(),
            _ => {}
        });
    let mut film = Film::new();
    film.watch(cell).run().expect("keeps the limits");
    let svg = film.svg();
    std::fs::write(std::env::temp_dir().join("instruments.svg"), &svg).expect("a file");
    svg
}

fn of_class<'a>(document: &'a Document<'a>, class: &str) -> Vec<Node<'a, 'a>> {
    document.descendants().filter(|node| node.attribute("class") == Some(class)).collect()
}

fn points(node: &Node<'_, '_>) -> Vec<(f64, f64)> {
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let pairs = node.attribute("points").expect("a line").split_whitespace();
    pairs.filter_map(|pair| pair.split_once(',')).map(|(x, y)| (number(x), number(y))).collect()
}

fn texts<'a>(document: &'a Document<'a>) -> Vec<&'a str> {
    let nodes = document.descendants().filter(|node| node.has_tag_name("text"));
    nodes.filter_map(|node| node.text()).collect()
}

/// When what is told so began and ended \[s\].
fn when(document: &Document<'_>, begins: &str) -> Vec<(f64, f64)> {
    let titles =
        document.descendants().filter(|node| node.has_tag_name("title")).filter_map(|node| node.text());
    let times = |told: &str| {
        let times: Vec<f64> = told.split(' ').filter_map(|word| word.parse().ok()).collect();
        (times[0], times[1])
    };
    titles.filter(|told| told.starts_with(begins)).map(times).collect()
}

#[test]
fn readings_have_a_curve_for_each_number_with_units_and_gaps_where_nobody_asked() {
    let svg = picture();
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    let document = Document::parse(&svg).expect("an SVG");
    let texts = texts(&document);
    for heading in ["wrist", "Force [N]", "Torque [N m]", "eye", "Depth", "Rate of path time [1]"] {
        assert!(texts.contains(&heading), "{heading}: {texts:?}");
    }
    // Six numbers of the wrench and one of the eye, before and after the Wait.
    let lines: Vec<Vec<(f64, f64)>> = of_class(&document, "reading").iter().map(points).collect();
    assert_eq!(lines.len(), 2 * 7);
    let end = |line: &[(f64, f64)]| line.last().expect("points").0;
    for pair in lines.chunks(2) {
        assert!(end(&pair[0]) < pair[1][0].0, "a gap");
    }
    // On the same axis as the joints, whose thick lines span the run.
    let joint = points(&of_class(&document, "measured")[0]);
    let run = when(&document, "Move Turn");
    let wait = when(&document, "Wait Pause")[0];
    let seconds = run.last().expect("two Moves").1;
    let scale = (end(&joint) - joint[0].0) / seconds;
    let gap = (lines[1][0].0 - end(&lines[0])) / scale;
    assert!((gap - (wait.1 - wait.0)).abs() < 0.05, "{gap} s without a reading, {wait:?}");
    // The force along x is a sine of 10 N: in a linear axis half its height above and below the one that is always 0.
    let zero = lines[2][0].1;
    let heights = lines[0].iter().chain(&lines[1]).map(|point| zero - point.1);
    let (least, greatest) = heights.fold((0.0_f64, 0.0_f64), |(a, b), y| (a.min(y), b.max(y)));
    let of_z = zero - lines[4][0].1;
    assert!((greatest + least).abs() < 0.3, "{least} {greatest}");
    assert!((of_z / greatest + 0.5).abs() < 0.02, "-5 N of 10 N: {of_z} px of {greatest} px");
    for told in ["−10.0", "10.0", "−5.00", "2.00", "0.500"] {
        assert!(texts.contains(&told), "{told}");
    }
}

#[test]
fn digital_signals_are_bars_by_name_and_the_rate_is_0_while_the_cell_is_suspended() {
    let svg = picture();
    let document = Document::parse(&svg).expect("an SVG");
    let texts = texts(&document);
    for name in ["input", "output", "vacuum", "part_is_sucked", "pressure", "near"] {
        assert!(texts.contains(&name), "{name}");
    }
    // Switched on with the first demand of the second Move, a step or two after it began; never off again.
    let second = when(&document, "Move Turn")[1];
    let (vacuum, sucked) = (when(&document, "vacuum on"), when(&document, "part_is_sucked on"));
    assert_eq!((vacuum.len(), sucked.len()), (1, 1));
    assert!((0.0..0.05).contains(&(vacuum[0].0 - second.0)), "{vacuum:?} {second:?}");
    assert!((sucked[0].0 - vacuum[0].0 - 0.1).abs() < 1.5 * STEP, "{sucked:?} {vacuum:?}");
    assert!((vacuum[0].1 - second.1).abs() < 0.1, "to the end: {vacuum:?} {second:?}");
    // From step 250 on, while it is suspended.
    let near = when(&document, "near on");
    assert!((near[0].0 - 250.0 * STEP).abs() < 1.5 * STEP, "{near:?}");
    // The rate starts at 1, which is the height of its frame, and is 0 for the time of the suspension, but for the ramps.
    let rate = points(&of_class(&document, "rate")[0]);
    let low = rate.iter().map(|point| point.1).fold(0.0, f64::max);
    let high = rate.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
    assert!((low - high - 56.0).abs() < 0.2, "{low} {high}");
    let scale = (rate[rate.len() - 1].0 - rate[0].0) / second.1;
    let flat = rate.windows(2).filter(|pair| pair.iter().all(|point| (point.1 - low).abs() < 0.2));
    let standing: f64 = flat.map(|pair| (pair[1].0 - pair[0].0) / scale).sum();
    let suspended = when(&document, "suspended")[0];
    assert!((suspended.1 - suspended.0 - 1.0).abs() < 0.02, "{suspended:?}");
    assert!(standing > 0.3 && standing < 1.0, "{standing} s");
    // Shaded over the joints, the rate, and both sensors.
    assert_eq!(of_class(&document, "suspended").len(), 4);
}
