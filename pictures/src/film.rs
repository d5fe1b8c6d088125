//! The film: watches a cell, then draws what it saw.

use std::cell::RefCell;
use std::io;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use mrroc::cell::RunPicture;
use mrroc::observe::Observation;
use mrroc::observe::solid::ObstacleLayout;
use mrroc::observe::step_observer::SharedStepObserver;
use mrroc::prelude::*;

use crate::block::Block;
use crate::history::History;
use crate::instructions::Log;
use crate::page;
use crate::seen::{Seen, Sights};

/// Watches every robot of a cell and draws one self-contained SVG of what moved.
///
/// Memory is bounded: at most 4000 samples of each robot and each sensor are kept, evenly over the run, however long it is.
/// Largest following errors, joint ranges, and the least and greatest numbers of readings are those of the whole run.
///
/// ```no_run
/// # fn cell() -> mrroc::cell::Cell { mrroc::cell::Cell::new(std::time::Duration::from_millis(2)) }
/// use mrroc::cell::RunPicture;
/// use mrroc_pictures::Film;
///
/// let mut film = Film::new();
/// let outcome = film.watch(cell()).run();
/// film.save("picture.svg".as_ref())?; // after a fault, too
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct Film {
    histories: Rc<RefCell<Vec<History>>>,
    /// Where the flanges of the robots are, for those that are mounted on them.
    flanges: Rc<RefCell<Vec<(String, Pose)>>>,
    blocks: Rc<RefCell<Vec<Block>>>,
    /// What stands in the cell.
    obstacles: Vec<ObstacleLayout>,
    /// What the MP's program did.
    program: Rc<RefCell<Log>>,
    left_out: Rc<Vec<String>>,
    /// What the processes of the cell showed.
    seen: Arc<Seen>,
}

impl Film {
    /// A film that has seen nothing yet.
    #[must_use]
    pub fn new() -> Film {
        Film::default()
    }

    /// The same film with a body that the robots handle, drawn as a block of these edges along x, y, z \[m\] about its frame,
    /// which is at the pose `X_WB` that `pose` tells whenever a robot is observed.
    #[must_use]
    pub fn with_block(self, edges: [f64; 3], pose: impl FnMut() -> Pose + 'static) -> Film {
        if let Ok(mut blocks) = self.blocks.try_borrow_mut() {
            blocks.push(Block::new(edges, Box::new(pose)));
        }
        self
    }

    /// The same film without the robots of these names: hands, say, that are on the arms which are drawn.
    #[must_use]
    pub fn without(self, robots: &[&str]) -> Film {
        Film { left_out: Rc::new(robots.iter().map(|&name| name.to_owned()).collect()), ..self }
    }

    /// The picture of what was seen so far, an SVG document of 1200 px width.
    ///
    /// The same observations give the same text to the byte.
    #[must_use]
    pub fn svg(&self) -> String {
        match (self.histories.try_borrow(), self.blocks.try_borrow(), self.program.try_borrow()) {
            (Ok(histories), Ok(blocks), Ok(program)) => {
                page::svg(&histories, &blocks, &self.obstacles, &program, &self.seen.sights())
            }
            // Only while a robot is being observed, that is, inside of an observer of the user's.
            _ => page::svg(&[], &[], &[], &Log::default(), &Sights::default()),
        }
    }
}

impl RunPicture for Film {
    fn watch(&mut self, cell: Cell) -> Cell {
        let histories = Rc::clone(&self.histories);
        let flanges = Rc::clone(&self.flanges);
        let blocks = Rc::clone(&self.blocks);
        let program = Rc::clone(&self.program);
        let left_out = Rc::clone(&self.left_out);
        let layout = cell.layout();
        self.seen.expect(&layout);
        self.obstacles = layout.obstacles;
        let cell = cell.shown_to_picture(Arc::clone(&self.seen) as SharedStepObserver);
        cell.watch(move |observation| {
            let drawn = left_out.iter().all(|name| name != observation.robot);
            if let Ok(mut program) = program.try_borrow_mut() {
                program.observe(observation.time, &observation.mp());
            }
            observe(&histories, &flanges, observation, drawn);
            if drawn && let Ok(mut blocks) = blocks.try_borrow_mut() {
                blocks.iter_mut().for_each(|block| block.observe(observation.time));
            }
        })
    }

    fn save(&mut self, file: &Path) -> io::Result<()> {
        std::fs::write(file, self.svg())
    }
}

#[allow(non_snake_case)]
fn observe(
    histories: &RefCell<Vec<History>>,
    flanges: &RefCell<Vec<(String, Pose)>>,
    observation: &Observation<'_>,
    drawn: bool,
) {
    let (Ok(mut histories), Ok(mut flanges)) = (histories.try_borrow_mut(), flanges.try_borrow_mut()) else {
        return;
    };
    let flange_of = |robot: &str| flanges.iter().find(|(name, _)| name == robot).map(|(_, flange)| *flange);
    let X_WM = match observation.mounted_on {
        None => Pose::identity(),
        // What carries it is observed in the same servo period, but perhaps after it.
        Some(carrier) => match flange_of(carrier) {
            Some(flange) => flange,
            None => return,
        },
    };
    let mut unseen = History::new(observation.robot, observation.kind, observation.joints);
    let known = histories.iter().position(|history| history.name == observation.robot);
    let flange = match known {
        Some(place) => histories[place].observe(observation, &X_WM),
        None => unseen.observe(observation, &X_WM),
    };
    if drawn && known.is_none() {
        histories.push(unseen);
    }
    match flanges.iter_mut().find(|(name, _)| name == observation.robot) {
        Some((_, place)) => *place = flange,
        None => flanges.push((observation.robot.to_owned(), flange)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::observe::{Activity, Shown};
    use mrroc::robot::JointKind;
    use nalgebra::Vector3;

    fn seen(film: &Film, robot: &str, mounted_on: Option<&str>, time: f64, frames: &[Pose], drawn: bool) {
        let tool = frames[frames.len() - 1] * Pose::translation(0.0, 0.0, 0.1);
        let observation = Observation {
            robot,
            kind: "kind",
            time,
            demanded: &[0.0],
            measured: &[0.0],
            joints: &[JointKind::Revolute],
            mounted_on,
            frames: &|visit| frames.iter().for_each(&mut *visit),
            tool,
            mp: &Shown::new(Activity::default()),
            ecp: &Shown::new(Activity::default()),
        };
        observe(&film.histories, &film.flanges, &observation, drawn);
    }

    fn places(film: &Film, robot: &str) -> Vec<Vec<Vector3<f64>>> {
        let histories = film.histories.borrow();
        let history = histories.iter().find(|history| history.name == robot);
        history.map_or_else(Vec::new, |history| {
            history.samples().iter().map(|sample| sample.links.clone()).collect()
        })
    }

    /// A quarter of a turn about z takes the hand's x to y: the hand stands on the flange, the finger on the hand.
    #[test]
    fn a_hand_is_drawn_on_the_flange_that_carries_it_as_soon_as_that_was_seen() {
        let film = Film::new();
        let at = |x: f64| {
            Pose::translation(x, 0.0, 1.0) * Pose::rotation(Vector3::z() * core::f64::consts::FRAC_PI_2)
        };
        let hand = [Pose::translation(0.0, 0.0, 0.05), Pose::translation(0.04, 0.0, 0.05)];
        seen(&film, "hand", Some("arm"), 0.0, &hand, true);
        assert!(places(&film, "hand").is_empty(), "where the arm is, nobody knows yet");
        for (step, x) in [(1.0, 0.5), (2.0, 0.6)] {
            seen(&film, "arm", None, step, &[Pose::identity(), at(x)], true);
            seen(&film, "hand", Some("arm"), step, &hand, true);
            // On the hand's finger, a second one.
            seen(&film, "finger", Some("hand"), step, &[Pose::translation(0.0, 0.0, 0.01)], true);
        }
        let near = |found: &[Vector3<f64>], expected: &[[f64; 3]]| {
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - Vector3::from(*expected)).norm() < 1e-12, "{found} {expected:?}");
            }
        };
        // What is mounted has no foot on the floor.
        let mounted = |robot: &str| {
            film.histories
                .borrow()
                .iter()
                .find(|history| history.name == robot)
                .is_some_and(|found| found.is_mounted)
        };
        assert_eq!(["arm", "hand", "finger"].map(mounted), [false, true, true]);
        let hand = places(&film, "hand");
        near(&hand[0], &[[0.5, 0.0, 1.05], [0.5, 0.04, 1.05]]);
        near(&hand[1], &[[0.6, 0.0, 1.05], [0.6, 0.04, 1.05]]);
        near(&places(&film, "finger")[1], &[[0.6, 0.04, 1.06]]);
    }

    #[test]
    fn an_arm_that_is_not_drawn_carries_a_hand_that_is() {
        let film = Film::new();
        seen(&film, "arm", None, 1.0, &[Pose::identity(), Pose::translation(0.3, 0.0, 0.0)], false);
        seen(&film, "hand", Some("arm"), 1.0, &[Pose::identity()], true);
        assert!(places(&film, "arm").is_empty());
        assert_eq!(places(&film, "hand"), [[Vector3::new(0.3, 0.0, 0.0)]]);
    }
}
