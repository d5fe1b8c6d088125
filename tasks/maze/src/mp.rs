//! The coordinator's program: it finds the maze, and then the way out of it, by a map that grows with each touch.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_generators::generators::ConstantOrder;
use mrroc_map::{Map, Place, Planner, Region};
use mrroc_robots::Irp6;
use nalgebra::{Point3, Vector2};

use crate::found::found;
use crate::orders::Task;
use crate::places::{BACK, BALL, MIDDLE, THICKNESS, said};
use crate::plant::TouchProbe;

/// What the coordinator is told of a maze.
#[derive(Clone, Debug)]
pub struct Told {
    /// Where the ball begins [m, M].
    pub start: Place,
    /// Where it is to go [m, M].
    pub goal: Region,
    /// How many touches are too many: the maze has no way that can be found.
    pub most: usize,
}

/// The probe touches nothing.
#[condition(mp)]
fn free(v: &Reading<(TouchProbe,)>) -> bool {
    v.0.reading().is_some_and(|touch| !touch.touching)
}

/// Plans a leg, has the arm go it until it touches something, and learns what it touched; until the ball is at the goal.
///
/// # Errors
/// The first fault of the cell; no way is left.
pub fn coordinate(mp: &mut Mp, told: &Told, map: &Rc<RefCell<Map>>) -> Result<(), Fault> {
    let (mut arm, mut probe) = (mp.robot::<Irp6>("arm")?, mp.sensor::<TouchProbe>("probe")?);
    let mut touches = 0;
    // Has a task carried out: where the ball is then, and where it touched, if it did [m, W].
    let mut have = |task: Task| -> Result<(Vector2<f64>, Option<Vector2<f64>>), Fault> {
        mp.move_robots((&mut arm,), (), ConstantOrder::<(Irp6,), Task>::to_all(task))?;
        mp.wait_until((&mut arm,), (&mut probe,), free {})?;
        let touch = probe.reading().unwrap_or_default();
        let is_new = core::mem::replace(&mut touches, touch.touches) != touch.touches;
        Ok((arm.demanded().pose.translation.vector.xy(), is_new.then(|| Vector2::new(touch.x, touch.y))))
    };
    let known = *map.borrow().knowledge();
    let [width, height] = known.size;
    let corner = said(known.size).translation;
    let mut sides = [Vector2::zeros(); 3];
    // Twice from the left, once from below: from 12 mm beside the frame, for 20 mm at most.
    let places = [(-0.012, 0.15 * height), (-0.012, 0.85 * height), (0.5 * width, -0.012)];
    for (side, (x, y)) in sides.iter_mut().zip(places) {
        let from = [corner.x + x, corner.y + y];
        let to = if x < 0.0 { [0.02, 0.0] } else { [0.0, 0.02] };
        have(Task::Hop { x: from[0], y: from[1] })?;
        let (_, touch) = have(Task::Go { x: from[0] + to[0], y: from[1] + to[1] })?;
        *side = touch.ok_or_else(|| {
            Fault::thrown("the maze is not where it is said to stand: look for it, and correct its place")
        })?;
    }
    let maze = found([sides[0], sides[1]], sides[2], BALL + 0.5 * THICKNESS, MIDDLE[2]);
    let there = |place: &Place| (maze * Point3::new(place.x, place.y, 0.0)).coords.xy();
    let back = |at: &Vector2<f64>| maze.inverse_transform_point(&Point3::new(at.x, at.y, 0.0)).coords.xy();
    let start = there(&told.start);
    let (mut at, _) = have(Task::Hop { x: start.x, y: start.y })?;
    while told.goal.distance(&back(&at)) > 0.0 {
        let way = Planner::default().way(&map.borrow(), &back(&at), &told.goal);
        let Some(way) = way.filter(|_| map.borrow().contacts().len() < told.most) else {
            return Err(Fault::thrown(
                "no way to the exit is left by what was touched: look at the maze, or tell another exit",
            ));
        };
        let leg = there(&way[1]);
        let (next, touch) = have(Task::Go { x: leg.x, y: leg.y })?;
        let end = touch.map_or(next, |touch| touch - (leg - at).normalize() * BACK);
        map.borrow_mut().pass(&back(&at), &back(&end));
        if let Some(touch) = touch {
            map.borrow_mut().touch(&back(&touch), &(back(&leg) - back(&at)));
        }
        at = next;
    }
    Ok(())
}
