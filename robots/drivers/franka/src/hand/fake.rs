//! A hand that is none, for tests: Franka's interface for it, and fingers that move in whatever time it is given.
//!
//! In: requests over a connection. Out: answers, and states as datagrams. It is written from libfranka's `types.h` apart from the driver,
//! and Franka's own client drives it in `tests/peers/drives`. What a real hand does where its documents are silent is assumed: a move
//! whose fingers are held back does not end by itself, a stop lets go what is grasped, and a request beside a motion fails.

use core::time::Duration;

use mrroc_driver_kit::testing::{Device, Reply};

/// How far the fingers open \[m\].
pub const STROKE: f64 = 0.08;

/// Between two states.
const STATES: Duration = Duration::from_millis(10);

/// How long its fingers move before it looks where they are.
const PAUSE: Duration = Duration::from_millis(1);

/// Requests by their numbers.
pub const HOMING: u16 = 1;
pub const GRASP: u16 = 2;
pub const MOVE: u16 = 3;
pub const STOP: u16 = 4;

/// Where the fingers are going.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    request: u16,
    /// Who waits for its end.
    id: Option<u32>,
    to: f64,
    speed: f64,
    /// Between which openings something counts as grasped \[m\].
    band: (f64, f64),
}

/// The fingers, and what is wrong with them.
#[derive(Clone, Debug)]
pub struct Fingers {
    /// The opening \[m\].
    pub width: f64,
    /// As homing has measured it; 0 before.
    pub max_width: f64,
    /// How wide what lies between them is \[m\].
    pub object: Option<f64>,
    /// Whether it is grasped.
    pub is_grasped: bool,
    /// Its version of the interface.
    pub version: u16,
    /// Its fingers do not move, whatever goes on.
    pub is_stuck: bool,
    /// It sends no states any more.
    pub is_silent: bool,
    /// Somebody else moves them: each state has another opening than the one before.
    pub is_restless: bool,
    /// It closes its connections.
    pub hangs_up: bool,
    /// Bytes in place of the next answer.
    pub instead: Option<Vec<u8>>,
    /// What the next motion is answered at once.
    pub refuses: Option<u16>,
    /// How often somebody has connected.
    pub connections: usize,
    /// What was asked for, but for connections, in order: the request and its numbers.
    pub asked: Vec<(u16, Vec<f64>)>,
    /// When the last of that was asked, and when it has sent a state last.
    pub asked_at: Duration,
    pub sent_at: Duration,
    /// What goes on.
    pub motion: Option<Motion>,
}

impl Fingers {
    /// Open and homed.
    pub const fn open() -> Fingers {
        Fingers {
            width: STROKE,
            max_width: STROKE,
            object: None,
            is_grasped: false,
            version: 3,
            is_stuck: false,
            is_silent: false,
            is_restless: false,
            hangs_up: false,
            instead: None,
            refuses: None,
            connections: 0,
            asked: Vec::new(),
            asked_at: Duration::ZERO,
            sent_at: Duration::ZERO,
            motion: None,
        }
    }

    /// What somebody else does between two states.
    fn be_moved(&mut self) {
        if self.is_restless {
            self.width = if self.width > 0.07 { 0.06 } else { 0.08 };
        }
    }

    /// The answers to a request: number of the request that is answered, its own number, what it says.
    pub fn ask(&mut self, request: u16, id: u32, numbers: Vec<f64>) -> Vec<(u16, u32, u16)> {
        const DONE: u16 = 0;
        const FAILED: u16 = 1;
        const ABORTED: u16 = 3;
        self.asked.push((request, numbers.clone()));
        if request == STOP {
            let ended = self.motion.take().and_then(|motion| Some((motion.request, motion.id?, ABORTED)));
            self.is_grasped = false;
            return ended.into_iter().chain([(request, id, DONE)]).collect();
        }
        if let Some(status) = self.refuses.take() {
            return vec![(request, id, status)];
        }
        let reaches = |width: f64| (0.0..=self.max_width).contains(&width) && self.max_width > 0.0;
        let none = (0.0, 0.0);
        let motion = match (request, &numbers[..]) {
            (HOMING, []) => Motion { request, id: Some(id), to: STROKE, speed: 0.1, band: none },
            (MOVE, &[to, speed]) if reaches(to) && speed > 0.0 => {
                Motion { request, id: Some(id), to, speed, band: none }
            }
            (GRASP, &[width, inner, outer, speed, force])
                if reaches(width) && inner >= 0.0 && outer >= 0.0 && speed > 0.0 && force > 0.0 =>
            {
                Motion { request, id: Some(id), to: 0.0, speed, band: (width - inner, width + outer) }
            }
            _ => return vec![(request, id, FAILED)],
        };
        if self.motion.is_some() {
            return vec![(request, id, FAILED)];
        }
        (self.motion, self.is_grasped) = (Some(motion), false);
        Vec::new()
    }

    /// So much time \[s\] passes. What has ended, as in `ask`.
    fn go_on(&mut self, time: f64) -> Option<(u16, u32, u16)> {
        let motion = self.motion.filter(|_| !self.is_stuck)?;
        let change = (motion.to - self.width).clamp(-motion.speed * time, motion.speed * time);
        let held = self
            .object
            .filter(|&object| change < 0.0 && object <= self.width && self.width + change < object);
        self.width = held.unwrap_or(self.width + change);
        let status = match (motion.request, held) {
            (GRASP, _) if held.is_some() || self.width <= motion.to => {
                self.is_grasped = motion.band.0 < self.width && self.width < motion.band.1;
                if self.is_grasped { 0 } else { 2 }
            }
            (HOMING, _) if self.width >= STROKE => {
                self.max_width = STROKE;
                0
            }
            (MOVE, None) if self.width == motion.to => 0,
            _ => return None,
        };
        self.motion = None;
        Some((motion.request, motion.id?, status))
    }

    fn state(&self, count: u32) -> Vec<u8> {
        [
            count.to_le_bytes().as_slice(),
            &self.width.to_le_bytes(),
            &self.max_width.to_le_bytes(),
            &[u8::from(self.is_grasped)],
            &30_u16.to_le_bytes(),
        ]
        .concat()
    }
}

/// The hand: its fingers, and what it says to whom.
#[derive(Debug)]
pub struct Fake {
    /// Its fingers.
    pub fingers: Fingers,
    /// When its fingers have moved last.
    now: Duration,
    /// How many states it has sent to whoever is connected.
    count: u32,
    /// The port to which states go, of whoever is connected.
    port: Option<u16>,
    /// What has come of the next request.
    bytes: Vec<u8>,
}

impl Fake {
    /// With these fingers.
    pub const fn new(fingers: Fingers) -> Fake {
        Fake { fingers, now: Duration::ZERO, count: 0, port: None, bytes: Vec::new() }
    }

    /// What a request of somebody who connects is answered: states go to their port if they speak the same version.
    fn connect(&mut self, says: &[u8]) -> Vec<u8> {
        let word = |at: usize| u16::from_le_bytes([says[at], says[at + 1]]);
        let version = self.fingers.version;
        let agrees = word(0) == version;
        self.port = agrees.then_some(word(2));
        [u16::from(!agrees).to_le_bytes(), version.to_le_bytes()].concat()
    }

    fn answer(&mut self, (request, id): (u16, u32), says: &[u8], reply: &mut Reply) {
        if let Some(instead) = self.fingers.instead.take() {
            return reply.bytes.extend(instead);
        }
        let size = 10 + says.len() as u32;
        let whole = [request.to_le_bytes().as_slice(), &id.to_le_bytes(), &size.to_le_bytes(), says].concat();
        reply.bytes.extend(whole);
    }
}

impl Device for Fake {
    fn connected(&mut self) {
        self.fingers.connections += 1;
        // What goes on is answered to nobody.
        self.fingers.motion = self.fingers.motion.map(|motion| Motion { id: None, ..motion });
        (self.port, self.count) = (None, 0);
        self.bytes.clear();
    }

    fn poll(&mut self, now: Duration, received: &[u8], reply: &mut Reply) -> Duration {
        let passed = now.saturating_sub(core::mem::replace(&mut self.now, now));
        let mut ended: Vec<_> = self.fingers.go_on(passed.as_secs_f64()).into_iter().collect();
        self.bytes.extend_from_slice(received);
        while let Some((request, id, says)) = message(&mut self.bytes) {
            if request == 0 {
                let status = self.connect(&says);
                self.answer((request, id), &status, reply);
                continue;
            }
            let numbers = says.chunks_exact(8).map(|eight| {
                let mut number = [0; 8];
                number.copy_from_slice(eight);
                f64::from_le_bytes(number)
            });
            self.fingers.asked_at = now;
            ended.extend(self.fingers.ask(request, id, numbers.collect()));
        }
        for (request, id, status) in ended {
            self.answer((request, id), &status.to_le_bytes(), reply);
        }
        if let Some(port) = self.port
            && !self.fingers.is_silent
            && now >= self.fingers.sent_at + STATES
        {
            reply.datagrams.push((port, self.fingers.state(self.count)));
            self.fingers.be_moved();
            (self.fingers.sent_at, self.count) = (now, self.count + 1);
        }
        reply.closes = core::mem::take(&mut self.fingers.hangs_up);
        now + PAUSE
    }
}

/// The request at the front of these bytes, if it is there as a whole: its kind, its number, what it says.
fn message(bytes: &mut Vec<u8>) -> Option<(u16, u32, Vec<u8>)> {
    let head: [u8; 10] = bytes.get(..10)?.try_into().ok()?;
    let size = u32::from_le_bytes([head[6], head[7], head[8], head[9]]) as usize;
    if size < 10 || bytes.len() < size {
        return None;
    }
    let rest = bytes.split_off(size);
    let says = core::mem::replace(bytes, rest).split_off(10);
    Some((
        u16::from_le_bytes([head[0], head[1]]),
        u32::from_le_bytes([head[2], head[3], head[4], head[5]]),
        says,
    ))
}
