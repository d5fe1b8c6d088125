//! One constant for every robot of a list: the coordinator's half of loose cooperation.

use mrroc::generator::Uses;
use mrroc::generator::{Class, Generator, Level, Motion, RobotList, Robots, RobotsEach};
use mrroc::prelude::*;

/// Orders or demands the same in every step, `f**() = const`: a phase of loose cooperation, a force to be kept, a
/// demand. Each robot of the list may get another order. The motion ends when every ECP of the list has finished.
///
/// ```
/// use mrroc::generator::Generator;
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::ConstantOrder;
/// use mrroc_generators::rehearsal::at_rest;
/// use mrroc_robots::{Irp6, Six};
///
/// #[derive(Clone, Copy, Debug, PartialEq, Payload)]
/// enum Phase {
///     Approach,
///     Grasp,
/// }
///
/// let mut order = ConstantOrder::<[Irp6; 2], Phase>::separate([Phase::Grasp, Phase::Approach]);
/// # let e = State::new([at_rest(&Irp6::nominal(), Six::zeros()); 2]);
/// # let t = Tick { step: 0, dt: 0.002, duration: 0.002 };
/// let told = order.next_step(&Order::new(()), &e, &Reading::new(()), t)?;
/// assert_eq!(told, Step::Next([Phase::Grasp, Phase::Approach]));
/// # Ok::<(), Fault>(())
/// ```
pub struct ConstantOrder<L: Robots<O>, O = Motion>(L::Demands);

impl<L: Robots<O>, O: 'static> ConstantOrder<L, O> {
    /// The same `order` for all robots.
    #[must_use]
    pub fn to_all<T: Clone>(order: T) -> Self
    where
        L: RobotsEach<T, O>,
    {
        ConstantOrder(L::each(|_| order.clone()))
    }

    /// One order for each robot, in the form of the list: `(Phase::Grasp, Phase::Wait)`.
    #[must_use]
    pub fn separate(orders: L::Demands) -> Self {
        ConstantOrder(orders)
    }
}

// By hand: what it tells is no state in the sense of the classes, as it never changes.
impl<L: Robots<O>, O: 'static> Generator for ConstantOrder<L, O> {
    type Robots = L;
    type Language = O;
    type Sensors = ();
    type Order = ();
    const CLASS: Class = Class::new(Level::Mp, Uses::NOTHING);
    const ENDS: bool = false;

    fn first_step(
        &mut self,
        _: &Order<()>,
        _: &State<L>,
        _: &Reading<()>,
        _: Tick,
    ) -> Result<Step<L, O>, Fault> {
        const { assert!(<L as RobotList>::LEN > 0, "a constant order needs a robot to receive it") };
        Ok(Step::Next(self.0))
    }

    fn next_step(
        &mut self,
        c0: &Order<()>,
        e: &State<L>,
        v: &Reading<()>,
        t: Tick,
    ) -> Result<Step<L, O>, Fault> {
        self.first_step(c0, e, v, t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc_generators::generators::JointMove;
    use mrroc_robots::{Irp6, SimulatedIrp6, Six};
    use std::time::Duration;

    #[derive(Clone, Copy, Payload)]
    enum Phase {
        Turn,
        Stay,
    }

    #[test]
    fn robots_work_on_their_own_at_what_each_is_told() {
        let start = Irp6::READY;
        let drives = [0, 1].map(|_| SimulatedIrp6::new(Irp6::nominal(), &start));
        let shafts = drives.each_ref().map(|drive| drive.shaft());
        let [one, two] = drives.map(|drive| {
            move |name: &str| {
                RobotSetup::new(name, Irp6::nominal(), drive).program(move |ecp| {
                    ecp.serve(|ecp, phase: Phase| match phase {
                        Phase::Turn => {
                            let goal = start + Six::new(0.2, 0.0, 0.0, 0.0, 0.0, 0.0);
                            let turn = JointMove::to(goal, Six::repeat(0.4), Six::repeat(0.8));
                            ecp.move_robot((), turn).map(drop)
                        }
                        Phase::Stay => Ok(()),
                    })
                })
            }
        });
        let cell = Cell::new(Duration::from_millis(2)).robot(one("left")).robot(two("right"));
        let cell = cell.program(|mp| {
            let mut left = mp.robot::<Irp6>("left")?;
            let mut right = mp.robot::<Irp6>("right")?;
            let orders = ConstantOrder::<[Irp6; 2], Phase>::separate([Phase::Stay, Phase::Turn]);
            mp.move_robots([&mut left, &mut right], (), orders).map(drop)
        });
        cell.run().expect("within the limits");
        let turned = shafts.map(|shaft| shaft.state().position[0]);
        assert!(turned[0].abs() < 1e-3 && (turned[1] - 0.2).abs() < 1e-3, "{turned:?}");
    }
}
