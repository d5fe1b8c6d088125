//! One client of RTDE.
//!
//! In: its requests. Out: answers, and in every period, or every n-th, the outputs that it has asked for.

use mrroc_ur::rtde::{Answer, Offer, Request, Type, VERSION, Values};

use crate::controller::Controller;
use crate::dashboard::VERSION as SOFTWARE;
use crate::fields::input;

/// Recipes of inputs that a client may have.
const RECIPES: usize = 255;

/// A client: what it has asked for.
#[derive(Debug)]
pub struct Session {
    client: u64,
    outputs: Vec<String>,
    /// Of this many periods one is told.
    every: u64,
    starts: bool,
    inputs: Vec<Vec<(String, Type)>>,
}

impl Session {
    /// A client that has just called.
    pub fn new(controller: &mut Controller) -> Session {
        controller.inputs.clients += 1;
        Session {
            client: controller.inputs.clients,
            outputs: Vec::new(),
            every: 1,
            starts: false,
            inputs: Vec::new(),
        }
    }

    /// The client is gone: others may write what it wrote.
    pub fn end(&self, controller: &mut Controller) {
        controller.inputs.writers.retain(|_, client| *client != self.client);
    }

    /// Carries out a request, and appends the answer.
    pub fn request(&mut self, controller: &mut Controller, request: &Request<'_>, answers: &mut Vec<u8>) {
        match *request {
            Request::Version(version) => Answer::Version(version == VERSION).write(answers),
            Request::ControllerVersion => Answer::ControllerVersion(SOFTWARE).write(answers),
            Request::Outputs { frequency, names } => {
                self.offer_outputs(controller, frequency, names, answers)
            }
            Request::Inputs { names } => self.offer_inputs(controller, names, answers),
            Request::Start => {
                self.starts = !self.outputs.is_empty() || !self.inputs.is_empty();
                Answer::Started(self.starts).write(answers);
            }
            Request::Pause => {
                self.starts = false;
                Answer::Paused(true).write(answers);
            }
            Request::Data { recipe, values } => self.take(controller, recipe, values),
            Request::Text => {}
        }
    }

    fn offer_outputs(&mut self, controller: &Controller, frequency: f64, names: &str, answers: &mut Vec<u8>) {
        let names: Vec<_> = list(names).collect();
        let offers: Vec<_> = names
            .iter()
            .map(|name| controller.output(name).map_or(Offer::NotFound, |value| Offer::Has(value.of())))
            .collect();
        let all = !offers.is_empty() && !offers.contains(&Offer::NotFound);
        self.outputs = if all { names.into_iter().map(str::to_owned).collect() } else { Vec::new() };
        self.every = (500.0 / frequency).round().clamp(1.0, 500.0) as u64;
        Answer::Outputs { recipe: u8::from(all), offers: &text(&offers) }.write(answers);
    }

    fn offer_inputs(&mut self, controller: &mut Controller, names: &str, answers: &mut Vec<u8>) {
        let names: Vec<_> = list(names).collect();
        let offers: Vec<_> = names
            .iter()
            .map(|name| match (input(name), controller.inputs.writers.get(*name)) {
                (None, _) => Offer::NotFound,
                (Some(_), Some(client)) if *client != self.client => Offer::InUse,
                (Some(of), _) => Offer::Has(of),
            })
            .collect();
        let recipe: Vec<_> = names
            .iter()
            .zip(&offers)
            .filter_map(|(name, offer)| match offer {
                Offer::Has(of) => Some(((*name).to_owned(), *of)),
                Offer::NotFound | Offer::InUse => None,
            })
            .collect();
        let all = !recipe.is_empty() && recipe.len() == offers.len() && self.inputs.len() < RECIPES;
        if all {
            controller.inputs.writers.extend(recipe.iter().map(|(name, _)| (name.clone(), self.client)));
            self.inputs.push(recipe);
        }
        let recipe = if all { self.inputs.len() as u8 } else { 0 };
        Answer::Inputs { recipe, offers: &text(&offers) }.write(answers);
    }

    fn take(&self, controller: &mut Controller, recipe: u8, values: &[u8]) {
        let Some(recipe) = usize::from(recipe).checked_sub(1).and_then(|i| self.inputs.get(i)) else {
            return;
        };
        let mut values = Values(values);
        let written: Option<Vec<_>> =
            recipe.iter().map(|(name, of)| Some((name.clone(), values.value(*of)?))).collect();
        if let Some(written) = written.filter(|_| values.is_over()) {
            controller.write(&written);
        }
    }

    /// Appends the outputs of this period, if the client is to be told them.
    pub fn outputs(&self, controller: &Controller, to: &mut Vec<u8>) {
        if !self.starts || self.outputs.is_empty() || !controller.steps.is_multiple_of(self.every) {
            return;
        }
        let mut values = Vec::new();
        for name in &self.outputs {
            if let Some(value) = controller.output(name) {
                value.write(&mut values);
            }
        }
        Answer::Data { recipe: 1, values: &values }.write(to);
    }
}

fn list(names: &str) -> impl Iterator<Item = &str> {
    names.split(',').map(str::trim).filter(|name| !name.is_empty())
}

fn text(offers: &[Offer]) -> String {
    offers.iter().map(Offer::to_string).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use mrroc_robots::Six;
    use mrroc_ur::UrModel;
    use mrroc_ur::rtde::{Package, Value};

    use super::*;

    fn answer(session: &mut Session, controller: &mut Controller, request: Request<'_>) -> Vec<u8> {
        let mut bytes = Vec::new();
        session.request(controller, &request, &mut bytes);
        bytes
    }

    fn read(bytes: &[u8]) -> Answer<'_> {
        let (package, rest) = Package::first(bytes).expect("short").expect("all there");
        assert!(rest.is_empty());
        Answer::read(&package).expect("an answer")
    }

    #[test]
    fn unknown_fields_are_not_found_and_inputs_have_one_writer() {
        let mut controller = Controller::new(UrModel::Ur5e, &Six::zeros()).expect("an arm");
        let (mut one, mut two) = (Session::new(&mut controller), Session::new(&mut controller));
        let asked = Request::Outputs { frequency: 500.0, names: "timestamp,actual_Q,tool_mode" };
        let bytes = answer(&mut one, &mut controller, asked);
        assert_eq!(read(&bytes), Answer::Outputs { recipe: 0, offers: "DOUBLE,NOT_FOUND,UINT32" });
        let bytes = answer(&mut one, &mut controller, Request::Start);
        assert_eq!(read(&bytes), Answer::Started(false));

        let names = "standard_digital_output_mask,standard_digital_output";
        let bytes = answer(&mut one, &mut controller, Request::Inputs { names });
        assert_eq!(read(&bytes), Answer::Inputs { recipe: 1, offers: "UINT8,UINT8" });
        let bytes = answer(
            &mut two,
            &mut controller,
            Request::Inputs { names: "standard_digital_output,input_int_register_48" },
        );
        assert_eq!(read(&bytes), Answer::Inputs { recipe: 0, offers: "IN_USE,NOT_FOUND" });
        answer(&mut one, &mut controller, Request::Data { recipe: 1, values: &[0b101, 0b111] });
        assert_eq!(controller.output("actual_digital_output_bits"), Some(Value::Uint64(0b101)));
        answer(&mut one, &mut controller, Request::Data { recipe: 1, values: &[0b100] });
        assert_eq!(controller.digital_outputs(), 0b101, "too short: not taken");
        one.end(&mut controller);
        let bytes = answer(&mut two, &mut controller, Request::Inputs { names });
        assert_eq!(read(&bytes), Answer::Inputs { recipe: 1, offers: "UINT8,UINT8" });
    }

    #[test]
    fn outputs_are_told_as_often_as_asked_and_not_while_paused() {
        let mut controller = Controller::new(UrModel::Ur5e, &Six::zeros()).expect("an arm");
        let mut session = Session::new(&mut controller);
        let told = |session: &Session, controller: &mut Controller| {
            let mut bytes = Vec::new();
            (0..500).for_each(|_| {
                controller.step();
                session.outputs(controller, &mut bytes);
            });
            // Header, recipe, a double.
            bytes.len() / 12
        };
        answer(&mut session, &mut controller, Request::Outputs { frequency: 125.0, names: "timestamp" });
        assert_eq!(told(&session, &mut controller), 0);
        answer(&mut session, &mut controller, Request::Start);
        assert_eq!(told(&session, &mut controller), 125);
        answer(&mut session, &mut controller, Request::Pause);
        assert_eq!(told(&session, &mut controller), 0);
        answer(&mut session, &mut controller, Request::Outputs { frequency: 500.0, names: "timestamp" });
        answer(&mut session, &mut controller, Request::Start);
        assert_eq!(told(&session, &mut controller), 500);
    }
}
