//! What a launcher and the processes that it started tell each other, over a socket that is each process's standard
//! input.
//!
//! In: frames of a fixed size. Out: the same frames at the other end, in the order in which they were sent. The end of
//! the stream means that the other side has ended: by it a process notices that its launcher is gone, and the launcher
//! that a process has died.

use core::ops::Range;
use std::io::{self, ErrorKind, Read, Write};
use std::net::Shutdown;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;

use rustix::net::{SendFlags, send};

use crate::board::figures::{FIGURES_WORDS, Figures};
use crate::link::{Clock, Seal};
use crate::machine::identity::CellId;
use crate::machine::scheduling::Lacks;
use mrroc_core::cell::Rest;
use mrroc_core::fault::Name;
use mrroc_core::fault::{Fault, FaultWords, ProcessId, Role};
use mrroc_core::link::Nanos;
use mrroc_core::link::places::Places;
use mrroc_core::operator::Request;
use mrroc_core::operator::button::Button;
use mrroc_core::payload::{BadWords, Wire};

/// Words of a frame.
const WORDS: usize = 40;

/// The words of a frame with the places to which a process has sent messages.
const WOKEN: Range<usize> = 2..2 + Places::WORDS;

/// Bytes of a frame.
pub(super) const FRAME: usize = 8 * WORDS;

/// A frame from a launcher to a process, or from a process to its launcher.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Frame {
    /// To a process: which run of which cell it belongs to, by which clock the run goes, and how long to poll before it
    /// sleeps \[ns\].
    Welcome { seal: Seal, cell: CellId, clock: Clock, spin: Nanos },
    /// To a process: all processes have made what others open; now open what the others have made.
    Connect,
    /// To a process: all processes are connected; run. The cell's time begins at `origin` of the machine's monotonic
    /// clock \[ns\].
    Go { origin: Nanos },
    /// To a process, in lock-step: run until you wait. The time is now `now` \[ns\].
    Resume { now: Nanos },
    /// To an MP: a process is gone.
    Lost(ProcessId),
    /// To an MP: the operator aborts.
    Abort,
    /// To an MP: the operator has pressed a button; the answer is shown under this number.
    Press { number: u64, button: Button },
    /// To a process: the cell closes.
    Close,
    /// From a process: it has made what others open; with a hash of the cell that it has put together.
    Created { fingerprint: u64 },
    /// From a process: it is connected; with what the machine did not grant it.
    Ready { lacks: Lacks },
    /// From a process, in lock-step: it waits, at most until `deadline` \[ns\]; with the places to which it has sent
    /// messages.
    Waits { deadline: Nanos, woken: Places },
    /// From a process, in lock-step: the process at `place` is to run until it waits, then this process goes on; with
    /// the other places to which it has sent messages, one bit each.
    Calls { place: u64, woken: Places },
    /// From the plant: a robot has come to a standstill after its demands had stopped.
    Rested(Rest),
    /// From a process, in real time, once a second and at the end: how late it was and how long it worked.
    Figures(Figures),
    /// From a process: it cannot take part, for this reason.
    Refuses(String),
    /// From a carrier, in place of a process of another machine: that process has ended like this.
    Gone(String),
    /// From a process: its part is over; with the steps begun, the time \[ns\], and how its program ended, if it had
    /// one. To a plant that is watched: the same of the whole cell.
    Over { steps: u64, time: Nanos, outcome: Option<Result<(), Fault>> },
}

impl Frame {
    fn put(&self, words: &mut [u64; WORDS]) {
        words[0] = match self {
            Frame::Welcome { seal, cell, clock, spin } => {
                words[1..6].copy_from_slice(&[
                    seal.session,
                    seal.epoch,
                    u64::from(*clock == Clock::Virtual),
                    *spin,
                    cell.0,
                ]);
                1
            }
            Frame::Connect => 2,
            Frame::Go { origin } => {
                words[1] = *origin;
                3
            }
            Frame::Resume { now } => {
                words[1] = *now;
                4
            }
            Frame::Lost(process) => {
                words[1] = process.role as u64;
                if let Some(name) = process.name {
                    name.put(&mut words[2..5]);
                }
                5
            }
            Frame::Abort => 6,
            Frame::Press { number, button } => {
                words[1] = *number;
                put_text(&mut words[2..], &button.to_string());
                20
            }
            Frame::Close => 7,
            Frame::Created { fingerprint } => {
                words[1] = *fingerprint;
                8
            }
            Frame::Ready { lacks } => {
                words[1] = lacks.to_word();
                9
            }
            Frame::Waits { deadline, woken } => {
                words[1] = *deadline;
                words[WOKEN].copy_from_slice(&woken.to_words());
                10
            }
            Frame::Calls { place, woken } => {
                words[1] = *place;
                words[WOKEN].copy_from_slice(&woken.to_words());
                13
            }
            Frame::Rested(rest) => {
                words[1..3].copy_from_slice(&[rest.braked_after, rest.stood_after]);
                if let Some(name) = rest.edp.name {
                    name.put(&mut words[3..6]);
                }
                14
            }
            Frame::Figures(figures) => {
                figures.put(&mut words[1..]);
                15
            }
            Frame::Refuses(text) | Frame::Gone(text) => {
                put_text(&mut words[1..], text);
                if matches!(self, Frame::Gone(_)) { 21 } else { 11 }
            }
            Frame::Over { steps, time, outcome } => {
                let code = match outcome {
                    None => 0,
                    Some(Ok(())) => 1,
                    Some(Err(fault)) => {
                        FaultWords::from(fault).put(&mut words[4..]);
                        2
                    }
                };
                words[1..4].copy_from_slice(&[*steps, *time, code]);
                12
            }
        };
    }

    fn get(words: &[u64; WORDS]) -> Result<Frame, BadWords> {
        Ok(match words[0] {
            1 => Frame::Welcome {
                seal: Seal { session: words[1], epoch: words[2] },
                clock: if words[3] == 0 { Clock::Real } else { Clock::Virtual },
                spin: words[4],
                cell: CellId(words[5]),
            },
            2 => Frame::Connect,
            3 => Frame::Go { origin: words[1] },
            4 => Frame::Resume { now: words[1] },
            5 => {
                let roles = [Role::Mp, Role::Ecp, Role::Edp, Role::Vsp, Role::Plant, Role::Node];
                let role = roles.into_iter().find(|role| *role as u64 == words[1]).ok_or(BadWords)?;
                Frame::Lost(ProcessId { role, name: Name::get(&words[2..5]).ok() })
            }
            6 => Frame::Abort,
            20 => {
                let Ok(Request::Press(button)) = Request::read(&text(&words[2..])?) else {
                    return Err(BadWords);
                };
                Frame::Press { number: words[1], button }
            }
            7 => Frame::Close,
            8 => Frame::Created { fingerprint: words[1] },
            9 => Frame::Ready { lacks: Lacks::from_word(words[1]) },
            10 => Frame::Waits { deadline: words[1], woken: woken(words)? },
            11 | 21 => {
                let text = text(&words[1..])?;
                if words[0] == 21 { Frame::Gone(text) } else { Frame::Refuses(text) }
            }
            12 => {
                let outcome = match words[3] {
                    0 => None,
                    1 => Some(Ok(())),
                    2 => Some(Err(FaultWords::get(&words[4..])?.into())),
                    _ => return Err(BadWords),
                };
                Frame::Over { steps: words[1], time: words[2], outcome }
            }
            13 => Frame::Calls { place: words[1], woken: woken(words)? },
            15 => {
                let figures = words[1..].first_chunk::<FIGURES_WORDS>().ok_or(BadWords)?;
                Frame::Figures(Figures::get(figures))
            }
            14 => Frame::Rested(Rest {
                edp: ProcessId::new(Role::Edp, Name::get(&words[3..6])?),
                braked_after: words[1],
                stood_after: words[2],
            }),
            _ => return Err(BadWords),
        })
    }
}

impl Frame {
    /// The frame as it is sent.
    pub(super) fn to_bytes(&self) -> [u8; FRAME] {
        let mut words = [0; WORDS];
        self.put(&mut words);
        let mut bytes = [0; FRAME];
        for (chunk, word) in bytes.chunks_exact_mut(8).zip(words) {
            chunk.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }

    /// The frame in what was sent.
    pub(super) fn from_bytes(bytes: &[u8; FRAME]) -> Result<Frame, BadWords> {
        let mut words = [0; WORDS];
        for (chunk, word) in bytes.as_chunks::<8>().0.iter().zip(&mut words) {
            *word = u64::from_le_bytes(*chunk);
        }
        Frame::get(&words)
    }
}

/// The places to which a process has sent messages.
fn woken(words: &[u64; WORDS]) -> Result<Places, BadWords> {
    words[WOKEN].try_into().map(Places::from_words).map_err(|_| BadWords)
}

/// Puts the length of a text, and as much of it as the words take.
fn put_text(words: &mut [u64], text: &str) {
    let len = text.floor_char_boundary(8 * (words.len() - 1));
    words[0] = len as u64;
    for (word, chunk) in words[1..].iter_mut().zip(text.as_bytes()[..len].chunks(8)) {
        let mut bytes = [0; 8];
        bytes[..chunk.len()].copy_from_slice(chunk);
        *word = u64::from_le_bytes(bytes);
    }
}

/// The text in words.
fn text(words: &[u64]) -> Result<String, BadWords> {
    let bytes: Vec<u8> = words[1..].iter().flat_map(|word| word.to_le_bytes()).collect();
    let text = usize::try_from(words[0]).ok().and_then(|len| bytes.get(..len)).ok_or(BadWords)?;
    Ok(String::from_utf8_lossy(text).into_owned())
}

/// One end of the socket.
#[derive(Debug)]
pub(crate) struct Control(UnixStream);

impl Control {
    pub(super) fn new(stream: UnixStream) -> Control {
        Control(stream)
    }

    /// Sends a frame.
    pub(super) fn send(&self, frame: &Frame) -> io::Result<()> {
        (&self.0).write_all(&frame.to_bytes())
    }

    /// Sends a frame, unless the other side has left so many unread that it would have to be waited for.
    pub(super) fn send_now(&self, frame: &Frame) -> io::Result<()> {
        // The socket takes a frame as a whole, because it is shorter than a page.
        send(&self.0, &frame.to_bytes(), SendFlags::DONTWAIT | SendFlags::NOSIGNAL)?;
        Ok(())
    }

    /// Sends nothing more: the other side sees the end of the stream.
    pub(super) fn hang_up(&self) {
        // It fails if the other side has hung up already.
        drop(self.0.shutdown(Shutdown::Write));
    }

    /// Waits for a frame.
    pub(super) fn receive(&self) -> io::Result<Frame> {
        let mut bytes = [0; FRAME];
        (&self.0).read_exact(&mut bytes)?;
        let frame = Frame::from_bytes(&bytes);
        frame.map_err(|_| io::Error::new(ErrorKind::InvalidData, "no frame of this program"))
    }

    /// From now on, waits for frames without a time-out.
    pub(super) fn wait_for_ever(&self) -> io::Result<()> {
        self.0.set_read_timeout(None)
    }

    /// Another handle of this end.
    pub(super) fn try_clone(&self) -> io::Result<Control> {
        self.0.try_clone().map(Control)
    }

    /// The file descriptor that becomes readable when a frame comes.
    pub(crate) fn descriptor(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_core::fault::FaultKind;
    use mrroc_core::robot::MAX_JOINTS;

    #[test]
    fn every_frame_comes_out_as_it_went_in_and_the_end_of_the_stream_is_an_error() {
        let (ours, theirs) = UnixStream::pair().expect("a pair of sockets");
        let (ours, theirs) = (Control::new(ours), Control::new(theirs));
        let name = Name::new("a-name-of-24-bytes-at-all").or(Name::new("a-name-of-24-bytes-total"));
        let edp = ProcessId::new(Role::Edp, name.expect("a name"));
        let fault = Fault::new(FaultKind::DriveFault).in_process(edp).at_step(3).text("no brake");
        let seal = Seal { session: 1, epoch: 2 };
        let positions = " -1.2345678901234567e-300".repeat(MAX_JOINTS);
        let jog =
            format!("jog {} {} {} to 12.123456789%{positions}", u64::MAX >> 16, u16::MAX, "x".repeat(24));
        let Ok(Request::Press(longest)) = Request::read(&jog) else { panic!("no jog") };
        let frames = [
            Frame::Welcome { seal, cell: CellId(u64::MAX), clock: Clock::Virtual, spin: 3 },
            Frame::Welcome { seal, cell: CellId(1), clock: Clock::Real, spin: 0 },
            Frame::Connect,
            Frame::Go { origin: u64::MAX },
            Frame::Resume { now: 5 },
            Frame::Lost(edp),
            Frame::Lost(ProcessId::MP),
            Frame::Abort,
            Frame::Press { number: 6, button: Button::Speed(0.25) },
            Frame::Press { number: 7, button: Button::Stop },
            Frame::Press { number: 8, button: longest },
            Frame::Close,
            Frame::Created { fingerprint: 7 },
            Frame::Ready { lacks: Lacks::from_word(5) },
            Frame::Waits { deadline: 8, woken: Places::of(9).with(150) },
            Frame::Calls { place: 8, woken: Places::of(9).with(150) },
            Frame::Figures(Figures { skipped: 1, overruns: 2, dropped: 3, ..Figures::default() }),
            Frame::Rested(Rest { edp, braked_after: 11, stood_after: 3 }),
            Frame::Refuses("no shared memory: größer".to_owned()),
            Frame::Gone("it was killed by signal 9".to_owned()),
            Frame::Over { steps: 1, time: 2, outcome: None },
            Frame::Over { steps: 1, time: 2, outcome: Some(Ok(())) },
            Frame::Over { steps: 1, time: 2, outcome: Some(Err(fault)) },
        ];
        for frame in &frames {
            ours.send(frame).expect("sent");
            assert_eq!(&theirs.receive().expect("came"), frame);
        }
        drop(ours);
        assert_eq!(theirs.receive().map_err(|error| error.kind()), Err(ErrorKind::UnexpectedEof));
    }

    #[test]
    fn words_that_spell_no_frame_are_refused() {
        // No tag; an unknown tag; a text, a role, an outcome and a button that do not exist.
        for words in [[0; WORDS], [99; WORDS]] {
            assert_eq!(Frame::get(&words), Err(BadWords));
        }
        for (tag, place) in [(11, 1), (5, 1), (12, 3), (20, 2)] {
            let mut words = [0; WORDS];
            (words[0], words[place]) = (tag, u64::MAX);
            assert_eq!(Frame::get(&words), Err(BadWords));
        }
    }
}
