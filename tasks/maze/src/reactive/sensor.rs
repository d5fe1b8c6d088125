//! The virtual sensor of an arm that looks for the exit: what the probe touches, and whether the ball is on its line.
//!
//! ```text
//!  on its line   from the beginning until a touch; again where the ball crosses the straight line nearer to the exit than that touch was.
//!               A touch within a distance of `GRACE` from there is of the wall that it still leaves, and changes nothing
//! round         back where it touched, without that: no path leads to the exit
//! ```

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_map::Contact;
use nalgebra::{Point3, Vector2};

use crate::feeling::Touch;
use crate::plant::{Probe, World};

/// The kind of sensor.
#[derive(Clone, Copy, Debug)]
pub struct Seeking;

impl Sensor for Seeking {
    const KIND: &'static str = "path to the exit";
    type Reading = Sought;
    type Configuration = Line;
}

/// The straight line to the exit: `c_j`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Line {
    /// Where it begins [m, W].
    pub from: [f64; 2],
    /// The middle of the exit [m, W].
    pub to: [f64; 2],
    /// It is there when it is so near \[m\].
    pub near: f64,
}

/// What is known of the search for the exit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Sought {
    /// What the probe touches.
    pub touch: Touch,
    /// In which direction the ball went when it touched last \[W\], of length 1.
    pub moving: [f64; 2],
    /// Whether the ball is on its straight line to the exit, and not beside a wall across that.
    pub is_on_line: bool,
    /// Whether it is at the exit.
    pub is_there: bool,
    /// Whether it has come round a wall to where it touched that.
    pub is_round: bool,
}

/// What is remembered of the last touch on the line.
#[derive(Clone, Copy, Debug)]
struct Hit {
    at: Vector2<f64>,
    /// How far from the exit it was on the straight line \[m\].
    left: f64,
    /// The distance that the ball has gone since \[m\].
    gone: f64,
}

/// As a share of a wall's length.
const GRACE: f64 = 0.2;

/// Makes the readings.
#[derive(Debug)]
pub struct Seeker {
    world: Rc<RefCell<World>>,
    probe: Probe,
    /// Nearer to the place of a touch than this \[m\] is there again; the other side of a wall is farther ..
    same: f64,
    /// .. and it is looked at after so much distance \[m\].
    least: f64,
    touches: u32,
    moving: Vector2<f64>,
    /// Where the seat was half a millimetre or more before [m, W].
    behind: Option<Vector2<f64>>,
    trail: Vector2<f64>,
    /// Where the seat was at the reading before [m, W].
    before: Option<Vector2<f64>>,
    hit: Option<Hit>,
    /// How far from the exit it came to be on its line again, and the distance that the ball has gone since \[m\].
    met: Option<(f64, f64)>,
    /// So short a distance is that by which a wall is left \[m\].
    grace: f64,
    touched: Rc<RefCell<Vec<Contact>>>,
}

impl Seeker {
    /// In this world, where posts are `pitch` apart \[m\].
    #[must_use]
    pub fn new(world: Rc<RefCell<World>>, pitch: f64) -> Self {
        let probe = Probe::new(Rc::clone(&world));
        Self {
            world,
            probe,
            same: 0.16 * pitch,
            least: 2.5 * pitch,
            touches: 0,
            moving: Vector2::zeros(),
            behind: None,
            trail: Vector2::zeros(),
            before: None,
            hit: None,
            met: None,
            grace: GRACE * pitch,
            touched: Rc::default(),
        }
    }

    /// What was touched, to be drawn, as a view of this sensor [m, M].
    #[must_use]
    pub fn touched(&self) -> Rc<RefCell<Vec<Contact>>> {
        Rc::clone(&self.touched)
    }

    fn note(&self, touch: Vector2<f64>, moving: Vector2<f64>) {
        let world = self.world.borrow();
        let at = world.X_WM.inverse_transform_point(&Point3::new(touch.x, touch.y, 0.0)).coords.xy();
        let direction = (world.X_WM.rotation.inverse() * moving.push(0.0)).xy();
        let into = direction.try_normalize(1e-12).unwrap_or_default();
        let contact = Contact { at: at + into * world.stylus.radius(), into, moving: into, ball: at };
        self.touched.borrow_mut().push(contact);
    }
}

impl VirtualSensor for Seeker {
    type Kind = Seeking;

    fn aggregate(&mut self, order: &ReadingOrder<Line>) -> Result<Sought, Fault> {
        let arm = order
            .robot
            .ok_or_else(|| Fault::thrown("the path to the exit needs the state of an arm: write `of`"))?;
        let touch = self.probe.touch(&arm.pose.translation.vector)?;
        let (from, to) = (Vector2::from(order.configuration.from), Vector2::from(order.configuration.to));
        let now = arm.pose.translation.vector.xy();
        let before = self.before.replace(now).unwrap_or(now);
        if from == to {
            (self.touches, self.behind, self.trail) = (touch.touches, Some(now), now);
            return Ok(Sought { touch, is_on_line: true, ..Sought::default() });
        }
        let left = |at: &Vector2<f64>| (to - at).norm();
        let gone = (now - before).norm();
        if let Some((_, since)) = &mut self.met {
            *since += gone;
        }
        if let Some(hit) = &mut self.hit {
            hit.gone += gone;
            let beside = |at: &Vector2<f64>| (to - from).perp(&(at - from));
            let crosses = beside(&before) * beside(&now) <= 0.0 && before != now;
            // A millimetre at least, so that touches of one place come to an end.
            if crosses && left(&now) < hit.left - 1e-3 {
                (self.hit, self.met) = (None, Some((left(&now), 0.0)));
            }
        }
        if touch.touches != self.touches {
            self.touches = touch.touches;
            let at = Vector2::new(touch.x, touch.y);
            self.moving = (now - self.behind.unwrap_or(before)).try_normalize(1e-9).unwrap_or_default();
            self.note(at, self.moving);
            let (at_most, since) = self.met.unwrap_or((f64::INFINITY, f64::INFINITY));
            if since > self.grace {
                self.hit.get_or_insert(Hit { at, left: left(&at).min(at_most), gone: 0.0 });
            }
        }
        // Two places of the trail, so that the older one is always half a millimetre away or more.
        if (now - self.trail).norm() > 5e-4 {
            (self.behind, self.trail) = (Some(self.trail), now);
        }
        // Pressed to the other side of the wall, the seat would be nearer than the ball.
        let is_round = !touch.touching
            && self.hit.is_some_and(|hit| hit.gone > self.least && (now - hit.at).norm() < self.same);
        let is_there = left(&now) < order.configuration.near;
        Ok(Sought { touch, moving: self.moving.into(), is_on_line: self.hit.is_none(), is_there, is_round })
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
