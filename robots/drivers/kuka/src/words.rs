//! Digital inputs and outputs, as words in the messages of the interface.
//!
//! In: what programs tell outputs, what the controller says of both. Out: the word of its outputs in each answer; a fault where it does
//! not switch them. An answer has all outputs of the word: those that no program has told anything stay as they were when the
//! drives were opened.

use mrroc::robot::{Channels, DriveFault, Outputs, Signals, Values, WhenLost};

use crate::message::FromController;

/// Bits of a word, as a DIGIN, DIGOUT and MAP2DIGOUT of a signal flow have them at most.
const BITS: u8 = 16;

/// What a controller has. What its outputs do when its program ends is assumed: they hold.
pub(crate) const CHANNELS: Channels = Channels {
    digital_inputs: BITS,
    digital_outputs: BITS,
    analog_inputs: 0,
    analog_outputs: 0,
    when_lost: WhenLost::Hold,
};

/// Periods after which outputs read what they were told.
const SWITCHES: u32 = 25;

const NO_WORDS: DriveFault = DriveFault::Other(
    "the cell names inputs or outputs, and the controller does not send both `DiL` and `DoutW`: add them to the SEND of its configuration",
);

const NOT_SWITCHED: DriveFault = DriveFault::Other(
    "the controller does not switch its outputs: is `DiO` in the RECEIVE of its configuration, with a MAP2DIGOUT where `DoutW` is read?",
);

/// The inputs and outputs of a controller.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Words {
    /// Whether any of them has a name.
    any: bool,
    /// What outputs were told: which, and their values.
    told: (u16, u16),
    /// What they were when the drives were opened.
    first: u16,
    /// What the controller says.
    inputs: u16,
    outputs: u16,
    /// Periods for which it has not said what it was told.
    unswitched: u32,
}

impl Words {
    /// Some of them have names.
    pub fn name(&mut self) {
        self.any = true;
    }

    /// The drives are opened, or the interface was switched on anew, with this message.
    ///
    /// # Errors
    /// It does not say what they are.
    pub fn begin(&mut self, said: &FromController) -> Result<(), DriveFault> {
        if !self.any {
            return Ok(());
        }
        let (Some(inputs), Some(outputs)) = (said.inputs, said.outputs) else { return Err(NO_WORDS) };
        (self.inputs, self.outputs, self.first, self.unswitched) = (inputs, outputs, outputs, 0);
        Ok(())
    }

    /// What programs have told the outputs so far.
    pub fn switch(&mut self, told: &Outputs) {
        self.told = (told.digital() as u16, told.values().digital() as u16);
    }

    /// The controller says something, and has taken the answer before, as far as is known.
    ///
    /// # Errors
    /// It does not switch what it was told.
    pub fn hear(&mut self, said: &FromController, took: bool) -> Result<(), DriveFault> {
        if !self.any {
            return Ok(());
        }
        // A word that is missing once is what it was.
        self.inputs = said.inputs.unwrap_or(self.inputs);
        self.outputs = said.outputs.unwrap_or(self.outputs);
        let (which, values) = self.told;
        let differs = (self.outputs ^ values) & which != 0;
        self.unswitched = if differs { self.unswitched + u32::from(took) } else { 0 };
        if self.unswitched > SWITCHES {
            self.unswitched = 0;
            return Err(NOT_SWITCHED);
        }
        Ok(())
    }

    /// The word of the outputs for an answer; `None` where no signal has a name.
    pub fn word(&self) -> Option<u16> {
        let (which, values) = self.told;
        self.any.then_some(self.first & !which | values & which)
    }

    /// What the inputs read, and what the outputs are.
    pub fn signals(&self) -> Signals {
        let word = |word: u16| Values::new(word.into(), [0.0; 4]);
        Signals { inputs: word(self.inputs), outputs: word(self.outputs) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc::robot::{Channel, Value};

    fn said(inputs: u16, outputs: u16) -> FromController {
        FromController { ipoc: 1, axes: [0.0; 6], late: None, inputs: Some(inputs), outputs: Some(outputs) }
    }

    fn told(bits: &[(u8, bool)]) -> Outputs {
        let tell =
            |told: Outputs, &(bit, on): &(u8, bool)| told.with(Channel::Digital(bit), Value::Digital(on));
        bits.iter().fold(Outputs::NONE, tell)
    }

    #[test]
    fn outputs_that_are_told_nothing_stay_as_they_were_and_inputs_read() {
        let mut words = Words::default();
        assert_eq!((words.begin(&said(5, 5)), words.word()), (Ok(()), None), "no signal has a name");
        words.name();
        words.begin(&said(0b1000_0000_0000_0001, 0b0110)).expect("both words");
        assert_eq!(words.word(), Some(0b0110));
        words.switch(&told(&[(1, false), (15, true)]));
        assert_eq!(words.word(), Some(0b1000_0000_0000_0100));
        let signals = words.signals();
        assert!(signals.inputs.is_on(0) && signals.inputs.is_on(15) && !signals.inputs.is_on(1));
        assert!(
            signals.outputs.is_on(1) && !signals.outputs.is_on(15),
            "as the controller says, not as it was told"
        );
    }

    #[test]
    fn fault_119_a_controller_that_says_nothing_of_them_or_does_not_switch_them_is_told() {
        let mut words = Words::default();
        words.name();
        for missing in
            [FromController { inputs: None, ..said(0, 0) }, FromController { outputs: None, ..said(0, 0) }]
        {
            assert_eq!(words.begin(&missing), Err(NO_WORDS));
        }
        words.begin(&said(0, 0)).expect("both words");
        words.switch(&told(&[(3, true)]));
        // Answers that it has not taken say nothing; others have outputs, too.
        for _ in 0..100 {
            assert_eq!(words.hear(&said(0, 0b0001), false), Ok(()));
        }
        for _ in 0..SWITCHES {
            assert_eq!(words.hear(&said(0, 0b0001), true), Ok(()));
        }
        assert_eq!(words.hear(&said(0, 0b0001), true), Err(NOT_SWITCHED));
        for _ in 0..100 {
            assert_eq!(words.hear(&said(0, 0b1001), true), Ok(()));
        }
    }
}
