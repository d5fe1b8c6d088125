//! What nodes say to one another: a byte for the kind, the session, and what belongs to the kind.
//!
//! In: bytes that the network has brought from a node. Out: what that node says, or nothing where it is none of it.

use mrroc_core::link::Nanos;
use mrroc_core::link::envelope::{Envelope, Seal};

use super::identity::Identity;
use crate::control::{FRAME, Frame};

/// What a node says.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "it is looked at where it was made")]
pub(super) enum NodeMessage {
    /// To an agent: it is to start its processes of this run.
    Hello(Identity, Seal),
    /// From an agent: its processes start.
    Agreed,
    /// From an agent: it does not take part, for this reason.
    Refused(String),
    /// A frame between the launcher and the process at a place.
    Frame(u16, Frame),
    /// From an agent: the process at a place has ended like this.
    Gone(u16, String),
    /// What stands in one of the cell's slots.
    Slot(u16, Envelope),
    /// From an agent, at a time of its clock \[ns\].
    Ping(Nanos),
    /// The answer: when the agent asked, and when it was answered, each by its own clock \[ns\].
    Pong(Nanos, Nanos),
}

impl NodeMessage {
    const HELLO: u8 = 1;
    const AGREED: u8 = 2;
    const REFUSED: u8 = 3;
    const FRAME: u8 = 4;
    const GONE: u8 = 5;
    const SLOT: u8 = 6;
    const PING: u8 = 7;
    const PONG: u8 = 8;

    /// Writes it into `bytes`, of the run in this session.
    pub fn put(&self, session: u64, bytes: &mut Vec<u8>) {
        bytes.clear();
        let mut begin = |kind: u8| {
            bytes.push(kind);
            bytes.extend(session.to_le_bytes());
        };
        match self {
            NodeMessage::Hello(identity, seal) => {
                begin(NodeMessage::HELLO);
                for word in [identity.version, identity.program, identity.file, seal.session, seal.epoch] {
                    bytes.extend(word.to_le_bytes());
                }
            }
            NodeMessage::Agreed => begin(NodeMessage::AGREED),
            NodeMessage::Refused(text) => {
                begin(NodeMessage::REFUSED);
                bytes.extend(text.as_bytes());
            }
            NodeMessage::Frame(place, frame) => {
                begin(NodeMessage::FRAME);
                bytes.extend(place.to_le_bytes());
                bytes.extend(frame.to_bytes());
            }
            NodeMessage::Gone(place, how) => {
                begin(NodeMessage::GONE);
                bytes.extend(place.to_le_bytes());
                bytes.extend(how.as_bytes());
            }
            NodeMessage::Slot(slot, envelope) => {
                begin(NodeMessage::SLOT);
                bytes.extend(slot.to_le_bytes());
                envelope.put_bytes(bytes);
            }
            NodeMessage::Ping(sent) => {
                begin(NodeMessage::PING);
                bytes.extend(sent.to_le_bytes());
            }
            NodeMessage::Pong(sent, answered) => {
                begin(NodeMessage::PONG);
                bytes.extend(sent.to_le_bytes());
                bytes.extend(answered.to_le_bytes());
            }
        }
    }

    /// The same in bytes of their own.
    pub fn to_bytes(&self, session: u64) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.put(session, &mut bytes);
        bytes
    }

    /// Reads what a node says, and in which session; `None` if it is nothing that a node says.
    pub fn read(bytes: &[u8]) -> Option<(u64, NodeMessage)> {
        let (&kind, rest) = bytes.split_first()?;
        let (session, rest) = word(rest)?;
        let said = match kind {
            NodeMessage::HELLO => {
                let (version, rest) = word(rest)?;
                let (program, rest) = word(rest)?;
                let (file, rest) = word(rest)?;
                let (session, rest) = word(rest)?;
                let (epoch, rest) = word(rest)?;
                rest.is_empty().then_some(())?;
                NodeMessage::Hello(Identity { version, program, file }, Seal { session, epoch })
            }
            NodeMessage::AGREED => NodeMessage::Agreed,
            NodeMessage::REFUSED => NodeMessage::Refused(text(rest)),
            NodeMessage::FRAME => {
                let (place, rest) = place(rest)?;
                let bytes: &[u8; FRAME] = rest.try_into().ok()?;
                NodeMessage::Frame(place, Frame::from_bytes(bytes).ok()?)
            }
            NodeMessage::GONE => {
                let (place, rest) = place(rest)?;
                NodeMessage::Gone(place, text(rest))
            }
            NodeMessage::SLOT => {
                let (slot, rest) = place(rest)?;
                NodeMessage::Slot(slot, Envelope::from_bytes(rest).ok()?)
            }
            NodeMessage::PING => NodeMessage::Ping(word(rest)?.0),
            NodeMessage::PONG => {
                let (sent, rest) = word(rest)?;
                NodeMessage::Pong(sent, word(rest)?.0)
            }
            _ => return None,
        };
        Some((session, said))
    }
}

fn word(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let (word, rest) = bytes.split_first_chunk()?;
    Some((u64::from_le_bytes(*word), rest))
}

fn place(bytes: &[u8]) -> Option<(u16, &[u8])> {
    let (place, rest) = bytes.split_first_chunk()?;
    Some((u16::from_le_bytes(*place), rest))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_core::link::message::{Kind, Message};

    #[test]
    fn what_a_node_says_comes_out_as_it_went_in_and_what_is_cut_off_is_nothing_or_a_shorter_text() {
        let seal = Seal { session: 77, epoch: 2 };
        let identity = Identity { version: 1, program: u64::MAX, file: 3 };
        let all = [
            NodeMessage::Hello(identity, seal),
            NodeMessage::Agreed,
            NodeMessage::Refused("größer".to_owned()),
            NodeMessage::Frame(190, Frame::Go { origin: 5 }),
            NodeMessage::Gone(3, "it was killed by signal 9".to_owned()),
            NodeMessage::Slot(400, Envelope::seal(&Message::new(Kind::Reply), seal, 6)),
            NodeMessage::Ping(1),
            NodeMessage::Pong(2, u64::MAX),
        ];
        for said in all {
            let bytes = said.to_bytes(77);
            let (session, read) = NodeMessage::read(&bytes).expect("said");
            assert_eq!((session, format!("{read:?}")), (77, format!("{said:?}")));
            for len in 0..bytes.len() {
                let read = NodeMessage::read(&bytes[..len]);
                assert!(
                    matches!(read, None | Some((_, NodeMessage::Refused(_) | NodeMessage::Gone(..)))),
                    "{said:?}: {len}"
                );
            }
        }
        assert!(NodeMessage::read(&[99; 40]).is_none());
    }
}
