//! Whether an arm's own links meet, by the collision shapes of its URDF.

use mrroc_robots::clearance::{Clearance, Stop, Stopping};
use mrroc_robots::models::{Meshes, SerialOutline};

use super::robot::{Described, of_urdf};

impl Described {
    /// The clearance of the arm's own links.
    ///
    /// # Errors
    /// Why nothing is known of its shape.
    pub fn own_clearance(&self) -> Result<Clearance, String> {
        match self.chain.joints.len() {
            1 => self.clearance_of::<1>(),
            2 => self.clearance_of::<2>(),
            3 => self.clearance_of::<3>(),
            4 => self.clearance_of::<4>(),
            5 => self.clearance_of::<5>(),
            6 => self.clearance_of::<6>(),
            7 => self.clearance_of::<7>(),
            _ => self.clearance_of::<8>(),
        }
    }

    fn clearance_of<const N: usize>(&self) -> Result<Clearance, String> {
        let urdf = self.urdf.as_ref().ok_or("a table of Denavit-Hartenberg parameters has no shapes")?;
        let told = |why: &dyn core::fmt::Display| why.to_string();
        let robot = of_urdf::<N>(&urdf.text, &urdf.base, &urdf.tip).map_err(|why| told(&why))?;
        let outline = SerialOutline::from_urdf(robot, &urdf.text, &urdf.base, &urdf.tip, &Meshes::refused());
        let outline = outline.map_err(|why| told(&why))?;
        let at_rest = Stopping { reaction: 0.0, stop: Stop::Braking };
        let builder = Clearance::with_margin(0.0).robot("arm", outline).map_err(|why| told(&why))?;
        let clearance = builder.build(at_rest).map_err(|why| told(&why))?;
        if clearance.pairs() == 0 {
            return Err("none of its links can meet another by their shapes".to_owned());
        }
        Ok(clearance)
    }
}
