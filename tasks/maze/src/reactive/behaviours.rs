//! The two behaviours that are the task's own: off a wall that is touched, and along it. The first one tells the second in which direction
//! to go on.

use std::cell::Cell;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_generators::line::LinePath;
use mrroc_generators::profile::ProfileCursor;
use mrroc_robots::Irp6;
use nalgebra::Vector2;

use super::sensor::{Seeking, Sought};
use crate::places::{LOW, Sizes, tool};

/// After so many touches it is going in circles: the most that a path out of a contest's maze has needed is 2,300.
pub const MOST: u32 = 4000;

/// In which direction the ball goes on \[rad, W\], known to both behaviours.
pub type Heading = Rc<Cell<f64>>;

fn direction(heading: &Heading) -> Vector2<f64> {
    let (sine, cosine) = heading.get().sin_cos();
    Vector2::new(cosine, sine)
}

fn felt(v: &Reading<(Seeking,)>) -> Result<Sought, Fault> {
    v.0.reading().ok_or_else(|| Fault::thrown("the probe has no reading"))
}

/// Back from what was touched, by a little; there it stands, and is turned to the right. Where it still touches then, it tries other directions
/// off the same place in turn: the wall that it follows is at the left, so those to the right first.
pub struct Retreat {
    heading: Heading,
    sizes: Sizes,
    path: Option<(LinePath, ProfileCursor)>,
    /// Where it touched [m, W], in which direction it went \[W\], and which direction off is tried.
    from: Vector2<f64>,
    moving: Vector2<f64>,
    tried: usize,
    /// How long it has stood \[s\].
    stood: f64,
}

impl Retreat {
    /// By about half of what a robot with a map goes back: it comes again at once.
    const SHARE: f64 = 0.55;
    /// The directions off: so far along the direction in which it went, and to the right of it.
    const DIRECTIONS: [[f64; 2]; 5] = [[-1.0, 0.0], [-0.7, 0.7], [0.0, 1.0], [-0.7, -0.7], [0.0, -1.0]];
    /// What is touched still after so long does not end by itself \[s\].
    const LASTING_CONTACT: f64 = 0.1;

    /// From where the ball touches; it leaves behind in which direction to go on.
    #[must_use]
    pub fn of(heading: &Heading, sizes: &Sizes) -> Self {
        let heading = Rc::clone(heading);
        let (from, moving) = (Vector2::zeros(), Vector2::zeros());
        Self { heading, sizes: *sizes, path: None, from, moving, tried: 0, stood: 0.0 }
    }

    fn go(&mut self, e: &State<Irp6>) -> Result<(), Fault> {
        let [along, right] = Self::DIRECTIONS[self.tried % Self::DIRECTIONS.len()];
        // It has been turned to the right already.
        let off = self.moving * along + direction(&self.heading) * right;
        let clear = self.from + off * (Self::SHARE * self.sizes.back);
        let line = LinePath::new(e.demanded().pose, tool(clear.x, clear.y, LOW));
        let profile =
            line.profile(self.sizes.careful()).map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((line, ProfileCursor::new(profile)));
        self.stood = 0.0;
        Ok(())
    }
}

#[generator(ecp)]
impl Retreat {
    fn first_step(&mut self, e: &State<Irp6>, v: &Reading<(Seeking,)>, t: Tick) -> Result<Step<Irp6>, Fault> {
        let sought = felt(v)?;
        (self.from, self.moving) = (Vector2::new(sought.touch.x, sought.touch.y), sought.moving.into());
        self.heading.set(self.moving.y.atan2(self.moving.x) - FRAC_PI_2);
        self.tried = 0;
        self.go(e)?;
        self.next_step(e, v, t)
    }

    fn next_step(&mut self, e: &State<Irp6>, v: &Reading<(Seeking,)>, t: Tick) -> Result<Step<Irp6>, Fault> {
        if let Some(next) =
            self.path.as_mut().and_then(|(line, cursor)| Some(line.pose(cursor.advance(t.dt)?.s)))
        {
            return Ok(Step::Next(Demand::pose(next)));
        }
        self.stood += t.dt;
        if felt(v)?.touch.touching && self.stood > Self::LASTING_CONTACT {
            self.tried += 1;
            self.go(e)?;
        }
        Ok(Step::Next(Demand::hold()))
    }
}

/// On along a wall at the left: in a curve to the left, until that touches again. Around the end of a wall it is the same curve. Where a
/// whole turn meets nothing there is no wall within it, and the curve becomes wider and wider until it meets one.
pub struct Follow {
    heading: Heading,
    sizes: Sizes,
    at: Vector2<f64>,
    speed: f64,
    /// How far it has been turned since it touched last \[rad\].
    turned: f64,
}

impl Follow {
    /// How narrow the curve is, as a share of a wall's length: so that around an end it meets no other wall.
    const RADIUS: f64 = 0.3;

    /// From where the ball is, in that direction.
    #[must_use]
    pub fn along(heading: &Heading, sizes: &Sizes) -> Self {
        Self { heading: Rc::clone(heading), sizes: *sizes, at: Vector2::zeros(), speed: 0.0, turned: 0.0 }
    }
}

#[generator(ecp)]
impl Follow {
    fn first_step(&mut self, e: &State<Irp6>, v: &Reading<(Seeking,)>, t: Tick) -> Result<Step<Irp6>, Fault> {
        (self.at, self.speed, self.turned) = (e.demanded().pose.translation.vector.xy(), 0.0, 0.0);
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<(Seeking,)>, t: Tick) -> Result<Step<Irp6>, Fault> {
        let sought = felt(v)?;
        if sought.is_round {
            let text = "the ball came round a wall to where it touched that: no path leads to the exit";
            return Err(Fault::thrown(text));
        }
        if sought.is_there {
            return Ok(Step::Done);
        }
        if sought.touch.touches > MOST {
            let text = format!(
                "the exit is not found by {MOST} touches: without a map the ball goes in circles here"
            );
            return Err(Fault::thrown(&text));
        }
        self.speed = (self.speed + self.sizes.acceleration * t.dt).min(self.sizes.velocity);
        let distance = self.speed * t.dt;
        let wider = (self.turned / TAU).max(1.0);
        let turn = distance / (wider * Self::RADIUS * self.sizes.pitch);
        self.turned += turn;
        self.heading.set(self.heading.get() + turn);
        self.at += direction(&self.heading) * distance;
        Ok(Step::Next(Demand::pose(tool(self.at.x, self.at.y, LOW))))
    }
}

#[cfg(test)]
mod tests {
    use mrroc::generator::{Generator, Motion};
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc::sensor::SensorImage;
    use mrroc_robots::Six;

    use super::*;
    use crate::feeling::Touch;

    const DT: f64 = 4e-3;

    /// Where the ball is demanded to be in each step, while this is sought.
    fn demanded<G>(
        mut generator: G,
        from: Pose,
        steps: u64,
        sought: Sought,
    ) -> Result<Vec<Vector2<f64>>, Fault>
    where
        G: Generator<Robots = Irp6, Language = Motion, Sensors = (Seeking,), Order = ()>,
    {
        let mut pose = from;
        let mut places = vec![];
        for step in 0..steps {
            let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose };
            let (c0, e) = (Order::new(()), State::new(RobotImage::new(state, state)));
            let v = Reading::new((SensorImage::new(sought, 0),));
            let t = Tick { step, dt: DT, duration: DT };
            let stepped = match step {
                0 => generator.first_step(&c0, &e, &v, t),
                _ => generator.next_step(&c0, &e, &v, t),
            };
            let Step::Next(demand) = stepped? else { break };
            pose = demand.as_pose().unwrap_or(pose);
            places.push(pose.translation.vector.xy());
        }
        Ok(places)
    }

    #[test]
    fn fault_244_a_ball_that_still_touches_after_it_went_back_tries_other_directions_off() {
        let at = Vector2::new(0.8, 0.1);
        let touch = Touch { touching: true, touches: 5, x: at.x, y: at.y, since: 1.0 };
        let sought = Sought { touch, moving: [1.0, 0.0], ..Sought::default() };
        let retreat = || Retreat::of(&Heading::default(), &Sizes::CLASSIC);
        let places = demanded(retreat(), tool(0.8003, 0.1, LOW), 500, sought).expect("a path");
        // Those at which it stands: twice the same.
        let mut stands: Vec<_> =
            places.windows(2).filter(|two| two[0] == two[1]).map(|two| (two[0] - at) / 0.825e-3).collect();
        stands.dedup_by(|one, other| (*one - *other).norm() < 1e-9);
        // It goes along x, so the right is -y.
        let directions = [[-1.0, 0.0], [-0.7, -0.7], [0.0, -1.0], [-0.7, 0.7], [0.0, 1.0], [-1.0, 0.0]];
        assert!(stands.len() >= directions.len(), "{stands:?}");
        for (stand, direction) in stands.iter().zip(directions) {
            assert!((stand - Vector2::from(direction)).norm() < 1e-6, "{stands:?}");
        }
        // What no longer touches is left alone.
        let free = Sought { touch: Touch { touching: false, ..touch }, ..sought };
        let places = demanded(retreat(), tool(0.8003, 0.1, LOW), 500, free).expect("a path");
        assert!((places[499] - at - Vector2::new(-0.825e-3, 0.0)).norm() < 1e-9, "{}", places[499]);
    }

    #[test]
    fn fault_245_a_ball_that_goes_in_circles_is_a_fault_after_so_many_touches() {
        let follow = |touches| {
            let touch = Touch { touches, ..Touch::default() };
            let follow = Follow::along(&Heading::default(), &Sizes::CLASSIC);
            demanded(follow, tool(0.8, 0.1, LOW), 10, Sought { touch, ..Sought::default() })
        };
        assert_eq!(follow(MOST).expect("goes on").len(), 10);
        assert!(follow(MOST + 1).expect_err("a fault").to_string().contains("circles"));
    }
}
