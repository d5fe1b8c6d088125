//! How a robot regulates, when it takes something for a collision, and what it carries: told to it while it stands, before its
//! next motion.
//!
//! In: what a cell wants, and the robot's answers. Out: the next request, until the robot knows all of it.

use mrroc::robot::{DriveFault, Load, Regulators};

use crate::load;
use crate::message::{Collision, JOINTS, Request, Stiffness};

/// How many parameter sets of regulators there are.
pub const SETS: usize = 3;

/// What the robot knows, and what it is to know.
#[derive(Clone, Debug)]
pub(crate) struct Behaviour {
    collision: Option<Collision>,
    stiffness: [Option<Stiffness>; SETS],
    sets: Regulators,
    load: Option<Load>,
    knows_collision: bool,
    known: Option<Stiffness>,
    known_load: Option<Load>,
    /// The request that is to be answered, and the count of the state at which it was sent.
    asked: Option<(u32, Asked, u64)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Asked {
    Collision,
    Stiffness(Stiffness),
    Load(Load),
}

/// States, of a millisecond each, within which the robot answers.
const TIMEOUT: u64 = 2000;

const UNANSWERED: DriveFault = DriveFault::Other(
    "the robot does not answer what it is told of collisions, of its regulators and of its load",
);
const COLLISION_REFUSED: DriveFault = DriveFault::Other(
    "the robot refuses the thresholds of its collision behaviour: they are in `FciSettings`",
);
const STIFFNESS_REFUSED: DriveFault = DriveFault::Other(
    "the robot refuses the stiffness of its joints: it is in `FciSettings`, 0 to 14250 N m/rad",
);

/// The status `kCommandNotPossibleRejected` of libfranka.
const LOAD_IMPOSSIBLE: DriveFault =
    DriveFault::Other("the robot takes no load now: it moves, or does not stand with its brakes open");
const LOAD_REFUSED: DriveFault = DriveFault::Other(
    "the robot refuses the load that it is told: an FR3 carries 3 kg, its end effector of Desk among them",
);

impl Behaviour {
    /// What a robot that has just been connected is to know. Of its load it is told nothing where that was never said: what Desk
    /// says holds then.
    pub fn new(
        collision: Option<Collision>,
        stiffness: [Option<Stiffness>; SETS],
        sets: Regulators,
        load: Option<Load>,
    ) -> Behaviour {
        Behaviour {
            collision,
            stiffness,
            sets,
            load,
            knows_collision: false,
            known: None,
            known_load: None,
            asked: None,
        }
    }

    /// It carries another load.
    pub fn carry(&mut self, load: &Load) {
        self.load = Some(*load);
    }

    /// Other parameter sets of the regulators.
    pub fn choose(&mut self, sets: &Regulators) {
        self.sets = *sets;
    }

    /// The stiffness of the sets that are chosen; `None` where that is left as it is.
    fn wanted(&self) -> Option<Stiffness> {
        self.stiffness[0]?;
        let mut stiffness = [0.0; JOINTS];
        for (joint, stiffness) in stiffness.iter_mut().enumerate() {
            *stiffness = self.stiffness.get(usize::from(self.sets.set(joint))).copied().flatten()?[joint];
        }
        Some(stiffness)
    }

    /// Whether the robot knows all of it.
    pub fn is_known(&self) -> bool {
        self.asked.is_none() && self.next().is_none()
    }

    fn next(&self) -> Option<Asked> {
        if self.collision.is_some() && !self.knows_collision {
            return Some(Asked::Collision);
        }
        let stiffness = self.wanted().filter(|wanted| Some(*wanted) != self.known).map(Asked::Stiffness);
        stiffness.or_else(|| self.load.filter(|load| Some(*load) != self.known_load).map(Asked::Load))
    }

    /// Tells the robot what it does not know yet, one thing after the other, after its state of this count and with this end effector.
    ///
    /// # Errors
    /// What `ask` cannot do; the robot has not answered for [`TIMEOUT`]; a load that is not one beside the end effector.
    pub fn tell(
        &mut self,
        count: u64,
        end_effector: &Load,
        ask: impl FnOnce(Request) -> Result<u32, DriveFault>,
    ) -> Result<(), DriveFault> {
        if let Some((.., since)) = self.asked {
            return if count > since + TIMEOUT { Err(UNANSWERED) } else { Ok(()) };
        }
        let Some(next) = self.next() else { return Ok(()) };
        let request = match (next, self.collision) {
            (Asked::Stiffness(stiffness), _) => Request::Stiffness(stiffness),
            (Asked::Load(load), _) => Request::Load(load::besides(end_effector, &load)?),
            (Asked::Collision, Some(collision)) => Request::Collision(collision),
            (Asked::Collision, None) => return Ok(()),
        };
        self.asked = Some((ask(request)?, next, count));
        Ok(())
    }

    /// The robot's answer; whether it was one to this.
    ///
    /// # Errors
    /// The robot refuses it.
    pub fn answered(&mut self, id: u32, status: u8) -> Result<bool, DriveFault> {
        let Some((_, asked, _)) = self.asked.filter(|(asked, ..)| *asked == id) else { return Ok(false) };
        self.asked = None;
        match (asked, status) {
            (Asked::Collision, 0) => self.knows_collision = true,
            (Asked::Stiffness(stiffness), 0) => self.known = Some(stiffness),
            (Asked::Load(load), 0) => self.known_load = Some(load),
            (Asked::Collision, _) => return Err(COLLISION_REFUSED),
            (Asked::Load(_), 1) => return Err(LOAD_IMPOSSIBLE),
            (Asked::Load(_), _) => return Err(LOAD_REFUSED),
            (Asked::Stiffness(_), _) => return Err(STIFFNESS_REFUSED),
        }
        Ok(true)
    }
}
