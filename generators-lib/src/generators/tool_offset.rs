//! Moves the tool by an offset from its demanded pose, without knowing that pose.

use core::marker::PhantomData;

use mrroc::prelude::*;

use mrroc_generators::line::{LinePath, ToolLimits};
use mrroc_generators::profile::ProfileCursor;

/// Moves the tool straight by an offset in its own axes, by one trapezoidal profile. It needs no feedback: it demands
/// displacements from the pose demanded at the start of the motion, which the EDP knows.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::ToolOffset;
/// use mrroc_generators::line::ToolLimits;
/// use mrroc_generators::profile::ProfileLimits;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
///
/// let limits = ProfileLimits { velocity: 0.1, acceleration: 0.1 };
/// let limits = ToolLimits { translation: limits, rotation: limits };
/// let offset = Pose::translation(0.0, 0.0, 0.1);
/// let demands = rehearse(ToolOffset::by(offset, limits), &Irp6::nominal(), Irp6::READY, 0.002)?;
/// // D / V + V / A = 2 s.
/// assert_eq!((demands.len(), demands[999]), (1000, Demand::displacement(offset)));
/// # Ok::<(), Fault>(())
/// ```
pub struct ToolOffset<R> {
    offset: Pose,
    limits: ToolLimits,
    path: Option<(LinePath, ProfileCursor)>,
    of: PhantomData<R>,
}

impl<R: Robot> ToolOffset<R> {
    /// By `X_EsE`, in the tool's axes at the start.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn by(X_EsE: Pose, limits: ToolLimits) -> Self {
        ToolOffset { offset: X_EsE, limits, path: None, of: PhantomData }
    }
}

#[generator(ecp)]
impl<R: Robot> ToolOffset<R> {
    fn first_step(&mut self, t: Tick) -> Result<Step<R>, Fault> {
        let line = LinePath::new(Pose::identity(), self.offset);
        let profile = line.profile(self.limits).map_err(|error| Fault::thrown(&error.to_string()))?;
        self.path = Some((line, ProfileCursor::new(profile)));
        Ok(self.next_step(t).with_goal(Demand::displacement(self.offset)))
    }

    fn next_step(&mut self, t: Tick) -> Step<R> {
        let Some((line, cursor)) = &mut self.path else { return Step::Done };
        match cursor.advance(t.dt) {
            Some(point) => Step::Next(Demand::displacement(line.pose(point.s))),
            None => Step::Done,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_generators::profile::ProfileLimits;
    use mrroc_robots::{Irp6, SimulatedIrp6, Six};
    use nalgebra::Vector3;
    use std::time::Duration;

    #[test]
    fn the_tool_goes_by_the_offset_from_wherever_it_is() {
        let irp6 = Irp6::nominal();
        let start = Six::new(0.1, -1.57, 0.16, -0.16, 4.71, 0.3);
        let arm = SimulatedIrp6::new(irp6.clone(), &start);
        let shaft = arm.shaft();
        let robot = RobotSetup::new("irp6", irp6.clone(), arm).program(|ecp| {
            let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 };
            let limits = ToolLimits { translation: limits, rotation: limits };
            ecp.move_robot((), ToolOffset::by(Pose::translation(0.01, 0.02, 0.05), limits)).map(drop)
        });
        Cell::new(Duration::from_millis(2)).robot(robot).run().expect("within the limits");
        let displacement = irp6.forward(&start).inv_mul(&irp6.forward(&shaft.state().position));
        let off = displacement.translation.vector - Vector3::new(0.01, 0.02, 0.05);
        assert!(off.norm() < 1e-3 && displacement.rotation.angle() < 1e-3, "{displacement}");
    }
}
