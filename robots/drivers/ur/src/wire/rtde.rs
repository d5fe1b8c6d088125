//! The negotiation of RTDE, which ends with the first state.

#![expect(clippy::disallowed_methods, reason = "a controller is waited for before the cell runs")]

use std::time::{Duration, Instant};

use mrroc_driver_kit::{Cutting, Line};

use super::Lost;
use crate::outputs::{Group, Groups};
use crate::rtde::{Answer, Package, Request, VERSION};
use crate::state::{State, check_offers, recipe_names};

/// How often a second the outputs are asked for \[Hz\]: as often as the controller has them.
const FREQUENCY: f64 = 500.0;

/// How long a controller may take for an answer.
const ANSWER: Duration = Duration::from_secs(2);

/// How the stream is cut into packages.
pub(super) fn cut(bytes: &[u8]) -> Cutting {
    match Package::length(bytes) {
        Ok(Some(length)) => Cutting::Frame(length),
        Ok(None) => Cutting::More,
        Err(_) => Cutting::Bad,
    }
}

/// What has been agreed on.
pub(super) struct Negotiated {
    /// The number of the recipe of a [`State`].
    pub recipe: u8,
    /// Those of the groups of which outputs are switched.
    pub written: [Option<u8>; 2],
    /// The first state.
    pub state: State,
}

/// Asks for the fields of a [`State`], for those by which outputs of some groups are switched, and starts them.
pub(super) fn negotiate(line: &mut Line, switches: Groups) -> Result<Negotiated, Lost> {
    ask(line, &Request::Version(VERSION))?;
    match wait(line, |answer| if let Answer::Version(yes) = answer { Some(*yes) } else { None })? {
        true => {}
        false => return Err(Lost("the controller does not speak RTDE 2: its software is older than 3.4")),
    }
    ask(line, &Request::Outputs { frequency: FREQUENCY, names: &recipe_names() })?;
    let offered = wait(line, |answer| match answer {
        Answer::Outputs { recipe, offers } => Some((*recipe, Answer::offers(offers))),
        _ => None,
    })?;
    let (recipe, Some(offers)) = offered else {
        return Err(Lost("the controller answers with types of RTDE that are not known here"));
    };
    check_offers(&offers).map_err(|field| match field {
        "actual_TCP_force" => Lost("the controller has no field `actual_TCP_force` of RTDE"),
        "safety_status_bits" => Lost("the controller has no field `safety_status_bits` of RTDE"),
        _ => Lost("the controller lacks a field of RTDE, or has another type for it"),
    })?;
    let mut written = [None; 2];
    for (recipe, group) in written.iter_mut().zip(Group::ALL) {
        if switches.has(group) {
            *recipe = Some(negotiate_outputs(line, group)?);
        }
    }
    ask(line, &Request::Start)?;
    match wait(line, |answer| if let Answer::Started(yes) = answer { Some(*yes) } else { None })? {
        true => {}
        false => return Err(Lost("the controller does not start its outputs")),
    }
    let state = wait(line, |answer| state_of(answer, recipe))?;
    Ok(Negotiated { recipe, written, state })
}

/// Asks for the fields by which outputs of a group are switched: the number of their recipe.
fn negotiate_outputs(line: &mut Line, group: Group) -> Result<u8, Lost> {
    ask(line, &Request::Inputs { names: group.names() })?;
    let offered = wait(line, |answer| match answer {
        Answer::Inputs { recipe, offers } => Some((*recipe, Answer::offers(offers))),
        _ => None,
    })?;
    group.check(&offered.1.unwrap_or_default()).map_err(Lost)?;
    Ok(offered.0)
}

/// The state of a package with data of this recipe.
pub(super) fn state_of(answer: &Answer<'_>, of: u8) -> Option<State> {
    match answer {
        Answer::Data { recipe, values } if *recipe == of => State::read(values),
        _ => None,
    }
}

fn ask(line: &Line, request: &Request<'_>) -> Result<(), Lost> {
    let mut bytes = Vec::new();
    request.write(&mut bytes);
    line.send(&bytes).map_err(|_| Lost("the controller has closed its RTDE"))
}

/// The first answer of which something is wanted.
fn wait<T>(line: &mut Line, wanted: impl Fn(&Answer<'_>) -> Option<T>) -> Result<T, Lost> {
    let until = Instant::now() + ANSWER;
    loop {
        while let Some(frame) = line.oldest() {
            let package = Package::first(frame.bytes());
            let found = match package {
                Ok(Some((package, _))) => Answer::read(&package).as_ref().and_then(&wanted),
                Ok(None) | Err(_) => None,
            };
            if let Some(found) = found {
                return Ok(found);
            }
        }
        if !line.is_open() {
            return Err(Lost("the controller has closed its RTDE"));
        }
        if Instant::now() > until {
            return Err(Lost("the controller does not answer on RTDE"));
        }
        std::thread::sleep(Duration::from_micros(200));
    }
}
