//! A little of it over loopback, by the machine's clock.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, channel};

use mrroc_core::operator::button::Button;
use mrroc_core::operator::{Answer, Request};
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio::sync::watch;

use super::*;
use crate::console_session::ConsoleSession;
use crate::driver::{Panel, Source, look_after};
use crate::rules::token::Token;
use crate::server::serve;

/// For what comes at once, unless it never does.
const TIMEOUT: Duration = Duration::from_secs(120);

/// A panel whose console server does all that it is asked for, and writes it down.
struct Served {
    address: SocketAddr,
    token: String,
    asked: Receiver<Request>,
    _shown: watch::Sender<CellSnapshot>,
}

/// A page: a connection that was upgraded.
struct Page(TcpStream);

/// A panel that keeps poses beside the file of a cell, if there is one.
fn served(cell: Option<&Path>) -> Served {
    let cell = cell.map(Path::to_owned);
    let (looks, token) = (Arc::new(looks()), Token::draw().expect("random numbers"));
    let (show, shown) = watch::channel(shown(&looks));
    let (writes, asked) = channel();
    let writes = Mutex::new(writes);
    let console = ConsoleSession::of(move |request| {
        let _ = writes.lock().expect("not poisoned").send(*request);
        Answer::Done(format!("{request}"))
    });
    let (tells, told) = channel();
    std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
        runtime.block_on(async {
            let listener = TcpListener::bind("127.0.0.1:0").await.expect("a port");
            let address = listener.local_addr().expect("an address");
            tells.send(address).expect("heard");
            let panel = Panel::new(Source::Running(Box::new(console), shown), looks, token, address);
            let panel = Arc::new(cell.iter().fold(panel, |panel, cell| panel.teaching(cell)));
            tokio::select! {
                _ = serve(listener, Arc::clone(&panel), None) => {}
                () = look_after(panel) => {}
            }
        });
    });
    let address = told.recv().expect("it listens");
    Served { address, token: token.to_string(), asked, _shown: show }
}

impl Served {
    /// A page that has shown the token.
    fn known(&self) -> Page {
        let mut stream = TcpStream::connect(self.address).expect("connected");
        stream.set_read_timeout(Some(TIMEOUT)).expect("set");
        let host = self.address;
        let header = format!(
            "GET /connect HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
        );
        stream.write_all(header.as_bytes()).expect("sent");
        let mut answer = Vec::new();
        while !answer.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).expect("answered");
            answer.push(byte[0]);
        }
        assert!(answer.starts_with(b"HTTP/1.1 101"));
        let mut page = Page(stream);
        page.say(&json!({"token": self.token}));
        page
    }

    /// The next request that the console server is asked for.
    fn request(&self) -> Request {
        self.asked.recv_timeout(TIMEOUT).expect("asked")
    }
}

impl Page {
    fn say(&mut self, message: &Value) {
        self.0.write_all(&super::frame(0x81, message.to_string().as_bytes())).expect("sent");
    }

    /// The next message; `None` when the connection is over.
    fn hear(&mut self) -> Option<Value> {
        loop {
            let mut head = [0; 2];
            self.0.read_exact(&mut head).ok()?;
            let length = match head[1] & 0x7f {
                126 => {
                    let mut long = [0; 2];
                    self.0.read_exact(&mut long).ok()?;
                    u64::from(u16::from_be_bytes(long))
                }
                127 => {
                    let mut long = [0; 8];
                    self.0.read_exact(&mut long).ok()?;
                    u64::from_be_bytes(long)
                }
                short => u64::from(short),
            };
            let mut bytes = vec![0; usize::try_from(length).ok()?];
            self.0.read_exact(&mut bytes).ok()?;
            match head[0] & 0xf {
                1 => return serde_json::from_slice(&bytes).ok(),
                8 => return None,
                _ => {}
            }
        }
    }

    /// The answer of a number.
    fn answer(&mut self, number: u64) -> Option<Value> {
        loop {
            let message = self.hear()?;
            if message["kind"] == "answer" && message["n"] == number {
                return Some(message);
            }
        }
    }

    /// The answer of any of these numbers.
    fn answer_of_any(&mut self, numbers: std::ops::Range<u64>) -> Option<Value> {
        loop {
            let message = self.hear()?;
            if message["kind"] == "answer" && message["n"].as_u64().is_some_and(|n| numbers.contains(&n)) {
                return Some(message);
            }
        }
    }
}

#[test]
fn a_page_over_loopback_is_shown_the_cell_and_operates_it_until_it_goes() {
    let served = served(None);
    let mut page = served.known();
    assert_eq!(page.hear().expect("the cell")["kind"], "layout");
    page.say(&json!({"n": 1, "do": "take"}));
    assert_eq!(served.request(), Request::Take);
    assert_eq!(page.answer(1).expect("answered")["outcome"], "done");
    drop(page);
    // It is gone, or was silent for too long: its control goes in both cases.
    assert_eq!(served.request(), Request::Release);
    let mut next = served.known();
    next.say(&json!({"n": 1, "do": "stop"}));
    assert_eq!(served.request(), Request::Press(Button::Stop));
    assert_eq!(next.answer(1).expect("answered")["outcome"], "done");
}

#[test]
fn fault_206_a_page_over_loopback_that_falls_silent_lets_go_and_loses_authority() {
    let served = served(None);
    let mut page = served.known();
    page.say(&json!({"n": 1, "do": "take"}));
    page.say(&json!({"n": 2, "do": "hold", "begins": true, "epoch": 0, "step": 1000}));
    assert_eq!(served.request(), Request::Take);
    // On a machine that was busy for 300 ms between the two it has lost control before.
    let hold = match served.request() {
        Request::Press(Button::Hold(renewal)) => Some(renewal.hold()),
        other => {
            assert_eq!(other, Request::Release);
            None
        }
    };
    if let Some(hold) = hold {
        // Each goes by a connection of its own.
        let asked = [served.request(), served.request()];
        let let_go = Request::Press(Button::LetGo(hold));
        assert!(asked == [let_go, Request::Release] || asked == [Request::Release, let_go], "{asked:?}");
    }
    page.say(&json!({"n": 4, "do": "resume", "epoch": 0, "step": 1000}));
    assert_eq!(page.answer(4).expect("answered")["outcome"], "refused");
}

#[test]
fn fault_240_while_a_file_does_not_answer_a_stop_is_taken() {
    let folder = std::env::temp_dir().join(format!("mrroc-panel-slow-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("poses")).expect("a folder");
    let file = folder.join("poses/arm.txt");
    let served = served(Some(&folder.join("cell.toml")));
    let mut page = served.known();
    // A pipe that nobody writes to: whoever reads it waits.
    let made = std::process::Command::new("mkfifo").arg(&file).status().expect("mkfifo");
    assert!(made.success());
    for n in 2..30 {
        page.say(&json!({"n": n, "do": "path", "robot": "arm", "name": "pick"}));
    }
    let refused = page.answer(20).expect("answered");
    assert!(refused["text"].as_str().is_some_and(|why| why.contains("do not answer")), "{refused}");
    page.say(&json!({"n": 41, "do": "stop"}));
    assert_eq!(served.request(), Request::Press(Button::Stop));
    assert_eq!(page.answer(41).expect("answered")["outcome"], "done");
    // Somebody writes: the first one that waited is answered.
    drop(std::fs::OpenOptions::new().write(true).open(&file).expect("opened"));
    let first = page.answer_of_any(2..18).expect("answered");
    assert_eq!(first["outcome"], "refused");
    std::fs::remove_dir_all(&folder).expect("removed");
}
