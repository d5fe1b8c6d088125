//! The coordinator's program: a way out of a maze, by a map that grows with each touch. It is the same for all effectors and sensors.

use core::marker::PhantomData;
use std::cell::RefCell;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_generators::generators::ConstantOrder;
use mrroc_map::{Knowledge, Map, Place, Planner, Region};
use nalgebra::{Point3, Vector2};

use crate::feeling::Feeling;
use crate::orders::{Have, Task, Went};
use crate::places::Sizes;

/// What the coordinator is told of a maze.
#[derive(Clone, Debug)]
pub struct Told {
    /// Where the ball begins [m, M].
    pub start: Place,
    /// Where it is to go [m, M].
    pub goal: Region,
    /// How many touches are too many: the maze has no way that can be found.
    pub most: usize,
    /// What is known of all mazes of this kind.
    pub known: Knowledge,
    /// How the effector goes.
    pub sizes: Sizes,
}

/// The sensor touches nothing.
struct Free<R, S>(PhantomData<(R, S)>);

#[condition(mp)]
fn free<R: Robot, S: Feeling<R>>(c: &mut Free<R, S>, v: &Reading<(S,)>) -> bool {
    let Free(PhantomData) = c;
    v.0.reading().is_some_and(|reading| !S::touch(&reading).touching)
}

/// Plans a leg, has the effector go it until it touches something, and learns what it touched; until it is at the goal. `find` is how
/// this effector learns where the maze stands, and comes to the start.
///
/// # Errors
/// The first fault of the cell; no way is left.
pub fn coordinate<R: Robot, S: Feeling<R>>(
    mp: &mut Mp,
    [robot, sensor]: [&str; 2],
    told: &Told,
    find: impl Fn(&mut Have<'_>, &Told) -> Result<(Pose, Went), Fault>,
    map: &Rc<RefCell<Map>>,
) -> Result<(), Fault> {
    let (mut robot, mut sensor) = (mp.robot::<R>(robot)?, mp.sensor::<S>(sensor)?);
    let mut touches = 0;
    let mut have = |task: Task| -> Result<Went, Fault> {
        mp.move_robots((&mut robot,), (), ConstantOrder::<(R,), Task>::to_all(task))?;
        mp.wait_until((&mut robot,), (&mut sensor,), Free::<R, S>(PhantomData))?;
        let reading = sensor.reading().ok_or_else(|| Fault::thrown("the sensor has no reading"))?;
        let touch = S::touch(&reading);
        let is_new = core::mem::replace(&mut touches, touch.touches) != touch.touches;
        let touched = is_new.then(|| Vector2::new(touch.x, touch.y));
        Ok(Went { at: S::place(&reading, &robot), touched, met: S::met(&reading), seen: S::seen(&reading) })
    };
    let (maze, went) = find(&mut have, told)?;
    let there = |place: &Place| (maze * Point3::new(place.x, place.y, 0.0)).coords.xy();
    let back = |at: &Vector2<f64>| maze.inverse_transform_point(&Point3::new(at.x, at.y, 0.0)).coords.xy();
    let mut at = went.at;
    while told.goal.distance(&back(&at)) > 0.0 {
        // Where walls are not known well enough for the whole margin, with less of it, or less than the effector needs: it feels them anyway.
        let keeping = |share: f64| {
            Planner::of(&told.known, share * told.sizes.margin).way(&map.borrow(), &back(&at), &told.goal)
        };
        let way = [1.0, 0.3, -0.5].into_iter().find_map(keeping);
        let Some(way) = way.filter(|_| map.borrow().contacts().len() < told.most) else {
            return Err(Fault::thrown(
                "no way to the exit is left by what was touched: look at the maze, or tell another exit",
            ));
        };
        let leg = there(&way[1]);
        let went = have(Task::Go { x: leg.x, y: leg.y })?;
        let end = went.touched.map_or(went.at, |touch| touch - (leg - at).normalize() * told.sizes.back);
        map.borrow_mut().pass(&back(&at), &back(&end));
        if let Some(touch) = went.touched {
            let (ball, moving) = (back(&touch), back(&leg) - back(&at));
            match went.met {
                Some(met) => map.borrow_mut().meet(&ball, &back(&met), &moving),
                None => map.borrow_mut().touch(&ball, &moving),
            };
        }
        for face in went.seen.iter().flatten() {
            let into = maze.rotation.inverse() * face.into.push(0.0);
            map.borrow_mut().see(&back(&face.ends[0]), &back(&face.ends[1]), &into.xy());
        }
        at = went.at;
    }
    Ok(())
}
