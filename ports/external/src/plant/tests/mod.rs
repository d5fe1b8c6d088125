//! Robots of cells in a simulator of others, which is played by a thread of this process.

mod cells;
mod faults;
mod simulator;

use core::time::Duration;
use std::path::PathBuf;

use mrroc::cell::Cell;
use mrroc::prelude::*;
use mrroc_launch::cell_file::{CellFile, Kinds};
use mrroc_robots::{Irp6, Six, simulated};

use super::Plant;
use crate::port::prefix;

#[global_allocator]
static ALLOCATOR: mrroc_counting_allocator::Counting = mrroc_counting_allocator::Counting;

/// Two arms in one simulator, side by side, and what else the file says of their places there.
pub(super) fn two_arms(plant: &str) -> CellFile {
    let plant = format!("plant = {{ port = \"world\"{plant} }}");
    two_arms_of(&plant, &plant)
}

/// Two arms, and where each of them moves.
pub(super) fn two_arms_of(left: &str, right: &str) -> CellFile {
    let arm = "kind = \"irp6\"\nstart = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]";
    let text = format!(
        "step_ms = 2\n[robots.left]\n{arm}\n{left}\n[robots.right]\n{arm}\nbase = {{ xyz = [0.0, 3.0, 0.0] }}\n{right}"
    );
    CellFile::parse("cell.toml", &text).expect("nothing is wrong with it")
}

/// A folder of ports of one test.
pub(crate) struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Folder {
        Folder(std::env::temp_dir().join(format!("mrq{}-{name}", std::process::id())))
    }

    /// The simulated kinds, with simulators at ports of this folder.
    pub fn kinds(&self) -> Kinds {
        let folder = self.0.clone();
        simulated().plants(move |entry| Box::new(Plant::new(entry, folder.clone())))
    }

    /// The cell of a file, whose arms turn their columns.
    pub fn cell(&self, file: &CellFile) -> Cell {
        file.cell(&self.kinds()).expect("kinds are known").program(turn)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let names = std::fs::read_dir("/dev/shm").into_iter().flatten().flatten();
        let prefix = prefix(&self.0);
        let ours =
            names.filter(|entry| entry.file_name().to_str().is_some_and(|name| name.starts_with(&prefix)));
        ours.for_each(|entry| drop(std::fs::remove_file(entry.path())));
        drop(std::fs::remove_dir_all(&self.0));
    }
}

/// How long the motion takes.
pub(super) const MOTION: Duration = Duration::from_secs(1);

/// Turns the columns by 0.2 rad and by -0.2 rad, by a smoothstep.
fn turn(mp: &mut Mp) -> Result<(), Fault> {
    let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
    let from = [left.demanded().joints, right.demanded().joints];
    mp.move_robots((&mut left, &mut right), (), Turn { from, t: 0.0 })?;
    Ok(())
}

struct Turn {
    from: [Six; 2],
    t: f64,
}

#[generator(mp)]
fn turning(c: &mut Turn, t: Tick) -> Step<(Irp6, Irp6)> {
    if c.t >= MOTION.as_secs_f64() {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(MOTION.as_secs_f64());
    let u = c.t / MOTION.as_secs_f64();
    let s = 0.2 * u * u * (3.0 - 2.0 * u);
    let [mut left, mut right] = c.from;
    left[0] += s;
    right[0] -= s;
    Step::Next((Demand::joints(left), Demand::joints(right)))
}
