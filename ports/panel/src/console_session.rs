//! A session with the cell's console server, of which this panel is one more console.
//!
//! In: what pages ask for. Out: the console server's answers, and what the cell does, twenty times a second. There are four connections, so
//! that neither a picture nor another request ever holds up a stop, and a hold that is let go does not wait until its last renewal is
//! answered, which takes a step and more.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, SyncSender, TrySendError, channel, sync_channel};
use std::time::{Duration, Instant};

use axum::extract::ws::Utf8Bytes;
use mrroc_core::operator::button::Button;
use mrroc_core::operator::{Answer, LAPSE, OnBehalf, Request};
use mrroc_core::payload::Shape;
use mrroc_launch::panel::AWAITED;
use mrroc_processes::{Caller, ConsoleMessage, Picture, ProcessPicture, RobotPicture};
use serde_json::{Value, json};
use tokio::sync::{oneshot, watch};

use crate::beside::CarriedLoad;
use crate::now::{Appearance, CellMoment, RobotNow};
use crate::readings::{OLD, of_words};
use crate::rules::request::Stamp;

/// Requests that wait for the console server.
const WAITING: usize = 16;

/// How much nicer the thread is that makes pictures: it takes the time that all others leave.
const LAST: i32 = 19;

/// How long a cell that is being started is waited for.
const STARTING: Duration = Duration::from_secs(30);

/// Where requests go.
pub trait RequestSink: Send + Sync {
    /// Asks for something; the answer comes within seconds. However much else is asked for, a stop does not wait for it.
    fn ask(&self, request: Request, by: OnBehalf) -> oneshot::Receiver<Answer>;
}

/// What the cell did last.
#[derive(Clone, Default)]
pub struct CellSnapshot {
    /// For a page.
    pub text: Option<Utf8Bytes>,
    /// The step, and how long a step is \[ns\].
    pub stamp: Option<(Stamp, u64)>,
    /// Its robots.
    pub robots: Arc<[RobotNow]>,
    /// Whether any of them was demanded elsewhere in the picture before.
    pub moves: bool,
    /// Why there will be no more.
    pub over: Option<String>,
}

/// A request, and where its answer goes.
struct Job {
    request: Request,
    by: OnBehalf,
    since: Instant,
    answer: oneshot::Sender<Answer>,
}

/// A session with the console server.
#[derive(Clone)]
pub struct ConsoleSession {
    requests: SyncSender<Job>,
    releases: SyncSender<Job>,
    stops: Sender<Job>,
}

impl ConsoleSession {
    /// Connects to the cell of a file, which may still be starting.
    ///
    /// # Errors
    /// No such cell runs, or it does not answer; with what to do.
    pub fn open(
        cell: &Path,
        looks: Arc<Appearance>,
    ) -> std::io::Result<(ConsoleSession, watch::Receiver<CellSnapshot>)> {
        let (since, is_awaited) = (Instant::now(), std::env::var_os(AWAITED).is_some());
        let mut watching = loop {
            match Caller::to(cell) {
                Ok(caller) => break caller,
                Err(error) if !is_awaited || since.elapsed() > STARTING => return Err(error),
                Err(_) => std::thread::sleep(Duration::from_millis(100)),
            }
        };
        let (show, shown) = watch::channel(CellSnapshot::default());
        watching.asks.ask(&Request::Watch, None)?;
        spawn("watches", move || watch(watching, &looks, &show))?;
        let carries = |name| {
            let (requests, waiting) = sync_channel(WAITING);
            let of = cell.to_owned();
            spawn(name, move || carry(&of, &waiting)).map(|()| requests)
        };
        let (requests, releases) = (carries("asks")?, carries("releases")?);
        let (stops, waiting) = channel();
        let of = cell.to_owned();
        spawn("stops", move || stop(&of, &waiting))?;
        Ok((ConsoleSession { requests, releases, stops }, shown))
    }

    /// A console session of a test, which answers by a function.
    #[cfg(test)]
    pub fn of(answers: impl Fn(&Request) -> Answer + Send + Sync + 'static) -> ConsoleSession {
        let answers = Arc::new(answers);
        let carries = |waiting: Receiver<Job>| {
            let answers = Arc::clone(&answers);
            std::thread::spawn(move || {
                waiting.iter().for_each(|job| drop(job.answer.send(answers(&job.request))));
            });
        };
        let (requests, waiting) = sync_channel(WAITING);
        carries(waiting);
        let (releases, waiting) = sync_channel(WAITING);
        carries(waiting);
        let (stops, waiting) = channel();
        carries(waiting);
        ConsoleSession { requests, releases, stops }
    }
}

impl RequestSink for ConsoleSession {
    fn ask(&self, request: Request, by: OnBehalf) -> oneshot::Receiver<Answer> {
        let (answer, answered) = oneshot::channel();
        let job = Job { request, by, since: Instant::now(), answer };
        let line = match job.request {
            Request::Press(Button::Stop) => {
                // What cannot be sent drops the answer, which the page is told.
                let _ = self.stops.send(job);
                return answered;
            }
            Request::Press(Button::LetGo(_)) => &self.releases,
            _ => &self.requests,
        };
        match line.try_send(job) {
            Ok(()) => {}
            Err(TrySendError::Full(job)) => {
                let _ = job.answer.send(Answer::Refused("the cell is busy: ask again".to_owned()));
            }
            Err(TrySendError::Disconnected(job)) => {
                let _ = job.answer.send(Answer::Refused("the panel is ending".to_owned()));
            }
        }
        answered
    }
}

fn spawn(name: &str, work: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
    std::thread::Builder::new().name(name.to_owned()).spawn(work).map(drop)
}

/// Shows what the cell does, until it ends.
fn watch(mut caller: Caller, looks: &Appearance, show: &watch::Sender<CellSnapshot>) {
    // Where it may not be set, the cell is shown all the same.
    let _ = rustix::process::nice(LAST);
    let mut before: Arc<[RobotNow]> = Arc::default();
    loop {
        match caller.hears.hear() {
            Ok(ConsoleMessage::Picture(picture)) => {
                let stamp = Stamp { epoch: picture.epoch, step: picture.step };
                let period = picture.period;
                let now = now(*picture, looks);
                let text = looks.state(&now).to_string();
                let robots: Arc<[RobotNow]> = now.robots.into();
                let demanded = |robots: &[RobotNow]| {
                    robots.iter().map(|robot| robot.demanded.clone()).collect::<Vec<_>>()
                };
                let moves = demanded(&before) != demanded(&robots);
                before = Arc::clone(&robots);
                let (text, stamp) = (Some(text.into()), Some((stamp, period)));
                show.send_replace(CellSnapshot { text, stamp, robots, moves, over: None });
            }
            Ok(ConsoleMessage::Answer(_)) => {}
            Err(error) => {
                show.send_modify(|shown| shown.over = Some(error.to_string()));
                return;
            }
        }
    }
}

/// What a picture of the console server says.
pub fn now(picture: Picture, looks: &Appearance) -> CellMoment {
    let time = picture.robots.iter().map(|robot| robot.time).fold(0.0, f64::max);
    let by = picture.by_whom().to_owned();
    let carried = |name: &str| {
        let known = picture.carried.iter().find(|carried| carried.robot == name);
        known.map_or_else(CarriedLoad::default, |known| CarriedLoad {
            tool: Some(known.tool),
            load: known.load,
            signals: Some(known.signals),
        })
    };
    let reading = |(name, shape): (&str, &'static Shape)| {
        let known = picture.readings.iter().find(|reading| reading.sensor == name)?;
        let is_new = picture.step.saturating_sub(known.step).saturating_mul(picture.period) <= OLD;
        known.words.as_ref().filter(|_| is_new).map(|words| of_words(shape, words))
    };
    let readings = looks.beside().sensors().map(reading).collect();
    let mut bodies = vec![None; looks.bodies()];
    for body in &picture.bodies {
        if let Some(place) = bodies.get_mut(body.place) {
            *place = Some(body.pose);
        }
    }
    let robot = |robot: RobotPicture| {
        let doing = robot.motion();
        let carried = carried(&robot.name);
        let RobotPicture { name, time, demanded, measured, tool, jogs, stop, .. } = robot;
        RobotNow {
            name,
            time,
            demanded,
            measured,
            tool,
            doing: doing.trim_start_matches([':', ' ']).to_owned(),
            jogs,
            stop: stop.text(),
            carried,
        }
    };
    CellMoment {
        time,
        epoch: picture.epoch,
        step: picture.step,
        period: picture.period,
        state: picture.state.word(),
        doing: picture.doing.word(),
        by,
        instruction: picture.instructions,
        rate: picture.rate,
        speed: picture.speed,
        reduced: picture.reduced,
        held: picture.held,
        fault: picture.fault,
        help: picture.help,
        persisting: picture.persisting,
        // This panel itself is told by which page has authority.
        holder: picture.holder.filter(|pid| *pid != std::process::id()),
        robots: picture.robots.into_iter().map(robot).collect(),
        bodies,
        readings,
        processes: picture.processes.iter().map(process).collect(),
    }
}

fn process(of: &ProcessPicture) -> Value {
    let figures = &of.figures;
    let micros = |nanos: u64| nanos as f64 * 1e-3;
    json!({
        "name": of.name,
        "pid": of.pid,
        "runs": of.runs,
        "steps": figures.worked.count,
        "skipped": figures.skipped,
        "overruns": figures.overruns,
        "late": [micros(figures.late.p50), micros(figures.late.p99), micros(figures.late.max)],
    })
}

/// Carries requests to the console server, one after another.
fn carry(cell: &Path, jobs: &Receiver<Job>) {
    let mut line = Line::to(cell);
    // It is there before it is needed.
    line.open();
    while let Ok(job) = jobs.recv() {
        // A renewal that has waited is none: whoever held may have let go since.
        let is_late = matches!(job.request, Request::Press(Button::Hold(_) | Button::Jog(..)))
            && job.since.elapsed() > LAPSE / 3;
        let answer = if is_late {
            Answer::Refused("the renewal came too late".to_owned())
        } else {
            line.ask(&job.request, job.by)
        };
        let _ = job.answer.send(answer);
    }
}

/// Carries stops to the console server: one for all that wait.
fn stop(cell: &Path, jobs: &Receiver<Job>) {
    let mut line = Line::to(cell);
    // It is there before it is needed.
    line.open();
    while let Ok(job) = jobs.recv() {
        // Those that have come by now: a stop that comes while this one is under way is one of its own.
        let by = job.by;
        let all: Vec<Job> = std::iter::once(job).chain(jobs.try_iter()).collect();
        let answer = line.ask(&Request::Press(Button::Stop), by);
        for job in all {
            let _ = job.answer.send(answer.clone());
        }
    }
}

/// A connection to the console server, which is made again if it breaks.
struct Line {
    cell: PathBuf,
    caller: Option<Caller>,
}

impl Line {
    fn to(cell: &Path) -> Line {
        Line { cell: cell.to_owned(), caller: None }
    }

    fn open(&mut self) {
        if self.caller.is_none() {
            self.caller = Caller::to(&self.cell).ok();
        }
    }

    fn ask(&mut self, request: &Request, by: OnBehalf) -> Answer {
        let mut why = "the cell does not answer".to_owned();
        // Once more on a new connection, if this one was broken.
        for _ in 0..2 {
            self.open();
            match self.caller.as_mut().map(|caller| caller.ask(request, Some(by))) {
                Some(Ok(ConsoleMessage::Answer(answer))) => return answer,
                Some(Ok(ConsoleMessage::Picture(_))) => return Answer::Done(String::new()),
                Some(Err(error)) => why = error.to_string(),
                None => {}
            }
            self.caller = None;
        }
        Answer::Refused(why)
    }
}

#[cfg(test)]
mod tests {
    use mrroc_core::operator::Renewal;

    use super::*;

    #[test]
    fn fault_206_a_hold_that_is_let_go_does_not_wait_until_its_last_renewal_is_answered() {
        let (let_go, is_let_go) = sync_channel(1);
        let is_let_go = std::sync::Mutex::new(is_let_go);
        let console = ConsoleSession::of(move |request| match request {
            Request::Press(Button::LetGo(_)) => {
                let_go.send(()).expect("the renewal waits");
                Answer::Done("let go".to_owned())
            }
            _ => {
                let waited = is_let_go.lock().expect("alone").recv_timeout(Duration::from_secs(20));
                Answer::Done(if waited.is_ok() { "after" } else { "never" }.to_owned())
            }
        });
        let by = OnBehalf { page: 1, heard: 0 };
        let renewal = Renewal::first(7);
        let renewed = console.ask(Request::Press(Button::Hold(renewal)), by);
        let released = console.ask(Request::Press(Button::LetGo(renewal.hold())), by);
        assert_eq!(released.blocking_recv(), Ok(Answer::Done("let go".to_owned())));
        assert_eq!(renewed.blocking_recv(), Ok(Answer::Done("after".to_owned())));
    }
}
