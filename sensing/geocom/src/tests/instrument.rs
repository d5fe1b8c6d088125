//! An instrument at the other end of a line, and the line, under a virtual clock.

use std::collections::VecDeque;

use super::*;

/// What comes of an answer on its way: the answer to each question, from 0, is what this makes of it.
pub type Spoil<'t> = Box<dyn FnMut(usize, String) -> Vec<String> + Send + 't>;

/// A simulated instrument, which takes its time.
pub struct Instrument<'t> {
    pub simulated: Simulated<Targets>,
    /// How long it takes to answer.
    pub takes: Duration,
    spoil: Spoil<'t>,
    /// Questions that have come.
    pub asked: usize,
    /// When.
    pub times: Vec<Duration>,
    lines: Lines,
    /// What it sends, and when.
    due: VecDeque<(Duration, Vec<u8>)>,
}

impl<'t> Instrument<'t> {
    pub fn new(spoil: impl FnMut(usize, String) -> Vec<String> + Send + 't) -> Self {
        Self {
            simulated: simulated(),
            takes: MS(30),
            spoil: Box::new(spoil),
            asked: 0,
            times: Vec::new(),
            lines: Lines::new(),
            due: VecDeque::new(),
        }
    }

    /// What it sends by now, where these bytes have come; and when it sends the next.
    pub fn poll(&mut self, now: Duration, bytes: &[u8]) -> (Vec<u8>, Option<Duration>) {
        self.lines.push(bytes);
        while let Some(line) = self.lines.next_line().expect("a client sends lines") {
            if let Some(answer) = self.simulated.answer(&line) {
                for answer in (self.spoil)(self.asked, answer) {
                    // A line takes some time, and its halves are read one after the other.
                    let bytes = format!("{answer}\r\n").into_bytes();
                    let (first, second) = bytes.split_at(bytes.len() / 2);
                    self.due.push_back((now + self.takes, first.to_vec()));
                    self.due.push_back((now + self.takes + MS(10), second.to_vec()));
                }
            }
            self.asked += 1;
            self.times.push(now);
        }
        let mut sent = Vec::new();
        while self.due.front().is_some_and(|(when, _)| *when <= now) {
            sent.extend(self.due.pop_front().into_iter().flat_map(|(_, bytes)| bytes));
        }
        (sent, self.due.front().map(|(when, _)| *when))
    }
}

/// A line to an instrument, under a virtual clock.
pub struct VirtualLine<'t> {
    pub instrument: Instrument<'t>,
    pub now: Duration,
    /// What has come to the client.
    pub came: Vec<u8>,
    /// It is closed once so many questions were answered.
    pub closes_after: usize,
    /// Whether it takes what is sent.
    pub is_taken: bool,
}

/// A line to an instrument whose answers are what this makes of them.
pub fn line_to<'t>(spoil: impl FnMut(usize, String) -> Vec<String> + Send + 't) -> VirtualLine<'t> {
    VirtualLine {
        instrument: Instrument::new(spoil),
        now: Duration::ZERO,
        came: Vec::new(),
        closes_after: usize::MAX,
        is_taken: true,
    }
}

impl VirtualLine<'_> {
    /// What has come since this was asked last.
    pub fn take(&mut self) -> Vec<u8> {
        core::mem::take(&mut self.came)
    }

    /// Does what a client needs before it goes on, or begins to, as [`Connection`] does; time passes as it must.
    pub fn carry_out(&mut self, next: ClientAction, client: &mut Client) -> Result<(), GeocomError> {
        match next {
            ClientAction::Send { until } if self.is_taken => {
                assert!(until > self.now);
                // A part of it, and then the rest.
                let count = client.outgoing().len().div_ceil(2);
                let (sent, _) = self.instrument.poll(self.now, &client.outgoing()[..count]);
                self.came.extend(sent);
                client.sent(count);
            }
            ClientAction::Send { until } => self.now = until,
            ClientAction::Receive { until } => {
                let (sent, next) = self.instrument.poll(self.now, &[]);
                let is_over = self.instrument.asked >= self.closes_after && next.is_none();
                if sent.is_empty() && is_over {
                    return Err(GeocomError::Closed);
                }
                if sent.is_empty() {
                    let until = until.max(self.now);
                    self.now = next.map_or(until, |next| next.clamp(self.now, until));
                    let (sent, _) = self.instrument.poll(self.now, &[]);
                    self.came.extend(sent);
                }
                self.came.extend(sent);
            }
            ClientAction::Done(_) | ClientAction::Idle => {}
        }
        Ok(())
    }

    /// Runs a client until it is done.
    pub fn run(&mut self, client: &mut Client) -> Result<Option<Measured>, GeocomError> {
        loop {
            match client.poll(self.now, &self.take()) {
                ClientAction::Done(outcome) => return outcome,
                ClientAction::Idle => panic!("nothing was asked for"),
                next => self.carry_out(next, client)?,
            }
        }
    }
}
