//! What is answered over connections, byte by byte: in memory, by a clock that goes on only when nothing else does.

use core::sync::atomic::{AtomicUsize, Ordering};

use mrroc_core::operator::{Answer, OnBehalf, Request};
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex};
use tokio::sync::{oneshot, watch};
use tokio::time::Instant;

use super::*;
use crate::console_session::RequestSink;
use crate::driver::{Panel, Source, look_after};
use crate::rules::CONNECTIONS;
use crate::rules::token::Token;
use crate::server::Connections;

const HOST: &str = "127.0.0.1:7411";
const UPGRADE: &str = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==";

/// A panel whose connections are in memory.
struct Served {
    connections: Connections,
    token: String,
    /// What its console server was asked for.
    asked: Arc<AtomicUsize>,
    _shown: watch::Sender<CellSnapshot>,
}

/// A console server that does at once all that it is asked for, and counts it.
struct AtOnce(Arc<AtomicUsize>);

impl RequestSink for AtOnce {
    fn ask(&self, request: Request, _: OnBehalf) -> oneshot::Receiver<Answer> {
        let (answer, answered) = oneshot::channel();
        self.0.fetch_add(1, Ordering::Relaxed);
        answer.send(Answer::Done(format!("{request}"))).expect("it is waited for");
        answered
    }
}

fn served() -> Served {
    let (looks, token) = (Arc::new(looks()), Token::draw().expect("random numbers"));
    let (show, shown) = watch::channel(shown(&looks));
    let asked = Arc::new(AtomicUsize::new(0));
    let console = Box::new(AtOnce(Arc::clone(&asked)));
    let address = HOST.parse().expect("an address");
    let panel = Arc::new(Panel::new(Source::Running(console, shown), looks, token, address));
    tokio::spawn(look_after(Arc::clone(&panel)));
    Served { connections: Connections::of(panel), token: token.to_string(), asked, _shown: show }
}

/// Runs a test by a clock that goes on only when nothing else does.
fn run(test: impl Future<Output = ()>) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().start_paused(true).build();
    runtime.expect("a runtime").block_on(test);
}

impl Served {
    fn connect(&self) -> DuplexStream {
        let (here, there) = duplex(4096);
        self.connections.take(async { Ok(there) });
        here
    }

    /// What is answered to these bytes until their end; nothing, if the connection is closed.
    async fn answer(&self, bytes: &str) -> (DuplexStream, String) {
        let mut stream = self.connect();
        // It may be closed before.
        let _ = stream.write_all(bytes.as_bytes()).await;
        let mut answer = Vec::new();
        while !answer.ends_with(b"\r\n\r\n") {
            match stream.read_u8().await {
                Ok(byte) => answer.push(byte),
                Err(_) => break,
            }
        }
        (stream, String::from_utf8(answer).expect("text"))
    }

    async fn page(&self) -> Option<DuplexStream> {
        let request =
            format!("GET /connect HTTP/1.1\r\nHost: {HOST}\r\nOrigin: http://{HOST}\r\n{UPGRADE}\r\n\r\n");
        let (stream, answer) = self.answer(&request).await;
        answer.starts_with("HTTP/1.1 101").then_some(stream)
    }

    async fn known(&self) -> DuplexStream {
        let mut page = self.page().await.expect("a place");
        say(&mut page, &json!({"token": self.token}).to_string()).await;
        page
    }
}

async fn say(page: &mut DuplexStream, text: &str) {
    // It may be closed before.
    let _ = page.write_all(&frame(0x81, text.as_bytes())).await;
}

/// The kind and the bytes of the next frame; `None` when the connection is over.
async fn hear(page: &mut DuplexStream) -> Option<(u8, Vec<u8>)> {
    let kind = page.read_u8().await.ok()?;
    let length = match page.read_u8().await.ok()? {
        126 => u64::from(page.read_u16().await.ok()?),
        127 => page.read_u64().await.ok()?,
        short => u64::from(short),
    };
    let mut bytes = vec![0; usize::try_from(length).ok()?];
    page.read_exact(&mut bytes).await.ok()?;
    Some((kind, bytes))
}

/// The last frame before the connection is over.
async fn last(page: &mut DuplexStream) -> Option<(u8, Vec<u8>)> {
    let mut last = None;
    while let Some(frame) = hear(page).await {
        last = Some(frame);
    }
    last
}

/// The frame that closes a connection, as a browser reads it.
fn closing(why: &str) -> Option<(u8, Vec<u8>)> {
    let mut bytes = 1008_u16.to_be_bytes().to_vec();
    bytes.extend_from_slice(why.as_bytes());
    Some((0x88, bytes))
}

#[test]
fn fault_201_what_does_not_come_from_the_panels_own_page_is_refused() {
    run(async {
        let served = served();
        for (request, status) in [
            (format!("GET / HTTP/1.1\r\nHost: {HOST}"), "200"),
            (format!("GET /../Cargo.toml HTTP/1.1\r\nHost: {HOST}"), "404"),
            ("GET / HTTP/1.1\r\nHost: evil.example".to_owned(), "403"),
            (format!("POST / HTTP/1.1\r\nHost: {HOST}\r\nContent-Length: 0"), "405"),
            (format!("GET /connect HTTP/1.1\r\nHost: {HOST}\r\n{UPGRADE}"), "403"),
            (
                format!("GET /connect HTTP/1.1\r\nHost: {HOST}\r\nOrigin: http://evil.example\r\n{UPGRADE}"),
                "403",
            ),
            (
                format!(
                    "GET /connect HTTP/1.1\r\nHost: evil.example\r\nOrigin: http://evil.example\r\n{UPGRADE}"
                ),
                "403",
            ),
            (format!("GET /connect HTTP/1.1\r\nHost: {HOST}\r\nOrigin: http://{HOST}\r\n{UPGRADE}"), "101"),
            // Said twice, whichever comes first; and what only a proxy is asked for.
            (format!("GET / HTTP/1.1\r\nHost: {HOST}\r\nHost: evil.example"), "403"),
            (format!("GET / HTTP/1.1\r\nHost: evil.example\r\nHost: {HOST}"), "403"),
            (format!("GET / HTTP/1.1\r\nHost: {HOST}\r\nHost: {HOST}"), "403"),
            (
                format!(
                    "GET /connect HTTP/1.1\r\nHost: {HOST}\r\nOrigin: http://{HOST}\r\nOrigin: http://evil.example\r\n{UPGRADE}"
                ),
                "403",
            ),
            (format!("GET http://evil.example/ HTTP/1.1\r\nHost: {HOST}"), "400"),
            (format!("GET http://{HOST}/ HTTP/1.1\r\nHost: {HOST}"), "400"),
        ] {
            let (_, answer) = served.answer(&format!("{request}\r\n\r\n")).await;
            assert_eq!(answer.get(9..12), Some(status), "{request}");
        }
    });
}

#[test]
fn fault_203_a_connection_that_does_not_say_in_five_seconds_what_it_wants_is_closed() {
    run(async {
        let served = served();
        let (began, mut all) = (Instant::now(), Vec::new());
        // More than a header may have in time, and nothing at all.
        for bytes in ["", "GET / HT", "GET / HTTP/1.1\r\nHost: 127.0.0.1:7411\r\n"] {
            let mut stream = served.connect();
            stream.write_all(bytes.as_bytes()).await.expect("sent");
            all.push(stream);
        }
        for mut stream in all {
            let mut rest = Vec::new();
            stream.read_to_end(&mut rest).await.expect("closed");
            assert!(!rest.starts_with(b"HTTP/1.1 200"), "{}", String::from_utf8_lossy(&rest));
            // The clock of the runtime counts whole milliseconds, and rounds up.
            let after = began.elapsed();
            assert!((MS(5000)..=MS(5002)).contains(&after), "{after:?}");
        }
    });
}

#[test]
fn fault_203_of_a_crowd_of_connections_the_oldest_make_room_and_pages_are_answered_at_once() {
    run(async {
        let served = served();
        let get = format!("GET /icon.svg HTTP/1.1\r\nHost: {HOST}\r\n\r\n");
        // Each asks a hundred times and reads nothing.
        let mut crowd = Vec::new();
        for _ in 0..CONNECTIONS + 12 {
            let mut stream = served.connect();
            let asks = get.repeat(100);
            crowd.push(tokio::spawn(async move {
                let _ = stream.write_all(asks.as_bytes()).await;
                stream
            }));
            tokio::time::sleep(MS(1)).await;
        }
        let mut known = served.known().await;
        let began = Instant::now();
        let (_, answer) = served.answer(&get).await;
        assert!(answer.starts_with("HTTP/1.1 200") && began.elapsed() < MS(2), "{answer}");
        // None of them is answered for ever, and the page goes on.
        tokio::time::sleep(Duration::from_secs(31)).await;
        assert!(crowd.iter().all(tokio::task::JoinHandle::is_finished));
        say(&mut known, r#"{"n":4,"do":"suspend","epoch":0,"step":1000}"#).await;
        assert!(hear(&mut known).await.is_some());
    });
}

#[test]
fn fault_203_huge_and_malformed_messages_floods_and_crowds_disconnect_who_sends_them_and_reach_no_console_server()
 {
    run(async {
        let served = served();
        let mut good = served.known().await;
        for bytes in [
            frame(0x81, &vec![b'x'; 1 << 20]),
            // One byte more than a message may have, and one in two parts.
            frame(0x81, &[b' '; 1025]),
            [frame(0x01, &[b' '; 1000]), frame(0x80, &[b' '; 1000])].concat(),
            frame(0x82, &[0, 255]),
            frame(0x81, b"{]").repeat(20),
            frame(0x81, br#"{"do":"beat"}"#).repeat(1000),
            // No text, and not masked.
            frame(0x81, &[0xc3, 0x28]),
            b"\x81\x02{}".to_vec(),
        ] {
            let page = served.known().await;
            let (mut hears, mut says) = tokio::io::split(page);
            let began = Instant::now();
            tokio::spawn(async move {
                let _ = says.write_all(&bytes).await;
                // It stays, and waits for what comes of it.
                std::future::pending::<()>().await;
            });
            let mut all = Vec::new();
            let _ = hears.read_to_end(&mut all).await;
            assert!(began.elapsed() <= MS(1001), "{:?}", began.elapsed());
        }
        // Of a crowd that does not know the token the oldest make room.
        let mut crowd = Vec::new();
        for _ in 0..40 {
            crowd.push(served.page().await.expect("a place"));
        }
        let began = Instant::now();
        for oldest in &mut crowd[..9] {
            assert_eq!((hear(oldest).await, began.elapsed()), (None, Duration::ZERO));
        }
        // And the first page is answered all the same.
        say(&mut good, r#"{"n":4,"do":"suspend","epoch":0,"step":1000}"#).await;
        loop {
            let (_, bytes) = hear(&mut good).await.expect("answered");
            let message: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
            if message["n"] == 4 {
                assert_eq!(message["outcome"], "refused");
                break;
            }
        }
        assert_eq!(served.asked.load(Ordering::Relaxed), 0);
    });
}

#[test]
fn fault_203_a_page_that_does_not_read_is_closed_while_others_go_on() {
    run(async {
        let served = served();
        let mut page = served.known().await;
        let began = Instant::now();
        // Answers fill what the connection holds; then they wait.
        for n in 0..40 {
            say(&mut page, &json!({"n": n, "do": "x".repeat(900)}).to_string()).await;
            tokio::time::sleep(MS(20)).await;
        }
        let mut other = served.known().await;
        say(&mut other, r#"{"n":1,"do":"take"}"#).await;
        tokio::time::sleep(MS(8000)).await;
        assert!(hear(&mut other).await.is_some());
        // Its connection was closed though it never read: what it has not read yet is all that there is.
        let (before, mut rest) = (Instant::now(), Vec::new());
        page.read_to_end(&mut rest).await.expect("closed");
        assert_eq!(before.elapsed(), Duration::ZERO);
        assert!(rest.len() <= 4096 && began.elapsed() < MS(10_000));
    });
}

#[test]
fn fault_200_a_page_that_does_not_know_the_token_is_told_so_and_nothing_else() {
    run(async {
        let served = served();
        let mut page = served.page().await.expect("a place");
        say(&mut page, r#"{"token":"no"}"#).await;
        assert_eq!(hear(&mut page).await, closing("this is not the token"));
        assert_eq!(hear(&mut page).await, None);
        let mut page = served.page().await.expect("a place");
        let began = Instant::now();
        assert_eq!(hear(&mut page).await, None);
        assert!((MS(5000)..=MS(5002)).contains(&began.elapsed()));
    });
}

#[test]
fn a_page_that_is_disconnected_is_told_so_and_the_connection_of_one_that_goes_is_closed_at_once() {
    run(async {
        let served = served();
        let mut page = served.known().await;
        page.write_all(&frame(0x82, &[1])).await.expect("sent");
        assert_eq!(last(&mut page).await, closing("the panel has closed the connection"));
        let mut page = served.known().await;
        for _ in ["layout", "authority", "state"] {
            assert!(hear(&mut page).await.is_some());
        }
        page.write_all(&frame(0x88, &1001_u16.to_be_bytes())).await.expect("sent");
        let began = Instant::now();
        assert_eq!((hear(&mut page).await, began.elapsed()), (None, Duration::ZERO));
        // A ping is answered.
        let mut page = served.known().await;
        page.write_all(&frame(0x89, b"there?")).await.expect("sent");
        loop {
            let frame = hear(&mut page).await.expect("answered");
            if frame.0 == 0x8a {
                assert_eq!(frame.1, b"there?");
                break;
            }
        }
    });
}
