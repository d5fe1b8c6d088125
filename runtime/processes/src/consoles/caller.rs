//! A console's side of the connection.
//!
//! In: the path of a cell's file, then requests. Out: a connection to the console server of that cell, then its answers
//! and pictures. Nothing here waits for longer than [`TIMEOUT`].

use std::io::{self, BufReader, ErrorKind, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use rustix::net::sockopt::{Timeout, set_socket_timeout, socket_peercred};
use rustix::net::{AddressFamily, SocketAddrUnix, SocketFlags, SocketType, connect, socket_with};

use super::protocol::{ConsoleMessage, SOCKET};
use crate::board::StateBoard;
use crate::machine::identity::{CellId, Holder};
use crate::session::{SessionError, is_stopped, is_used, number_of_session, sessions_of};
use mrroc_core::fault::Name;
use mrroc_core::operator::button::Button;
use mrroc_core::operator::request::Addressed;
use mrroc_core::operator::{Answer, CellState, OnBehalf, Request};

/// How long a console waits for the cell to take its connection, its request, and to answer.
pub(super) const TIMEOUT: Duration = Duration::from_secs(5);

/// The error of a connection to a cell that has ended.
pub const ENDED: &str = "the cell has ended";

/// How long a cell that has closed its connections may take to end.
const ENDING: Duration = Duration::from_secs(2);

/// Why a console cannot connect to a cell.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoCell {
    /// The cell is not running.
    #[error(
        "no processes run the cell of {0}\n help: start it in another terminal: --processes; --cell FILE names another one"
    )]
    NotRun(PathBuf),
    /// The cell runs, but has no console server.
    #[error("the cell of {0} takes no orders now\n help: it is starting or ending")]
    Closed(PathBuf),
    /// Another user runs the cell.
    #[error(
        "process {pid} of user {user} runs the cell of {cell}: only that user may operate it\n help: ask that user, or become it: sudo -u '#{user}'"
    )]
    OfAnother {
        /// The cell's file.
        cell: PathBuf,
        /// The launcher's process, and its user.
        pid: u32,
        user: u32,
    },
    /// The cell runs, but its launcher does not take the connection.
    #[error(
        "the cell of {0} has not answered for {timeout} s: its launcher stands still\n help: see `ps -ef`; let it go on by kill -CONT and its number",
        timeout = TIMEOUT.as_secs()
    )]
    Silent(PathBuf),
    /// The folder of sessions cannot be read.
    #[error(transparent)]
    Session(#[from] SessionError),
}

/// A connection to the console server of a running cell, with both directions.
pub struct Caller {
    /// The direction to the console server.
    pub asks: RequestSender,
    /// The direction from the console server.
    pub hears: AnswerReceiver,
}

/// Whether the cell still runs.
type Runs = Box<dyn Fn() -> bool + Send>;

/// The direction from a console to the console server.
pub struct RequestSender {
    stream: UnixStream,
    /// The lower cell that is asked; the uppermost one if none.
    cell: Option<Name>,
    /// The number of the launcher's process.
    launcher: Option<u32>,
    /// Where a stop is asked for directly: the launcher and the MP may stand still.
    board: Option<StateBoard>,
}

/// The direction from the console server to a console.
pub struct AnswerReceiver {
    stream: BufReader<UnixStream>,
    launcher: Option<u32>,
    runs: Runs,
}

impl Caller {
    /// Connects to the cell of the file at `cell`.
    ///
    /// # Errors
    /// [`NoCell`]
    pub(crate) fn find(cell: &Path) -> Result<Caller, NoCell> {
        let id = CellId::of(cell);
        let holder = id.holder();
        if let Some(Holder { pid, user }) = holder.filter(|holder| !holder.is_ours()) {
            return Err(NoCell::OfAnother { cell: cell.to_owned(), pid, user });
        }
        // By what the cell is, wherever its session is; or else, if its file was replaced meanwhile, by the file's path.
        let mut tried = Vec::new();
        if holder.is_some() {
            let address = SocketAddrUnix::new_abstract_name(id.console().as_bytes());
            tried.push((address, Box::new(move || id.holder().is_some()) as Runs));
        }
        let mut board = None;
        for session in sessions_of(cell)? {
            board = board.or_else(|| StateBoard::of(number_of_session(&session)?).ok());
            let address = SocketAddrUnix::new(session.join(SOCKET));
            tried.push((address, Box::new(move || is_used(&session))));
        }
        let (runs, mut silent) = (!tried.is_empty(), false);
        for (address, runs) in tried {
            match address.map_err(io::Error::from).and_then(|address| Caller::connect(&address, runs)) {
                Ok(mut caller) => {
                    caller.asks.board = board;
                    return Ok(caller);
                }
                Err(error) => silent |= is_timeout(&error),
            }
        }
        Err(match runs {
            false => NoCell::NotRun(cell.to_owned()),
            true if silent => NoCell::Silent(cell.to_owned()),
            true => NoCell::Closed(cell.to_owned()),
        })
    }

    /// Connects to the cell of the file at `cell`, for a console that is a crate of its own.
    ///
    /// # Errors
    /// No such cell runs, another user's does, or it does not answer; with what to do.
    pub fn to(cell: &Path) -> io::Result<Caller> {
        Caller::find(cell).map_err(io::Error::other)
    }

    fn connect(address: &SocketAddrUnix, runs: Runs) -> io::Result<Caller> {
        let socket = socket_with(AddressFamily::UNIX, SocketType::STREAM, SocketFlags::CLOEXEC, None)?;
        for direction in [Timeout::Send, Timeout::Recv] {
            set_socket_timeout(&socket, direction, Some(TIMEOUT))?;
        }
        connect(&socket, address)?;
        let launcher =
            socket_peercred(&socket).ok().map(|peer| peer.pid.as_raw_nonzero().get().unsigned_abs());
        let stream = UnixStream::from(socket);
        let asks = RequestSender { stream: stream.try_clone()?, cell: None, launcher, board: None };
        Ok(Caller { asks, hears: AnswerReceiver { stream: BufReader::new(stream), launcher, runs } })
    }

    /// The same connection, to ask a lower cell.
    pub(crate) fn of(mut self, cell: Option<Name>) -> Caller {
        self.asks.of(cell);
        self
    }

    /// Sends a request of a page of a panel, or of this console itself, and waits for its answer.
    ///
    /// # Errors
    /// The cell does not answer in time, the console server is gone, or what came is neither an answer nor a picture.
    pub fn ask(&mut self, request: &Request, by: Option<OnBehalf>) -> io::Result<ConsoleMessage> {
        let heard = match self.asks.ask(request, by) {
            Err(error) if error.kind() == ErrorKind::TimedOut => Err(error),
            // A console server that has hung up may have said why.
            Ok(()) | Err(_) => self.hears.hear(),
        };
        // The server may be late with a stop that the board has told the MP already, or the cell has ended by it meanwhile.
        let Some(step) = self.asks.stop_begun(request) else { return heard };
        let silent = heard.err().filter(|error| error.kind() == ErrorKind::TimedOut);
        let but = silent.map_or_else(String::new, |error| format!(", but {error}"));
        Ok(ConsoleMessage::Answer(Answer::Done(format!("{}: step {step}{but}", CellState::Stopping.word()))))
    }
}

impl RequestSender {
    /// From now on asks this lower cell, or the uppermost one.
    pub(crate) fn of(&mut self, cell: Option<Name>) {
        self.cell = cell;
    }

    /// The lower cell that it asks.
    pub(crate) const fn cell(&self) -> Option<Name> {
        self.cell
    }

    /// The board on which this request is asked for as well, if it is a stop of the whole cell.
    fn stop_on_board(&self, request: &Request) -> Option<&StateBoard> {
        let is_stop = matches!(request, Request::Press(Button::Stop)) && self.cell.is_none();
        self.board.as_ref().filter(|_| is_stop)
    }

    /// The step in which the MP has begun to carry it out, if it is a stop, and the cell was not in the fault state already.
    fn stop_begun(&self, request: &Request) -> Option<u64> {
        let board = self.stop_on_board(request)?;
        let begun = board.stops_begun().load(Ordering::Acquire);
        let step = board.stop_step().load(Ordering::Relaxed);
        (begun >= board.stops_asked().load(Ordering::Acquire) && step != u64::MAX).then_some(step)
    }

    /// Sends a request of a page, or of this console itself.
    ///
    /// # Errors
    /// The cell does not take it in time, or the console server is gone.
    pub fn ask(&mut self, request: &Request, by: Option<OnBehalf>) -> io::Result<()> {
        if let Some(board) = self.stop_on_board(request) {
            board.stops_asked().fetch_add(1, Ordering::AcqRel);
        }
        let line = Addressed { by, cell: self.cell, request: *request };
        let sent = self.stream.write_all(format!("{line}\n").as_bytes());
        sent.map_err(|error| told(error, self.launcher))
    }
}

impl AnswerReceiver {
    /// Waits for the next answer or picture.
    ///
    /// # Errors
    /// None comes in time, the console server is gone, or what came is neither an answer nor a picture.
    pub fn hear(&mut self) -> io::Result<ConsoleMessage> {
        match ConsoleMessage::read(&mut self.stream) {
            Ok(Some(heard)) => Ok(heard),
            Ok(None) => Err(self.end()),
            Err(error) if error.kind() == ErrorKind::ConnectionReset => Err(self.end()),
            Err(error) => Err(told(error, self.launcher)),
        }
    }

    /// What the end of the connection means. A cell that ends closes its connections first.
    fn end(&self) -> io::Error {
        let until = Instant::now() + ENDING;
        while (self.runs)() {
            if Instant::now() > until {
                let text = "the cell has closed the connection, but has not ended\n help: ask again";
                return io::Error::new(ErrorKind::UnexpectedEof, text);
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        io::Error::new(ErrorKind::UnexpectedEof, ENDED)
    }
}

fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)
}

/// The error of a connection to a launcher, in words if the launcher does not answer.
fn told(error: io::Error, launcher: Option<u32>) -> io::Error {
    if !is_timeout(&error) {
        return error;
    }
    let seconds = TIMEOUT.as_secs();
    let why = match launcher {
        Some(pid) if is_stopped(pid) => format!(
            "its launcher, process {pid}, was stopped by a signal\n help: the cell stops its robots by itself; let the \
             launcher go on: kill -CONT {pid}"
        ),
        Some(pid) => format!(
            "its launcher, process {pid}, is busy or gets no processor time\n help: ask again, or end it: kill {pid}"
        ),
        None => "its launcher stands still\n help: see `ps -ef`".to_owned(),
    };
    io::Error::new(ErrorKind::TimedOut, format!("the cell has not answered for {seconds} s: {why}"))
}
