//! Moves a robot as a person jogs it.

use mrroc::operator::jog::{JogNow, JogOrder, JogPanel, JogStop};
use mrroc::prelude::*;

use mrroc_generators::jogging::{Ahead, JogLimits, JogPath, Run};

/// Moves a robot as a person at a console of the cell jogs it: its tool along or about axes of the tool, of the world or of a frame
/// that the cell names, single joints, or all joints to positions; as long as a button is held, or by increments. While the robot
/// stands, its outputs are switched as the person asks.
///
/// It checks the path ahead of the robot: before a joint comes to its limit, before the arm is stretched out or near a
/// singularity, the robot comes to rest without a fault, and the panel is told why. The motion ends when the person says that
/// jogging is done.
///
/// ```
/// use mrroc::operator::jog::{JogNow, JogOrder, JogPanel};
/// use mrroc::prelude::*;
/// use mrroc_generators::generators::PanelJog;
/// use mrroc_generators::rehearsal::rehearse_all;
/// use mrroc_generators::conformance::Given;
/// use mrroc_generators::rehearsal::at_rest;
/// use mrroc_robots::Irp6;
///
/// let irp6 = Irp6::nominal();
/// // In a cell the panel is `ecp.jog_panel()`. A person jogs by 30 mm down, along the world's z axis, and is done after 2 s.
/// let (panel, seat) = JogPanel::alone(irp6.clone());
/// let down = JogOrder::read(&mut "world z -100% by 0.03".split_whitespace())?;
/// let e = at_rest(&irp6, Irp6::READY);
/// let mut steps = 0;
/// let demands = rehearse_all(PanelJog::by(panel), 0.002, |_| {
///     steps += 1;
///     let held = JogNow::Order { press: 1, order: down };
///     seat.say(if steps < 1000 { held } else { JogNow::Done { press: 2 } });
///     Ok(Given { order: Order::new(()), e: State::new(e), v: Reading::new(()) })
/// })?;
/// let end = demands.last().and_then(Demand::as_joints).expect("joints");
/// let path = irp6.forward(&end).translation.vector - irp6.forward(&Irp6::READY).translation.vector;
/// assert!((path.z + 0.03).abs() < 1e-9 && path.xy().norm() < 1e-9, "{path}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PanelJog<R: Robot> {
    panel: JogPanel<R>,
    limits: JogLimits,
    /// The joints that were demanded last, and the tool in the flange, `X_FE`.
    joints: R::Joints,
    tool: Pose,
    jog: Option<Jogged<R>>,
}

/// One press of a button.
struct Jogged<R: Robot> {
    press: u64,
    order: JogOrder,
    path: JogPath<R>,
    ahead: Ahead<R>,
    run: Run,
}

impl<R: Robot> PanelJog<R> {
    /// By a panel of the robot, within [`JogLimits::default`].
    #[must_use]
    pub fn by(panel: JogPanel<R>) -> Self {
        Self::within(panel, JogLimits::default())
    }

    /// By a panel of the robot, within these limits.
    #[must_use]
    pub fn within(panel: JogPanel<R>, limits: JogLimits) -> Self {
        let joints = panel.model().limits().lower * 0.0;
        PanelJog { panel, limits, joints, tool: Pose::identity(), jog: None }
    }

    /// Another press of a button, of a robot that stands; why it does not move.
    fn begin(&mut self, press: u64, order: JogOrder) -> Option<JogStop> {
        let path = match JogPath::of(&order, &self.panel, self.joints, &self.tool) {
            Some(path) => path,
            None => return Some(JogStop::There),
        };
        let Some(ahead) = Ahead::of(&path, self.panel.model(), self.joints, &self.limits) else {
            return Some(JogStop::Kinematics);
        };
        self.jog = Some(Jogged { press, order, path, ahead, run: Run::default() });
        None
    }

    /// Goes on by `dt` \[s\] of path time; whether the robot stands.
    fn go(&mut self, now: JogNow, dt: f64) -> Result<bool, Fault> {
        let asked = match now {
            JogNow::Order { press, order } => Some((press, order)),
            JogNow::Nothing | JogNow::Done { .. } => None,
        };
        if let (None, Some((press, order))) = (&self.jog, asked)
            && let Some(stop) = self.begin(press, order)
        {
            self.panel.tell(stop);
        }
        let Some(jog) = &mut self.jog else {
            if asked.is_none() {
                self.panel.tell(JogStop::None);
            }
            return Ok(true);
        };
        if dt > 0.0 {
            // How fast may change while a button is held, and what is moved may not.
            let share = asked.filter(|(press, order)| {
                *press == jog.press
                    && order.motion == jog.order.motion
                    && order.distance == jog.order.distance
                    && order.speed.signum() == jog.order.speed.signum()
            });
            let model = self.panel.model();
            jog.ahead.look(&jog.path, model, jog.run.at(), &self.limits);
            jog.run.go(&jog.ahead, share.map(|(_, order)| order.speed.abs()), dt)?;
            let joints = jog.path.joints(model, jog.run.at(), &self.joints);
            self.joints =
                joints.ok_or_else(|| Fault::thrown("the arm cannot follow a path that was clear"))?;
            let rests = jog.run.rests();
            let stop = if rests { jog.ahead.bound().unwrap_or_default() } else { JogStop::None };
            self.panel.tell(if share.is_some() { stop } else { JogStop::None });
            if rests && share.is_none() {
                self.jog = None;
            }
            return Ok(rests);
        }
        // The operator's rate has stopped the robot. What is asked for still goes on as it was; anything else begins at rest.
        if asked.is_none_or(|(press, _)| press != jog.press) {
            self.jog = None;
            self.panel.tell(JogStop::None);
        }
        Ok(true)
    }
}

#[generator(ecp)]
impl<R: Robot> PanelJog<R> {
    fn first_step(&mut self, e: &State<R>, t: Tick) -> Result<Step<R>, Fault> {
        if !self.limits.is_sound() {
            return Err(Fault::thrown(
                "the limits of jogging must be finite and > 0, the share of the joints below 1",
            ));
        }
        let here = e.demanded();
        self.joints = here.joints;
        self.tool = self.panel.model().forward(&here.joints).inv_mul(&here.pose);
        self.next_step(t)
    }

    fn next_step(&mut self, t: Tick) -> Result<Step<R>, Fault> {
        let now = self.panel.now();
        let rests = self.go(now, t.dt)?;
        let demand = Demand::joints(self.joints);
        Ok(match now {
            JogNow::Done { .. } if rests => Step::Done,
            // A robot that still comes to rest from another press is waited for.
            JogNow::Order { order, .. } if self.jog.is_none() => {
                Step::Next(self.panel.switched(demand, &order))
            }
            JogNow::Order { .. } | JogNow::Done { .. } | JogNow::Nothing => Step::Next(demand),
        })
    }
}
