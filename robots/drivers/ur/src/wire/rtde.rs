//! The negotiation of RTDE, which ends with the first state.
//!
//! In: the time, and the packages that come. Out: the next request, and what has been agreed on. Nothing here has a clock or a socket.

use core::time::Duration;

use mrroc_driver_kit::Cutting;

use super::Lost;
use crate::outputs::{Group, Groups};
use crate::rtde::{Answer, Package, Request, VERSION};
use crate::state::{State, check_offers, recipe_names};

/// How often a second the outputs are asked for \[Hz\]: as often as the controller has them.
const FREQUENCY: f64 = 500.0;

/// How long a controller may take for an answer.
pub(super) const ANSWER: Duration = Duration::from_secs(2);

/// How the stream is cut into packages.
pub(super) fn cut(bytes: &[u8]) -> Cutting {
    match Package::length(bytes) {
        Ok(Some(length)) => Cutting::Frame(length),
        Ok(None) => Cutting::More,
        Err(_) => Cutting::Bad,
    }
}

/// What has been agreed on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Negotiated {
    /// The number of the recipe of a [`State`].
    pub recipe: u8,
    /// Those of the groups of which outputs are switched.
    pub written: [Option<u8>; 2],
    /// The first state.
    pub state: State,
}

/// Which answer is waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Awaited {
    Version,
    Outputs,
    /// The fields by which outputs of this group are switched.
    Inputs(Group),
    Started,
    State,
}

/// Asks for the fields of a [`State`], for those by which outputs of some groups are switched, and starts them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Negotiation {
    switches: Groups,
    awaited: Awaited,
    until: Duration,
    recipe: u8,
    written: [Option<u8>; 2],
}

impl Negotiation {
    /// Begins with a controller that was called, and appends the first request.
    pub(super) fn begin(now: Duration, switches: Groups, requests: &mut Vec<u8>) -> Negotiation {
        Request::Version(VERSION).write(requests);
        let (awaited, until) = (Awaited::Version, now + ANSWER);
        Negotiation { switches, awaited, until, recipe: 0, written: [None; 2] }
    }

    /// Goes on at this time, with a package if one has come, and appends the next request, if there is one.
    ///
    /// # Errors
    /// The controller does not answer, has closed the connection, or does not agree.
    pub(super) fn poll(
        &mut self,
        now: Duration,
        package: Option<&[u8]>,
        is_open: bool,
        requests: &mut Vec<u8>,
    ) -> Result<Option<Negotiated>, Lost> {
        let Some(package) = package else {
            return match (is_open, now > self.until) {
                (false, _) => Err(CLOSED),
                (true, true) => Err(Lost("the controller does not answer on RTDE")),
                (true, false) => Ok(None),
            };
        };
        // What is none, or nothing that is wanted, is passed over.
        let Ok(Some((package, _))) = Package::first(package) else { return Ok(None) };
        let Some(answer) = Answer::read(&package) else { return Ok(None) };
        let before = self.awaited;
        let negotiated = self.hear(&answer, requests)?;
        if self.awaited != before {
            self.until = now + ANSWER;
        }
        Ok(negotiated)
    }

    fn hear(&mut self, answer: &Answer<'_>, requests: &mut Vec<u8>) -> Result<Option<Negotiated>, Lost> {
        match (self.awaited, answer) {
            (Awaited::Version, Answer::Version(false)) => {
                return Err(Lost("the controller does not speak RTDE 2: its software is older than 3.4"));
            }
            (Awaited::Version, Answer::Version(true)) => {
                Request::Outputs { frequency: FREQUENCY, names: &recipe_names() }.write(requests);
                self.awaited = Awaited::Outputs;
            }
            (Awaited::Outputs, Answer::Outputs { recipe, offers }) => {
                let offers = Answer::offers(offers);
                let offers = offers
                    .ok_or(Lost("the controller answers with types of RTDE that are not known here"))?;
                check_offers(&offers).map_err(|field| match field {
                    "actual_TCP_force" => Lost("the controller has no field `actual_TCP_force` of RTDE"),
                    "safety_status_bits" => Lost("the controller has no field `safety_status_bits` of RTDE"),
                    _ => Lost("the controller lacks a field of RTDE, or has another type for it"),
                })?;
                self.recipe = *recipe;
                self.ask_for_inputs(0, requests);
            }
            (Awaited::Inputs(group), Answer::Inputs { recipe, offers }) => {
                group.check(&Answer::offers(offers).unwrap_or_default()).map_err(Lost)?;
                self.written[group as usize] = Some(*recipe);
                self.ask_for_inputs(group as usize + 1, requests);
            }
            (Awaited::Started, Answer::Started(false)) => {
                return Err(Lost("the controller does not start its outputs"));
            }
            (Awaited::Started, Answer::Started(true)) => self.awaited = Awaited::State,
            (Awaited::State, answer) => {
                let (recipe, written) = (self.recipe, self.written);
                return Ok(state_of(answer, recipe).map(|state| Negotiated { recipe, written, state }));
            }
            _ => {}
        }
        Ok(None)
    }

    /// Asks for the fields of the next group from this place on, or starts where there is none.
    fn ask_for_inputs(&mut self, from: usize, requests: &mut Vec<u8>) {
        match Group::ALL.into_iter().skip(from).find(|group| self.switches.has(*group)) {
            Some(group) => {
                Request::Inputs { names: group.names() }.write(requests);
                self.awaited = Awaited::Inputs(group);
            }
            None => {
                Request::Start.write(requests);
                self.awaited = Awaited::Started;
            }
        }
    }
}

/// The state of a package with data of this recipe.
pub(super) fn state_of(answer: &Answer<'_>, of: u8) -> Option<State> {
    match answer {
        Answer::Data { recipe, values } if *recipe == of => State::read(values),
        _ => None,
    }
}

/// The connection has ended.
pub(super) const CLOSED: Lost = Lost("the controller has closed its RTDE");
