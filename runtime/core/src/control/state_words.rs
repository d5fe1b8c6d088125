//! The measured state of a robot as it goes from its EDP, through ECPs and the MP, with the orders for its sensors.

use crate::link::message::{Message, flag};
use crate::model::image::{IMAGE_WORDS, RobotImage, STATE_WORDS};
use crate::model::robot::Robot;
use crate::model::signals::SIGNAL_WORDS;
use crate::model::wire::{WORDS, Wire};
use crate::model::wrench::Wrench;

/// Words of a reply with a robot's image and the wrench on its tool.
const WITH_WRENCH: usize = IMAGE_WORDS + Wrench::LEN;
const _: () = assert!(WITH_WRENCH <= WORDS);

/// The words of a robot's measured state in a reply of its EDP, as the order for a sensor carries them.
#[derive(Clone, Copy)]
pub struct StateWords<'m> {
    state: &'m [u64],
    /// None of a robot that tells no wrench.
    wrench: &'m [u64],
}

impl<'m> StateWords<'m> {
    /// Those of a reply, if it has them.
    pub fn of(reply: &'m Message) -> Option<Self> {
        let wrench = reply.words().get(IMAGE_WORDS..).unwrap_or(&[]);
        reply.is(flag::STATE).then(|| StateWords { state: &reply.body[..STATE_WORDS], wrench })
    }

    /// Writes them, and says how many they are.
    pub fn put(&self, words: &mut [u64]) -> usize {
        let len = self.state.len() + self.wrench.len();
        words[..self.state.len()].copy_from_slice(self.state);
        words[self.state.len()..len].copy_from_slice(self.wrench);
        len
    }

    /// Writes the wrench on the tool, `F_E`, behind a robot's image, and says how many words the two take.
    pub fn put_wrench<R: Robot>(image: &RobotImage<R>, wrench: &Wrench, words: &mut [u64]) -> usize {
        image.signals().put(&mut words[IMAGE_WORDS - SIGNAL_WORDS..]);
        wrench.put(&mut words[IMAGE_WORDS..]);
        WITH_WRENCH
    }
}
