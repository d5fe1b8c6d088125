//! A progress bar on stderr: how many parts have come and gone.

use core::cell::Cell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use mrroc_robots::grasp::{Whereabouts, World};

/// The bar. It looks at the clock every few hundred steps.
#[derive(Clone, Debug)]
pub struct Progress {
    world: World,
    parts: usize,
    shown: Rc<Cell<bool>>,
}

/// Steps between looks at the clock.
const LOOK_EVERY: u32 = 512;
/// Cells of the bar.
const CELLS: usize = 28;

impl Progress {
    /// Of so many parts in a world; nothing is shown yet.
    #[must_use]
    pub fn of(world: World, parts: usize) -> Self {
        Self { world, parts, shown: Rc::default() }
    }

    /// From now on it is shown.
    pub fn show(&self) {
        self.shown.set(true);
    }

    /// Looks after each step.
    pub fn look(&self) -> impl FnMut() + 'static {
        let Self { world, parts, shown } = self.clone();
        let (mut left, mut last) = (LOOK_EVERY, Instant::now());
        move || {
            left -= 1;
            if left > 0 {
                return;
            }
            left = LOOK_EVERY;
            if shown.get() && last.elapsed() > Duration::from_millis(200) {
                last = Instant::now();
                let is_gone =
                    |part: &usize| matches!(world.whereabouts(*part), Some(Whereabouts::Gone { .. }));
                let gone = (0..parts).filter(is_gone).count();
                let full = CELLS * gone / parts.max(1);
                let (done, open) = ("#".repeat(full), ".".repeat(CELLS - full));
                eprint!("\r[{done}{open}] {gone} of {parts} parts, {:.0} s", world.time());
            }
        }
    }

    /// Takes the bar away.
    pub fn end(&self) {
        if self.shown.get() {
            eprint!("\r{:79}\r", "");
        }
    }
}
