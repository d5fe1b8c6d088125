//! The README's first program compiles, runs and is what the README shows.

use mrroc::{
    Cell, Demand, Fault, Mp, Payload, Reading, ReadingOrder, Sensor, SensorSetup, State, Step, Tick,
};
use mrroc::{VirtualSensor, condition, generator};
use mrroc_generators::profile::{ProfileCursor, ProfileLimits, Trapezoid};
use mrroc_tests::{Gantry as Rnt, MS, Turntable as Polycrank, gantry, turntable};
use nalgebra::{Vector1, Vector3};

// What the README shows begins here.
#[generator(mp, first = grasp)] // a motion is a step function, and what it returns is demanded
fn carry(c: &mut Carry, t: Tick) -> Step<(Rnt, Polycrank)> {
    match c.profile.advance(t.dt) {
        Some(at) => Step::Next((c.rnt(at.s), c.polycrank(at.s))), // one demand per robot: none can be forgotten
        None => Step::Done,
    }
}

fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let (mut rnt, mut poly) = (mp.robot::<Rnt>("rnt")?, mp.robot::<Polycrank>("polycrank")?);
    let mut force = mp.sensor::<WristForce>("force")?;
    mp.wait_until((&mut rnt, &mut poly), (&mut force,), Held::for_steps(200))?; // Wait
    mp.move_robots((&mut rnt, &mut poly), (), Carry::by(0.1))?; // Move
    Ok(())
}
// What the README shows ends here.

/// Both robots by the same amount, from where they hold the body.
struct Carry {
    profile: ProfileCursor,
    start: (Vector3<f64>, Vector1<f64>),
}

impl Carry {
    fn by(distance: f64) -> Self {
        let limits = ProfileLimits { velocity: 0.2, acceleration: 1.0 };
        let profile = Trapezoid::new(distance, limits).expect("the limits are positive").cursor();
        Carry { profile, start: (Vector3::zeros(), Vector1::zeros()) }
    }

    fn rnt(&self, s: f64) -> Demand<Rnt> {
        Demand::joints(self.start.0 + Vector3::x() * s)
    }

    fn polycrank(&self, s: f64) -> Demand<Polycrank> {
        Demand::joints(self.start.1 + Vector1::new(s))
    }
}

fn grasp(c: &mut Carry, e: &State<(Rnt, Polycrank)>, t: Tick) -> Step<(Rnt, Polycrank)> {
    c.start = (e.0.demanded().joints, e.1.demanded().joints);
    carry(c, t)
}

struct WristForce;

impl Sensor for WristForce {
    const KIND: &'static str = "wrist force";
    type Reading = Force;
    type Configuration = ();
}

#[derive(Clone, Copy, Payload)]
struct Force {
    newtons: f64,
}

/// Pulls ever harder, by 0.1 N a step.
struct Pull(f64);

impl VirtualSensor for Pull {
    type Kind = WristForce;
    fn aggregate(&mut self, _: &ReadingOrder<()>) -> Result<Force, Fault> {
        self.0 += 0.1;
        Ok(Force { newtons: self.0 })
    }
}

/// More than 10 N for so many steps in a row.
struct Held {
    steps: u32,
    seen: u32,
}

impl Held {
    fn for_steps(steps: u32) -> Self {
        Held { steps, seen: 0 }
    }
}

#[condition(mp)]
fn held(c: &mut Held, v: &Reading<(WristForce,)>) -> bool {
    let pulls = v.0.reading().is_some_and(|force| force.newtons > 10.0);
    c.seen = if pulls { c.seen + 1 } else { 0 };
    c.seen >= c.steps
}

#[test]
fn the_program_of_the_readme_runs() {
    let ((rnt, rnt_trace), (polycrank, polycrank_trace)) = (gantry("rnt"), turntable("polycrank"));
    let report = Cell::new(MS)
        .robot(rnt)
        .robot(polycrank)
        .sensor(SensorSetup::new("force", Pull(0.0)))
        .program(coordinate)
        .run()
        .expect("nothing is wrong");
    assert_eq!(rnt_trace.borrow().last().expect("recorded")[0], 0.1);
    assert_eq!(polycrank_trace.borrow().last().expect("recorded")[0], 0.1);
    // 100 steps to 10 N, 200 held, and s / v + v / a = 0.7 s of motion.
    assert!((999..=1005).contains(&report.steps), "{}", report.steps);
}

#[test]
fn the_readme_shows_this_program() {
    let readme = include_str!("../../README.md");
    let shown =
        readme.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next()).expect("a rust block");
    let here = include_str!("main.rs");
    let begin = here.find("begins here.\n").expect("marked") + "begins here.\n".len();
    let end = here.find("// What the README shows ends").expect("marked");
    assert_eq!(shown, &here[begin..end]);
}
