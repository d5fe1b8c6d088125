//! A hand that is none, for tests: Franka's interface for it at an address, and fingers that move in real time.
//!
//! In: requests over TCP. Out: answers, and states as datagrams. It is written from libfranka's `types.h` apart from the driver, and
//! Franka's own client drives it in `tests/peers/drives`. What a real hand does where its documents are silent is assumed: a move whose
//! fingers are held back does not end by itself, a stop lets go what is grasped, and a request beside a motion fails.

#![expect(clippy::disallowed_methods, reason = "fingers move in real time")]

use std::io::{ErrorKind, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How far the fingers open \[m\].
pub const STROKE: f64 = 0.08;

/// Between two states.
const STATES: Duration = Duration::from_millis(10);

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
    /// How many times faster it homes.
    pub haste: f64,
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
            haste: 1.0,
            is_silent: false,
            is_restless: false,
            hangs_up: false,
            instead: None,
            refuses: None,
            connections: 0,
            asked: Vec::new(),
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
    fn ask(&mut self, request: u16, id: u32, numbers: Vec<f64>) -> Vec<(u16, u32, u16)> {
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
            (HOMING, []) => Motion { request, id: Some(id), to: STROKE, speed: 0.1 * self.haste, band: none },
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
        let motion = self.motion?;
        let way = (motion.to - self.width).clamp(-motion.speed * time, motion.speed * time);
        let held =
            self.object.filter(|&object| way < 0.0 && object <= self.width && self.width + way < object);
        self.width = held.unwrap_or(self.width + way);
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

/// The hand, served by a thread that lives as long as the program.
#[derive(Clone, Debug)]
pub struct Fake {
    fingers: Arc<Mutex<Fingers>>,
    /// Where it listens.
    pub address: SocketAddr,
}

impl Fake {
    /// At an address; port 0 is any.
    ///
    /// # Errors
    /// There is no such address, or its port is taken.
    pub fn at(address: SocketAddr, fingers: Fingers) -> std::io::Result<Fake> {
        let listener = TcpListener::bind(address)?;
        let fake = Fake { fingers: Arc::new(Mutex::new(fingers)), address: listener.local_addr()? };
        let of_thread = fake.clone();
        std::thread::spawn(move || {
            for socket in listener.incoming() {
                of_thread.look(|fingers| {
                    fingers.connections += 1;
                    // What goes on is answered to nobody.
                    fingers.motion = fingers.motion.map(|motion| Motion { id: None, ..motion });
                });
                // The other end hangs up when it likes.
                drop(socket.and_then(|socket| of_thread.serve(socket)));
            }
        });
        Ok(fake)
    }

    /// Looks at the fingers, or changes them.
    pub fn look<T>(&self, look: impl FnOnce(&mut Fingers) -> T) -> T {
        look(&mut self.fingers.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn serve(&self, mut socket: TcpStream) -> std::io::Result<()> {
        socket.set_nodelay(true)?;
        socket.set_read_timeout(Some(Duration::from_millis(1)))?;
        let (here, there): (IpAddr, IpAddr) = (socket.local_addr()?.ip(), socket.peer_addr()?.ip());
        let states = UdpSocket::bind((here, 0))?;
        let mut to = None;
        let (mut bytes, mut buffer) = (Vec::new(), [0; 256]);
        let (mut before, mut sent, mut count) = (Instant::now(), Instant::now(), 0);
        loop {
            match socket.read(&mut buffer) {
                Ok(0) => return Ok(()),
                Ok(len) => bytes.extend_from_slice(&buffer[..len]),
                Err(why) if matches!(why.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(why) => return Err(why),
            }
            let (passed, now) = (before.elapsed().as_secs_f64(), Instant::now());
            before = now;
            let mut ended: Vec<_> = self.look(|fingers| fingers.go_on(passed)).into_iter().collect();
            while let Some((request, id, says)) = message(&mut bytes) {
                if request == 0 {
                    let word = |at: usize| u16::from_le_bytes([says[at], says[at + 1]]);
                    let version = self.look(|fingers| fingers.version);
                    let agrees = word(0) == version;
                    to = agrees.then_some((there, word(2)));
                    let status = [u16::from(!agrees).to_le_bytes(), version.to_le_bytes()].concat();
                    self.answer(&mut socket, (request, id), &status)?;
                    continue;
                }
                let numbers = says.chunks_exact(8).map(|eight| {
                    let mut number = [0; 8];
                    number.copy_from_slice(eight);
                    f64::from_le_bytes(number)
                });
                ended.extend(self.look(|fingers| fingers.ask(request, id, numbers.collect())));
            }
            for (request, id, status) in ended {
                self.answer(&mut socket, (request, id), &status.to_le_bytes())?;
            }
            let state = self.look(|fingers| (!fingers.is_silent).then(|| fingers.state(count)));
            if let (Some(to), Some(state)) = (to, state)
                && sent.elapsed() >= STATES
            {
                // The other end may have gone.
                let _ = states.send_to(&state, to);
                self.look(Fingers::be_moved);
                (sent, count) = (Instant::now(), count + 1);
            }
            if self.look(|fingers| core::mem::take(&mut fingers.hangs_up)) {
                return Ok(());
            }
        }
    }

    fn answer(&self, socket: &mut TcpStream, (request, id): (u16, u32), says: &[u8]) -> std::io::Result<()> {
        if let Some(instead) = self.look(|fingers| fingers.instead.take()) {
            return socket.write_all(&instead);
        }
        let size = 10 + says.len() as u32;
        let whole = [request.to_le_bytes().as_slice(), &id.to_le_bytes(), &size.to_le_bytes(), says].concat();
        // In pieces, as TCP may bring it.
        whole.chunks(5).try_for_each(|piece| socket.write_all(piece))
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
