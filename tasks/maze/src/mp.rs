//! The coordinator's program: a path out of a maze, by a map that grows with each touch. It is the same for all effectors and sensors.

use core::marker::PhantomData;
use std::cell::RefCell;
use std::rc::Rc;

use mrroc::generator::{RobotHandle, SensorHandle};
use mrroc::prelude::*;
use mrroc_generators::generators::ConstantOrder;
use mrroc_map::{Knowledge, Map, Place, Planner, Region};
use nalgebra::{Point3, Vector2};

use crate::feeling::Feeling;
use crate::orders::{Task, TaskOutcome, TaskRunner};
use crate::places::Sizes;

/// What the coordinator is told of a maze.
#[derive(Clone, Debug)]
pub struct MazeSettings {
    /// Where the ball begins [m, M].
    pub start: Place,
    /// Where it is to go [m, M].
    pub goal: Region,
    /// How many touches are too many: the maze has no path that can be found.
    pub most: usize,
    /// What is known of all mazes of this kind.
    pub known: Knowledge,
    /// How the effector goes.
    pub sizes: Sizes,
}

const NO_PATH: &str =
    "no path to the exit is left by what was touched: look at the maze, or tell another exit";

/// The sensor touches nothing.
struct Free<R, S>(PhantomData<(R, S)>);

#[condition(mp)]
fn free<R: Robot, S: Feeling<R>>(c: &mut Free<R, S>, v: &Reading<(S,)>) -> bool {
    let Free(PhantomData) = c;
    v.0.reading().is_some_and(|reading| !S::touch(&reading).touching)
}

/// Has the effector carry out a task, and waits until nothing is touched any more: what came of it. `touches` is how many there were.
///
/// # Errors
/// The first fault of the cell.
pub fn carried_out<R: Robot, S: Feeling<R>>(
    mp: &mut Mp,
    (robot, sensor): (&mut RobotHandle<R>, &mut SensorHandle<S>),
    touches: &mut u32,
    task: Task,
) -> Result<TaskOutcome, Fault> {
    mp.move_robots((&mut *robot,), (), ConstantOrder::<(R,), Task>::to_all(task))?;
    mp.wait_until((&mut *robot,), (&mut *sensor,), Free::<R, S>(PhantomData))?;
    let reading = sensor.reading().ok_or_else(|| Fault::thrown("the sensor has no reading"))?;
    let touch = S::touch(&reading);
    let is_new = core::mem::replace(touches, touch.touches) != touch.touches;
    let touched = is_new.then(|| Vector2::new(touch.x, touch.y));
    Ok(TaskOutcome { at: S::place(&reading, robot), touched, met: S::met(&reading), seen: S::seen(&reading) })
}

/// Plans a leg, has the effector go it until it touches something, and learns what it touched; until it is at the goal. `find` is how
/// this effector learns where the maze stands, and comes to the start.
///
/// # Errors
/// The first fault of the cell; no path is left.
pub fn coordinate<R: Robot, S: Feeling<R>>(
    mp: &mut Mp,
    [robot, sensor]: [&str; 2],
    told: &MazeSettings,
    find: impl Fn(&mut TaskRunner<'_>, &MazeSettings) -> Result<(Pose, TaskOutcome), Fault>,
    map: &Rc<RefCell<Map>>,
) -> Result<(), Fault> {
    let (mut robot, mut sensor) = (mp.robot::<R>(robot)?, mp.sensor::<S>(sensor)?);
    let mut touches = 0;
    let mut run = |task: Task| carried_out(mp, (&mut robot, &mut sensor), &mut touches, task);
    let (maze, went) = find(&mut run, told)?;
    let there = |place: &Place| (maze * Point3::new(place.x, place.y, 0.0)).coords.xy();
    let back = |at: &Vector2<f64>| maze.inverse_transform_point(&Point3::new(at.x, at.y, 0.0)).coords.xy();
    let mut at = went.at;
    while told.goal.distance(&back(&at)) > 0.0 {
        // Where walls are not known well enough for the whole margin, with less of it, or less than the effector needs: it feels them anyway.
        let keeping = |share: f64| {
            Planner::of(&told.known, share * told.sizes.margin).path(&map.borrow(), &back(&at), &told.goal)
        };
        let path = [1.0, 0.3, -0.5].into_iter().find_map(keeping);
        let Some(path) = path.filter(|_| map.borrow().contacts().len() < told.most) else {
            return Err(Fault::thrown(NO_PATH));
        };
        let leg = there(&path[1]);
        let went = run(Task::Go { x: leg.x, y: leg.y })?;
        // Where the ball slid, it went from there to there; else straight to where it is, or to short of what it touched.
        let slid = went.seen.iter().flatten().filter(|_| S::TELLS_FACES);
        let mut from = back(&at);
        for face in slid {
            let [begin, end] = face.ends.map(|end| back(&end));
            map.borrow_mut().pass(&from, &begin);
            map.borrow_mut().pass(&begin, &end);
            map.borrow_mut().slide(&begin, &end, &face.inward(&maze));
            from = end;
        }
        let touched = went.touched.filter(|_| !S::TELLS_FACES);
        let end = touched.map_or(went.at, |touch| touch - (leg - at).normalize() * told.sizes.back);
        map.borrow_mut().pass(&from, &back(&end));
        if let Some(touch) = touched {
            let (ball, moving) = (back(&touch), back(&leg) - back(&at));
            match went.met {
                Some(met) => map.borrow_mut().meet(&ball, &back(&met), &moving),
                None => map.borrow_mut().touch(&ball, &moving),
            };
        }
        for face in went.seen.iter().flatten().filter(|_| !S::TELLS_FACES) {
            map.borrow_mut().see(&back(&face.ends[0]), &back(&face.ends[1]), &face.inward(&maze));
        }
        at = went.at;
    }
    Ok(())
}
