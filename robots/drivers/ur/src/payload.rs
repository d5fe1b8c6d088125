//! What an arm carries: when its controller is told, and whether it says that it has taken it.
//!
//! In: loads, the controller's state in each period. Out: the messages to its script; a fault when the controller does not tell by RTDE
//! what it was told. UR names the elements of an inertia in the order xx, yy, zz, xy, xz, yz (manual of URScript, `set_target_payload`).

use core::time::Duration;

use mrroc::robot::{DriveFault, Load, RobotStop, StopCause};

use crate::models::JOINTS;
use crate::set_point::SetPoint;
use crate::state::{PERIOD, State};

pub use crate::inertia::{elements, inertia};

/// How far a joint may be driven in a period of an arm that stands \[rad\]: 1 mrad/s.
const STILL: f64 = 2e-6;

/// How long an arm may go on, beyond the `lookahead_time` of `servoj`, when its demand stands (assumed).
const SETTLES: Duration = Duration::from_millis(70);

/// How long the controller may take to tell what it was told.
const ANSWER: Duration = Duration::from_millis(100);

/// By how much what it tells may differ: mass \[kg\], centre \[m\], elements of the inertia [kg m²].
const ROUNDED: (f64, f64, f64) = (1e-3, 1e-4, 1e-4);

const UNTAKEN: DriveFault = DriveFault::Other(
    "the controller does not tell by RTDE the load that its script was told: look at the messages of its pendant",
);

const REFUSED: DriveFault = DriveFault::Stopped(RobotStop::new(StopCause::ProgramNotRunning).named(
    "the controller ended its script when it was told the load: does the arm carry it, and is its inertia that of a body?",
));

/// What the controller knows of it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Transmission {
    /// All that was said.
    Known,
    /// Nothing of what was said last.
    Untold,
    /// The script was told, at this time of the controller's clock \[s\].
    Told(f64),
}

/// What an arm carries, and what its controller knows of it.
#[derive(Debug)]
pub(crate) struct Payload {
    load: Option<Load>,
    transmission: Transmission,
    /// Where the joints were demanded and driven to, when the last position was demanded.
    demanded: [f64; JOINTS],
    driven: [f64; JOINTS],
    /// Periods for which the demand has stood, and after how many the arm stands.
    still: u32,
    settled: u32,
}

/// For how long an arm stands until it reckons with a load, or is a fault.
pub(crate) fn time(lookahead: Duration) -> Duration {
    lookahead + SETTLES + ANSWER
}

impl Payload {
    /// Nothing was said of it: the payload of the controller's installation holds.
    pub fn unsaid(lookahead: Duration) -> Payload {
        let nowhere = [f64::NAN; JOINTS];
        let settled = ((lookahead + SETTLES).as_secs_f64() / PERIOD.as_secs_f64()).ceil() as u32;
        Payload {
            load: None,
            transmission: Transmission::Known,
            demanded: nowhere,
            driven: nowhere,
            still: 0,
            settled,
        }
    }

    /// It carries this.
    pub fn carry(&mut self, load: &Load) {
        (self.load, self.transmission) = (Some(*load), Transmission::Untold);
    }

    /// A program of the controller begins, with the payload of its installation.
    pub fn begin(&mut self) {
        self.transmission = if self.load.is_some() { Transmission::Untold } else { Transmission::Known };
    }

    /// What the script is to be told now, of an arm in this state that is demanded this position: what it carries, if it stands and
    /// that is not known.
    pub fn next(
        &mut self,
        state: &State,
        demanded: &[f64; JOINTS],
        timeout: Duration,
    ) -> Option<[SetPoint; 2]> {
        let stands = self.stands(state, demanded);
        let load = self.load.filter(|_| stands && self.transmission == Transmission::Untold)?;
        self.transmission = Transmission::Told(state.timestamp);
        Some(SetPoint::carry(&load, timeout))
    }

    fn stands(&mut self, state: &State, demanded: &[f64; JOINTS]) -> bool {
        let is_still = |now: &[f64; JOINTS], before: &[f64; JOINTS]| {
            now.iter().zip(before).all(|(now, before)| (now - before).abs() <= STILL)
        };
        self.still = if is_still(demanded, &self.demanded) { self.still.saturating_add(1) } else { 0 };
        let is_driven = !is_still(&state.target_q, &self.driven);
        (self.demanded, self.driven) = (*demanded, state.target_q);
        self.still > 0 && !is_driven || self.still >= self.settled
    }

    /// Looks whether the controller tells what it was told.
    ///
    /// # Errors
    /// It does not, and has had its time.
    pub fn look(&mut self, state: &State) -> Result<(), DriveFault> {
        let (Transmission::Told(at), Some(load)) = (self.transmission, self.load) else { return Ok(()) };
        if is_told(&load, &state.payload) {
            self.transmission = Transmission::Known;
        } else if state.timestamp - at > ANSWER.as_secs_f64() {
            self.transmission = Transmission::Untold;
            return Err(UNTAKEN);
        }
        Ok(())
    }

    /// What it means that the controller has ended the script: a refusal, if it was told a load and has not said that it took it.
    pub fn refusal(&self) -> Option<DriveFault> {
        matches!(self.transmission, Transmission::Told(_)).then_some(REFUSED)
    }
}

/// Whether a controller that tells `tells` was told `load`.
fn is_told(load: &Load, tells: &Load) -> bool {
    let (mass, centre, inertia) = ROUNDED;
    (load.mass - tells.mass).abs() <= mass
        && (load.centre - tells.centre).amax() <= centre
        && (load.inertia - tells.inertia).amax() <= inertia
}
