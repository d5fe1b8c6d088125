//! The two behaviours that are the task's own: off a wall that is touched, and along it. The first one tells the second in which direction
//! to go on.

use std::cell::Cell;
use std::f64::consts::FRAC_PI_2;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_generators::line::LinePath;
use mrroc_generators::profile::ProfileCursor;
use mrroc_robots::Irp6;
use nalgebra::Vector2;

use super::sensor::Seeking;
use crate::places::{LOW, Sizes, tool};

/// In which direction the ball goes on \[rad, W\], known to both behaviours.
pub type Heading = Rc<Cell<f64>>;

fn direction(heading: &Heading) -> Vector2<f64> {
    let (sine, cosine) = heading.get().sin_cos();
    Vector2::new(cosine, sine)
}

/// Back from what was touched, by a little; there it stands, and is turned to the right.
pub struct Retreat {
    heading: Heading,
    sizes: Sizes,
    path: Option<(LinePath, ProfileCursor)>,
}

impl Retreat {
    /// By about half of what a robot with a map goes back: it comes again at once.
    const SHARE: f64 = 0.55;

    /// From where the ball touches; it leaves behind in which direction to go on.
    #[must_use]
    pub fn of(heading: &Heading, sizes: &Sizes) -> Self {
        Self { heading: Rc::clone(heading), sizes: *sizes, path: None }
    }
}

#[generator(ecp)]
impl Retreat {
    fn first_step(&mut self, e: &State<Irp6>, v: &Reading<(Seeking,)>, t: Tick) -> Result<Step<Irp6>, Fault> {
        let sought = v.0.reading().ok_or_else(|| Fault::thrown("the probe has no reading"))?;
        let [x, y] = sought.moving;
        self.heading.set(y.atan2(x));
        let back = direction(&self.heading) * (Self::SHARE * self.sizes.back);
        let clear = tool(sought.touch.x - back.x, sought.touch.y - back.y, LOW);
        let line = LinePath::new(e.demanded().pose, clear);
        let profile =
            line.profile(self.sizes.careful()).map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((line, ProfileCursor::new(profile)));
        self.heading.set(self.heading.get() - FRAC_PI_2);
        Ok(self.next_step(t))
    }

    fn next_step(&mut self, t: Tick) -> Step<Irp6> {
        let next = self.path.as_mut().and_then(|(line, cursor)| Some(line.pose(cursor.advance(t.dt)?.s)));
        Step::Next(next.map_or_else(Demand::hold, Demand::pose))
    }
}

/// On along a wall at the left: in a curve to the left, until that touches again. Around the end of a wall it is the same curve.
pub struct Follow {
    heading: Heading,
    sizes: Sizes,
    at: Vector2<f64>,
    speed: f64,
}

impl Follow {
    /// How narrow the curve is, as a share of a wall's length: so that around an end it meets no other wall.
    const RADIUS: f64 = 0.3;

    /// From where the ball is, in that direction.
    #[must_use]
    pub fn along(heading: &Heading, sizes: &Sizes) -> Self {
        Self { heading: Rc::clone(heading), sizes: *sizes, at: Vector2::zeros(), speed: 0.0 }
    }
}

#[generator(ecp)]
impl Follow {
    fn first_step(&mut self, e: &State<Irp6>, v: &Reading<(Seeking,)>, t: Tick) -> Result<Step<Irp6>, Fault> {
        (self.at, self.speed) = (e.demanded().pose.translation.vector.xy(), 0.0);
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<(Seeking,)>, t: Tick) -> Result<Step<Irp6>, Fault> {
        let sought = v.0.reading().ok_or_else(|| Fault::thrown("the probe has no reading"))?;
        if sought.is_round {
            let text = "the ball came round a wall to where it touched that: no way leads to the exit";
            return Err(Fault::thrown(text));
        }
        if sought.is_there {
            return Ok(Step::Done);
        }
        self.speed = (self.speed + self.sizes.acceleration * t.dt).min(self.sizes.velocity);
        let way = self.speed * t.dt;
        self.heading.set(self.heading.get() + way / (Self::RADIUS * self.sizes.pitch));
        self.at += direction(&self.heading) * way;
        Ok(Step::Next(Demand::pose(tool(self.at.x, self.at.y, LOW))))
    }
}
