//! The negotiation of RTDE, which ends with the first state.
//!
//! In: the time, and the packages that come. Out: the next request, and what has been agreed on. Nothing here has a clock or a socket.

use core::time::Duration;

use mrroc_driver_kit::Cutting;

use super::ConnectionLost;
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
    ) -> Result<Option<Negotiated>, ConnectionLost> {
        let Some(package) = package else {
            return match (is_open, now > self.until) {
                (false, _) => Err(CLOSED),
                (true, true) => Err(ConnectionLost("the controller does not answer on RTDE")),
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

    fn hear(
        &mut self,
        answer: &Answer<'_>,
        requests: &mut Vec<u8>,
    ) -> Result<Option<Negotiated>, ConnectionLost> {
        match (self.awaited, answer) {
            (Awaited::Version, Answer::Version(false)) => {
                return Err(ConnectionLost(
                    "the controller does not speak RTDE 2: its software is older than 3.4",
                ));
            }
            (Awaited::Version, Answer::Version(true)) => {
                Request::Outputs { frequency: FREQUENCY, names: &recipe_names() }.write(requests);
                self.awaited = Awaited::Outputs;
            }
            (Awaited::Outputs, Answer::Outputs { recipe, offers }) => {
                let offers = Answer::offers(offers);
                let offers = offers.ok_or(ConnectionLost(
                    "the controller answers with types of RTDE that are not known here",
                ))?;
                check_offers(&offers).map_err(|field| match field {
                    "actual_TCP_force" => {
                        ConnectionLost("the controller has no field `actual_TCP_force` of RTDE")
                    }
                    "safety_status_bits" => {
                        ConnectionLost("the controller has no field `safety_status_bits` of RTDE")
                    }
                    _ => ConnectionLost("the controller lacks a field of RTDE, or has another type for it"),
                })?;
                self.recipe = *recipe;
                self.ask_for_inputs(0, requests);
            }
            (Awaited::Inputs(group), Answer::Inputs { recipe, offers }) => {
                group.check(&Answer::offers(offers).unwrap_or_default()).map_err(ConnectionLost)?;
                self.written[group as usize] = Some(*recipe);
                self.ask_for_inputs(group as usize + 1, requests);
            }
            (Awaited::Started, Answer::Started(false)) => {
                return Err(ConnectionLost("the controller does not start its outputs"));
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
pub(super) const CLOSED: ConnectionLost = ConnectionLost("the controller has closed its RTDE");

#[cfg(test)]
mod tests {
    use mrroc::robot::{Channel, Outputs, Value as Level};

    use super::*;
    use crate::rtde::Offer;

    const NOW: Duration = Duration::from_secs(1);

    /// A negotiation that has begun, and its first request.
    fn begun(switches: Groups) -> Negotiation {
        let (mut requests, mut expected) = (Vec::new(), Vec::new());
        let negotiation = Negotiation::begin(NOW, switches, &mut requests);
        Request::Version(VERSION).write(&mut expected);
        assert_eq!(requests, expected);
        negotiation
    }

    /// What comes of an answer, and the kinds of the requests after it.
    fn answered(
        negotiation: &mut Negotiation,
        answer: &Answer<'_>,
    ) -> (Result<Option<Negotiated>, ConnectionLost>, Vec<u8>) {
        let (mut package, mut requests) = (Vec::new(), Vec::new());
        answer.write(&mut package);
        let outcome = negotiation.poll(NOW, Some(&package), true, &mut requests);
        (outcome, requests)
    }

    fn bytes(request: &Request<'_>) -> Vec<u8> {
        let mut bytes = Vec::new();
        request.write(&mut bytes);
        bytes
    }

    /// All fields of a state, as they should be.
    fn offers() -> String {
        crate::state::RECIPE.iter().map(|(_, of)| Offer::Has(*of).to_string()).collect::<Vec<_>>().join(",")
    }

    #[test]
    fn what_is_needed_is_asked_for_one_after_the_other() {
        let mut negotiation = begun(Groups::of(&Outputs::NONE.with(Channel::Analog(0), Level::Analog(0.0))));
        let (outcome, requests) = answered(&mut negotiation, &Answer::Version(true));
        let names = recipe_names();
        let expected = bytes(&Request::Outputs { frequency: FREQUENCY, names: &names });
        assert_eq!((outcome, requests), (Ok(None), expected));
        // What was not asked for is passed over.
        assert_eq!(answered(&mut negotiation, &Answer::Started(false)), (Ok(None), vec![]));
        let (outcome, requests) =
            answered(&mut negotiation, &Answer::Outputs { recipe: 3, offers: &offers() });
        // Of the digital ones none is switched.
        let expected = bytes(&Request::Inputs { names: Group::Analog.names() });
        assert_eq!((outcome, requests), (Ok(None), expected));
        let taken = Answer::Inputs { recipe: 5, offers: "UINT8,UINT8,DOUBLE,DOUBLE" };
        assert_eq!(answered(&mut negotiation, &taken), (Ok(None), bytes(&Request::Start)));
        assert_eq!(answered(&mut negotiation, &Answer::Started(true)), (Ok(None), vec![]));
        assert_eq!((negotiation.recipe, negotiation.written), (3, [None, Some(5)]));
        // Data of another recipe is no state.
        let other = Answer::Data { recipe: 2, values: &[0; 8] };
        assert_eq!(answered(&mut negotiation, &other), (Ok(None), vec![]));
    }

    #[test]
    fn what_a_controller_does_not_agree_to_is_told() {
        let told = |negotiation: &mut Negotiation, answer: &Answer<'_>| {
            let (outcome, requests) = answered(negotiation, answer);
            assert_eq!(requests, []);
            outcome.expect_err("it does not agree").0
        };
        let old = told(&mut begun(Groups::NONE), &Answer::Version(false));
        assert!(old.contains("older than 3.4"), "{old}");
        let mut asked = begun(Groups::NONE);
        answered(&mut asked, &Answer::Version(true)).0.expect("it goes on");
        for (offers, says) in [
            ("DOUBLE,COLOUR".to_owned(), "types of RTDE that are not known"),
            ("NOT_FOUND".to_owned(), "lacks a field"),
        ] {
            let why = told(&mut { asked }, &Answer::Outputs { recipe: 0, offers: &offers });
            assert!(why.contains(says), "{why}");
        }
        answered(&mut asked, &Answer::Outputs { recipe: 1, offers: &offers() }).0.expect("it goes on");
        let why = told(&mut asked, &Answer::Started(false));
        assert!(why.contains("does not start its outputs"), "{why}");
    }

    #[test]
    fn each_answer_is_waited_for_for_2_s_and_an_end_is_told_at_once() {
        let mut negotiation = begun(Groups::NONE);
        let mut silent = |now| negotiation.poll(now, None, true, &mut Vec::new());
        assert_eq!(silent(NOW + ANSWER), Ok(None));
        let late = Err(ConnectionLost("the controller does not answer on RTDE"));
        assert_eq!(silent(NOW + ANSWER + Duration::from_nanos(1)), late);
        assert_eq!(negotiation.poll(NOW, None, false, &mut Vec::new()), Err(CLOSED));
        // What is nothing that is waited for gives no more time; what is does.
        for (answer, outcome) in [(Answer::Paused(true), late), (Answer::Version(true), Ok(None))] {
            let mut negotiation = begun(Groups::NONE);
            let mut package = Vec::new();
            answer.write(&mut package);
            let later = NOW + Duration::from_secs(1);
            assert_eq!(negotiation.poll(later, Some(&package), true, &mut Vec::new()), Ok(None));
            assert_eq!(negotiation.poll(later + ANSWER, None, true, &mut Vec::new()), outcome);
        }
    }
}
