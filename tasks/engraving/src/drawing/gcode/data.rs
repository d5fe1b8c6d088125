//! Words that place coordinate systems and the tool's home: G10, G28, G30, G52, G92.

use super::block::Block;
use super::machine::Machine;
use super::modes::Request;
use super::stop::{Stop, malformed, unsupported};
use crate::drawing::Vec3;

impl Machine<'_> {
    /// Carries out a word that moves no tool, or sends it home.
    pub(super) fn set(&mut self, request: Request, block: &Block, byte: usize) -> Result<(), Stop> {
        match request {
            Request::SetData => return self.set_data(block, byte),
            Request::Home(which) => return self.go_home(which, block),
            Request::StoreHome(which) => self.homes[which] = self.tool,
            Request::ForgetShift => self.coordinates.forget_shift(),
            Request::PutShiftBy => self.coordinates.keep_shift(false),
            Request::RestoreShift => self.coordinates.keep_shift(true),
            Request::Shift | Request::ShiftHere => {
                if !block.has("xyz") {
                    return malformed(byte, "a shift without X, Y or Z", "give the axes that it is for");
                }
                // An axis that is not given keeps its coordinate (NIST RS274/NGC 3.5.18).
                for (axis, mm) in self.axes(block) {
                    match request {
                        Request::Shift => self.coordinates.shift_by(axis, mm),
                        _ => self.coordinates.shift_here(axis, self.tool[axis], mm),
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// The axis words of a line \[mm\].
    fn axes(&self, block: &Block) -> Vec<(usize, f64)> {
        let letters = ['x', 'y', 'z'].into_iter().enumerate();
        letters.filter_map(|(axis, letter)| Some((axis, block.value(letter)? * self.scale()))).collect()
    }

    fn set_data(&mut self, block: &Block, byte: usize) -> Result<(), Stop> {
        let Some(kind) = block.value('l') else {
            return malformed(byte, "G10 without L", "L2 or L20 place a coordinate system");
        };
        if !(kind == 2.0 || kind == 20.0) {
            block.take("pxyzrijq");
            self.warn_once(
                "G10",
                &format!("G10 L{kind} left out: it is about a table of tools, and the arm has one"),
            );
            return Ok(());
        }
        let system = match block.value('p') {
            Some(0.0) => self.coordinates.active,
            Some(n) if n.fract() == 0.0 && (1.0..=9.0).contains(&n) => n as usize - 1,
            _ => return malformed(byte, "G10 without its system", "P is 0 for the active one, or 1 to 9"),
        };
        if block.value('r').is_some_and(|angle| angle != 0.0) {
            return unsupported(
                byte,
                "G10 with R: a turned coordinate system",
                "export the program without it",
            );
        }
        for (axis, mm) in self.axes(block) {
            if mm.abs() >= 1e7 {
                return malformed(byte, format!("an origin at {mm} mm"), "origins lie within 10 000 000 mm");
            }
            if kind == 2.0 {
                self.coordinates.set_origin(system, axis, mm);
            } else {
                self.coordinates.set_here(system, axis, self.tool[axis], mm);
            }
        }
        Ok(())
    }

    /// G28, G30: away, through the place of the line; home is the machine's zero unless G28.1 or G30.1 stored one. How
    /// high it is, the program does not say: the tool is lifted there.
    fn go_home(&mut self, which: usize, block: &Block) -> Result<(), Stop> {
        let axes: Vec<usize> = (0..3).filter(|axis| block.has(["x", "y", "z"][*axis])).collect();
        let through = self.target(block, false)?;
        let (name, home) = (["G28", "G30"][which], self.homes[which]);
        self.warn_once(name, &format!("{name}: the tool lifts and goes home; what is cut next begins there"));
        self.push_away()?;
        let mut to = through;
        for axis in 0..2 {
            if axes.is_empty() || axes.contains(&axis) {
                to[axis] = home[axis];
            }
        }
        self.tool = Vec3::new(to.x, to.y, to.z.max(1.0));
        Ok(())
    }
}
