//! The film: watches a cell, then draws what it saw.

use std::cell::RefCell;
use std::io;
use std::path::Path;
use std::rc::Rc;

use mrroc::cell::RunPicture;
use mrroc::observe::Observation;
use mrroc::prelude::*;

use crate::block::Block;
use crate::history::History;
use crate::page;

/// Watches every robot of a cell and draws one self-contained SVG of what moved.
///
/// Memory is bounded: at most 4000 samples of each robot are kept, evenly over the run, however long it is. Largest
/// following errors and joint ranges are those of all servo periods.
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
    blocks: Rc<RefCell<Vec<Block>>>,
    left_out: Rc<Vec<String>>,
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
        match (self.histories.try_borrow(), self.blocks.try_borrow()) {
            (Ok(histories), Ok(blocks)) => page::svg(&histories, &blocks),
            // Only while a robot is being observed, that is, inside of an observer of the user's.
            _ => page::svg(&[], &[]),
        }
    }
}

impl RunPicture for Film {
    fn watch(&mut self, cell: Cell) -> Cell {
        let histories = Rc::clone(&self.histories);
        let blocks = Rc::clone(&self.blocks);
        let left_out = Rc::clone(&self.left_out);
        cell.watch(move |observation| {
            if left_out.iter().all(|name| name != observation.robot) {
                observe(&histories, observation);
                if let Ok(mut blocks) = blocks.try_borrow_mut() {
                    blocks.iter_mut().for_each(|block| block.observe(observation.time));
                }
            }
        })
    }

    fn save(&mut self, file: &Path) -> io::Result<()> {
        std::fs::write(file, self.svg())
    }
}

fn observe(histories: &RefCell<Vec<History>>, observation: &Observation<'_>) {
    let Ok(mut histories) = histories.try_borrow_mut() else { return };
    if let Some(history) = histories.iter_mut().find(|history| history.name == observation.robot) {
        history.observe(observation);
    } else {
        let mut history = History::new(observation.robot, observation.kind, observation.joints);
        history.observe(observation);
        histories.push(history);
    }
}
