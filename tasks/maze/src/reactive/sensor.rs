//! The virtual sensor of an arm that looks for the exit: what the probe touches, and whether the ball is on its way.
//!
//! ```text
//! on its way    from the beginning until a touch; again where the ball crosses the straight line nearer to the exit than that touch was
//! round         back where it touched, without that: no way leads to the exit
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
    const KIND: &'static str = "way to the exit";
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

/// What is known on the way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Sought {
    /// What the probe touches.
    pub touch: Touch,
    /// Whether the ball is on its way, and not beside a wall that was in it.
    pub is_on_way: bool,
    /// Whether it is at the exit.
    pub is_there: bool,
    /// Whether it has come round a wall to where it touched that.
    pub is_round: bool,
}

/// What is remembered of the touch that was in the way.
#[derive(Clone, Copy, Debug)]
struct Hit {
    at: Vector2<f64>,
    /// The way of the ball since \[m\].
    gone: f64,
}

/// Makes readings of the way.
#[derive(Debug)]
pub struct Seeker {
    world: Rc<RefCell<World>>,
    probe: Probe,
    /// Nearer to the place of a touch than this \[m\] is there again; the other side of a wall is farther ..
    same: f64,
    /// .. and it is looked at after so much way \[m\].
    least: f64,
    touches: u32,
    /// Where the seat was at the reading before [m, W].
    before: Option<Vector2<f64>>,
    hit: Option<Hit>,
    touched: Rc<RefCell<Vec<Contact>>>,
}

impl Seeker {
    /// In this world, where posts are `pitch` apart \[m\].
    #[must_use]
    pub fn new(world: Rc<RefCell<World>>, pitch: f64) -> Self {
        let probe = Probe::new(Rc::clone(&world));
        let (same, least) = (0.16 * pitch, 2.5 * pitch);
        Self { world, probe, same, least, touches: 0, before: None, hit: None, touched: Rc::default() }
    }

    /// What was touched, to be drawn, as a view of this sensor [m, M].
    #[must_use]
    pub fn touched(&self) -> Rc<RefCell<Vec<Contact>>> {
        Rc::clone(&self.touched)
    }

    fn note(&self, touch: Vector2<f64>, moving: Vector2<f64>) {
        let world = self.world.borrow();
        let at = world.X_WM.inverse_transform_point(&Point3::new(touch.x, touch.y, 0.0)).coords.xy();
        let way = (world.X_WM.rotation.inverse() * moving.push(0.0)).xy();
        let into = way.try_normalize(1e-12).unwrap_or_default();
        let contact = Contact { at: at + into * world.stylus.radius(), into, moving: into };
        self.touched.borrow_mut().push(contact);
    }
}

impl VirtualSensor for Seeker {
    type Kind = Seeking;

    fn aggregate(&mut self, order: &ReadingOrder<Line>) -> Result<Sought, Fault> {
        let arm = order
            .robot
            .ok_or_else(|| Fault::thrown("the way to the exit needs the state of an arm: write `of`"))?;
        let touch = self.probe.touch(&arm.pose.translation.vector)?;
        let (from, to) =
            (Vector2::from(order.configuration.from), Vector2::from(order.configuration.to));
        let now = arm.pose.translation.vector.xy();
        let before = self.before.replace(now).unwrap_or(now);
        if from == to {
            self.touches = touch.touches;
            return Ok(Sought { touch, is_on_way: true, ..Sought::default() });
        }
        let left = |at: &Vector2<f64>| (to - at).norm();
        if let Some(hit) = &mut self.hit {
            hit.gone += (now - before).norm();
            let beside = |at: &Vector2<f64>| (to - from).perp(&(at - from));
            let crosses = beside(&before) * beside(&now) <= 0.0 && before != now;
            // A millimetre at least, so that touches of one place come to an end.
            if crosses && left(&now) < left(&hit.at) - 1e-3 {
                self.hit = None;
            }
        }
        if touch.touches != self.touches {
            self.touches = touch.touches;
            let at = Vector2::new(touch.x, touch.y);
            self.note(at, now - before);
            self.hit.get_or_insert(Hit { at, gone: 0.0 });
        }
        let is_round =
            self.hit.is_some_and(|hit| hit.gone > self.least && (now - hit.at).norm() < self.same);
        let is_there = left(&now) < order.configuration.near;
        Ok(Sought { touch, is_on_way: self.hit.is_none(), is_there, is_round })
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
