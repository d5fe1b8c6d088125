//! A panel of a cell that is not there, and pages that are no browsers: what the server does, whoever speaks to it.

use core::time::Duration;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};

use mrroc_core::operator::button::Button;
use mrroc_processes::{Reply, Request};
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio::sync::watch;

use crate::desk::{Desk, Shown};
use crate::now::{Looks, Now};
use crate::rules::request::Stamp;
use crate::rules::token::Token;
use crate::server::{Panel, Source, serve};
use crate::socket::look_after;

/// For what comes at once, unless it never does.
const PATIENCE: Duration = Duration::from_secs(120);

/// A panel whose desk does all that it is asked for, and writes it down.
struct Served {
    address: SocketAddr,
    token: String,
    asked: Receiver<Request>,
    /// What is shown.
    shown: watch::Sender<Shown>,
    /// The panel's own clock \[ms\], which stands until a test lets time pass.
    time: Arc<AtomicU64>,
}

fn looks() -> Looks {
    use mrroc::prelude::*;
    use mrroc_robots::{Irp6, SimulatedIrp6, Six};
    let start = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let arm = RobotSetup::new("arm", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start));
    Looks::of(&Cell::new(Duration::from_millis(2)).robot(arm).layout())
}

fn served() -> Served {
    served_in(None)
}

/// The same, which keeps poses beside the file of a cell.
fn served_in(cell: Option<&Path>) -> Served {
    served_by(cell, |request| Reply::Done(format!("{request}")))
}

/// The same, whose desk answers so.
fn served_by(cell: Option<&Path>, answers: impl Fn(&Request) -> Reply + Send + Sync + 'static) -> Served {
    let cell = cell.map(Path::to_owned);
    let looks = Arc::new(looks());
    let text = looks.state(&Now { state: "running", step: 1000, ..Now::default() }).to_string();
    let stamp = Stamp { epoch: 0, step: 1000 };
    let shown = Shown { text: Some(text.into()), stamp: Some((stamp, 2_000_000)), ..Shown::default() };
    let (show, shown) = watch::channel(shown);
    let (writes, asked) = channel();
    let writes = Mutex::new(writes);
    let desk = Desk::of(move |request| {
        let _ = writes.lock().expect("not poisoned").send(*request);
        answers(request)
    });
    let token = Token::draw().expect("random numbers");
    let (tells, told) = channel();
    let time = Arc::new(AtomicU64::new(0));
    let clock = Arc::clone(&time);
    std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
        runtime.block_on(async {
            let listener = TcpListener::bind("127.0.0.1:0").await.expect("a port");
            let address = listener.local_addr().expect("an address");
            tells.send(address).expect("heard");
            let panel = Panel::new(Source::Running(desk, shown), looks, token, address);
            let panel = panel.by_clock(move || Duration::from_millis(clock.load(Ordering::Acquire)));
            let panel = Arc::new(cell.iter().fold(panel, |panel, cell| panel.teaching(cell)));
            tokio::select! {
                _ = serve(listener, Arc::clone(&panel), None) => {}
                () = look_after(panel) => {}
            }
        });
    });
    let address = told.recv().expect("it listens");
    Served { address, token: token.to_string(), asked, shown: show, time }
}

/// A page: a connection that was upgraded.
struct Page(TcpStream);

impl Served {
    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).expect("connected");
        stream.set_read_timeout(Some(Duration::from_secs(10))).expect("set");
        stream
    }

    /// The status of a request with these lines of its header.
    fn status(&self, request: &str) -> String {
        let mut stream = self.connect();
        stream.write_all(format!("{request}\r\n\r\n").as_bytes()).expect("sent");
        let mut answer = [0; 12];
        match stream.read_exact(&mut answer) {
            Ok(()) => String::from_utf8_lossy(&answer[9..]).into_owned(),
            Err(_) => "closed".to_owned(),
        }
    }

    fn page(&self) -> Option<Page> {
        let mut stream = self.connect();
        let host = self.address;
        let header = format!(
            "GET /connect HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
        );
        stream.write_all(header.as_bytes()).expect("sent");
        let mut answer = Vec::new();
        while !answer.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            if stream.read_exact(&mut byte).is_err() {
                return None;
            }
            answer.push(byte[0]);
        }
        answer.starts_with(b"HTTP/1.1 101").then_some(Page(stream))
    }

    /// Time passes for the panel.
    fn pass(&self, millis: u64) {
        self.time.fetch_add(millis, Ordering::AcqRel);
    }

    /// The hold that is let go when its page loses control: each goes by a connection of its own.
    fn lets_go_and_releases(&self) -> u64 {
        match [(); 2].map(|()| self.asked.recv_timeout(PATIENCE).expect("asked")) {
            [Request::Press(Button::LetGo(hold)), Request::Release]
            | [Request::Release, Request::Press(Button::LetGo(hold))] => hold,
            others => panic!("{others:?}"),
        }
    }

    fn known(&self) -> Page {
        let mut page = self.page().expect("a place");
        page.say(&json!({"token": self.token}));
        page
    }
}

impl Page {
    fn say(&mut self, message: &Value) {
        let _ = self.send(0x81, message.to_string().as_bytes());
    }

    /// One frame, masked by zeros.
    fn send(&mut self, kind: u8, bytes: &[u8]) -> std::io::Result<()> {
        let mut frame = vec![kind];
        match bytes.len() {
            short @ 0..126 => frame.push(0x80 | short as u8),
            long => {
                frame.push(0x80 | 127);
                frame.extend_from_slice(&(long as u64).to_be_bytes());
            }
        }
        frame.extend_from_slice(&[0; 4]);
        frame.extend_from_slice(bytes);
        self.0.write_all(&frame)
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

    /// Whether it is disconnected.
    fn is_over(&mut self) -> bool {
        while self.hear().is_some() {}
        true
    }
}

#[test]
fn fault_200_without_the_token_nothing_is_shown_and_nothing_is_done() {
    let served = served();
    for first in [
        json!({"token": "0".repeat(32)}),
        json!({"token": ""}),
        json!({"n": 1, "do": "stop"}),
        json!({"n": 1, "do": "take"}),
    ] {
        let mut page = served.page().expect("a place");
        page.say(&first);
        page.say(&json!({"n": 2, "do": "stop"}));
        assert_eq!(page.hear(), None, "{first}");
    }
    assert!(served.asked.try_recv().is_err());
    let mut page = served.known();
    assert_eq!(page.hear().expect("the cell")["kind"], "layout");
}

#[test]
fn fault_201_what_does_not_come_from_the_panels_own_page_is_refused() {
    let served = served();
    let host = served.address;
    let upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==";
    for (request, status) in [
        (format!("GET / HTTP/1.1\r\nHost: {host}"), "200"),
        (format!("GET /../Cargo.toml HTTP/1.1\r\nHost: {host}"), "404"),
        ("GET / HTTP/1.1\r\nHost: evil.example".to_owned(), "403"),
        (format!("POST / HTTP/1.1\r\nHost: {host}\r\nContent-Length: 0"), "405"),
        (format!("GET /connect HTTP/1.1\r\nHost: {host}\r\n{upgrade}"), "403"),
        (format!("GET /connect HTTP/1.1\r\nHost: {host}\r\nOrigin: http://evil.example\r\n{upgrade}"), "403"),
        (
            format!(
                "GET /connect HTTP/1.1\r\nHost: evil.example\r\nOrigin: http://evil.example\r\n{upgrade}"
            ),
            "403",
        ),
        (format!("GET /connect HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\n{upgrade}"), "101"),
    ] {
        assert_eq!(served.status(&request), status, "{request}");
    }
}

#[test]
fn fault_203_huge_and_malformed_messages_floods_and_crowds_disconnect_who_sends_them_and_reach_no_desk() {
    let served = served();
    let mut good = served.known();
    let mut page = served.known();
    let _ = page.send(0x81, &vec![b'x'; 1 << 20]);
    assert!(page.is_over());
    let mut page = served.known();
    let _ = page.send(0x82, &[0, 255]);
    assert!(page.is_over());
    let mut page = served.known();
    for _ in 0..20 {
        let _ = page.send(0x81, b"{]");
    }
    assert!(page.is_over());
    let mut page = served.known();
    for _ in 0..1000 {
        page.say(&json!({"do": "beat"}));
    }
    assert!(page.is_over());
    // Of a crowd some find no place, whether they know the token or not; and the first page is answered all the same.
    let crowd: Vec<_> = (0..60).map(|_| served.page()).collect();
    assert!(crowd.iter().any(Option::is_none) && crowd.iter().filter(|page| page.is_some()).count() <= 32);
    good.say(&json!({"n": 4, "do": "suspend", "epoch": 0, "step": 1000}));
    assert_eq!(good.answer(4).expect("answered")["outcome"], "refused");
    assert!(served.asked.try_recv().is_err());
}

#[test]
fn fault_205_a_stop_is_taken_from_every_page_whatever_it_said_before_and_whoever_has_authority() {
    let served = served();
    let (mut one, mut two) = (served.known(), served.known());
    one.say(&json!({"n": 1, "do": "take"}));
    assert_eq!(one.answer(1).expect("answered")["outcome"], "done");
    assert_eq!(served.asked.recv_timeout(PATIENCE), Ok(Request::Take));
    two.say(&json!({"n": 1, "do": "suspend", "epoch": 0, "step": 1000}));
    let refused = two.answer(1).expect("answered");
    assert!(refused["text"].as_str().is_some_and(|why| why.contains("has control")), "{refused}");
    // All that a page may say is said; the stop has no step and no epoch.
    for _ in 0..58 {
        two.say(&json!({"do": "beat"}));
    }
    for n in 2..40 {
        two.say(&json!({"n": n, "do": "stop"}));
    }
    assert_eq!(served.asked.recv_timeout(Duration::from_secs(10)), Ok(Request::Press(Button::Stop)));
    assert_eq!(two.answer(2).expect("answered")["outcome"], "done");
}

#[test]
fn fault_206_a_page_that_falls_silent_while_it_holds_lets_go_and_loses_authority() {
    let served = served();
    let mut page = served.known();
    page.say(&json!({"n": 1, "do": "take"}));
    assert_eq!(served.asked.recv_timeout(PATIENCE), Ok(Request::Take));
    page.say(&json!({"n": 2, "do": "hold", "begins": true, "epoch": 0, "step": 1000}));
    let Ok(Request::Press(Button::Hold(renewal))) = served.asked.recv_timeout(PATIENCE) else {
        panic!("no hold")
    };
    let held = renewal.hold();
    // It has control until 300 ms after its last sign of life; what it holds is let go before.
    served.pass(280);
    page.say(&json!({"n": 3, "do": "resume", "epoch": 0, "step": 1000}));
    assert_eq!(served.asked.recv_timeout(PATIENCE), Ok(Request::Press(Button::Resume)));
    served.pass(20);
    assert_eq!(served.lets_go_and_releases(), held);
    page.say(&json!({"n": 4, "do": "resume", "epoch": 0, "step": 1000}));
    assert_eq!(page.answer(4).expect("answered")["outcome"], "refused");
}

#[test]
fn fault_232_a_page_that_jogs_and_falls_silent_lets_go_and_loses_authority() {
    let served = served();
    let (mut page, mut other) = (served.known(), served.known());
    let jog = |number: u64, begins: bool| {
        let order = "world x 20% by 0.001";
        json!({"n": number, "do": "jog", "begins": begins, "robot": "arm", "order": order, "epoch": 0, "step": 1000})
    };
    // Only the page with control jogs.
    other.say(&jog(2, true));
    assert_eq!(other.answer(2).expect("answered")["outcome"], "refused");
    page.say(&json!({"n": 1, "do": "take"}));
    assert_eq!(served.asked.recv_timeout(PATIENCE), Ok(Request::Take));
    // What renews nothing begins nothing.
    page.say(&jog(2, false));
    assert!(
        page.answer(2).expect("answered")["text"]
            .as_str()
            .is_some_and(|why| why.contains("the hold is over"))
    );
    page.say(&jog(3, true));
    let renewal = |request: Result<Request, _>| match request {
        Ok(Request::Press(Button::Jog(renewal, robot, order))) => {
            assert_eq!((robot.as_str(), order.to_string().as_str()), ("arm", "world x 20% by 0.001"));
            (renewal.hold(), renewal.count())
        }
        other => panic!("{other:?}"),
    };
    let (held, _) = renewal(served.asked.recv_timeout(PATIENCE));
    // As long as it says that it is there, and holds, this goes on.
    for count in 1..5 {
        served.pass(280);
        page.say(&json!({"do": "beat"}));
        page.say(&jog(0, false));
        assert_eq!(renewal(served.asked.recv_timeout(PATIENCE)), (held, count));
    }
    served.pass(300);
    assert_eq!(served.lets_go_and_releases(), held);
    page.say(&jog(4, false));
    assert_eq!(page.answer(4).expect("answered")["outcome"], "refused");
}

#[test]
fn a_page_is_told_why_the_robot_stands_that_it_holds() {
    let served = served_by(None, |request| match request {
        Request::Press(Button::Jog(renewal, ..)) if renewal.count() == 2 => {
            Reply::Refused("another robot moves".to_owned())
        }
        request => Reply::Done(format!("{request}")),
    });
    let mut page = served.known();
    page.say(&json!({"n": 1, "do": "take"}));
    assert_eq!(page.answer(1).expect("answered")["outcome"], "done");
    for count in 0..3 {
        let order = "world x 20%";
        page.say(&json!({"do": "jog", "begins": count == 0, "robot": "arm", "order": order, "epoch": 0, "step": 1000}));
    }
    let why = page.answer(0).expect("told");
    assert_eq!((&why["outcome"], &why["text"]), (&json!("refused"), &json!("another robot moves")));
    // Another robot, in the same hold.
    page.say(&json!({"do": "hold", "epoch": 0, "step": 1000}));
    let why = page.answer(0).expect("told");
    assert!(why["text"].as_str().is_some_and(|why| why.contains("what it began with")), "{why}");
}

#[test]
fn fault_240_while_the_file_of_the_poses_does_not_answer_a_stop_and_holds_are_taken() {
    let folder = std::env::temp_dir().join(format!("mrroc-panel-slow-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("poses")).expect("a folder");
    let file = folder.join("poses/arm.txt");
    let served = served_in(Some(&folder.join("cell.toml")));
    let mut page = served.known();
    page.say(&json!({"n": 1, "do": "take"}));
    assert_eq!(served.asked.recv_timeout(PATIENCE), Ok(Request::Take));
    // A pipe that nobody writes to: whoever reads it waits.
    let made = std::process::Command::new("mkfifo").arg(&file).status().expect("mkfifo");
    assert!(made.success());
    for n in 2..30 {
        page.say(&json!({"n": n, "do": "way", "robot": "arm", "name": "pick"}));
    }
    // Some wait for the file; those that are too many are refused.
    let refused = page.answer(20).expect("answered");
    assert!(refused["text"].as_str().is_some_and(|why| why.contains("do not answer")), "{refused}");
    page.say(&json!({"n": 40, "do": "hold", "begins": true, "epoch": 0, "step": 1000}));
    assert!(matches!(served.asked.recv_timeout(PATIENCE), Ok(Request::Press(Button::Hold(_)))));
    page.say(&json!({"n": 41, "do": "stop"}));
    assert_eq!(served.asked.recv_timeout(PATIENCE), Ok(Request::Press(Button::Stop)));
    // Somebody writes: the first one that waited is answered.
    drop(std::fs::OpenOptions::new().write(true).open(&file).expect("opened"));
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn a_page_teaches_a_robot_that_stands_and_is_shown_the_way_to_what_it_taught() {
    use mrroc_core::robot::Robot;
    use mrroc_robots::{Irp6, Six};
    let folder = std::env::temp_dir().join(format!("mrroc-panel-poses-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let at = |joints: Six| {
        let joints = joints.as_slice().to_vec();
        let q = Six::from_column_slice(&joints);
        crate::now::RobotNow {
            name: "arm".to_owned(),
            time: 0.0,
            demanded: joints.clone(),
            measured: joints,
            tool: Irp6::nominal().forward(&q),
            doing: String::new(),
            jogs: true,
            stop: String::new(),
            carried: crate::beside::Carried::default(),
        }
    };
    let (home, there) =
        (Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0), Six::new(0.4, -1.5, 0.1, -0.1, 4.6, 0.3));
    let served = served_in(Some(&folder.join("cell.toml")));
    let stamp = Some((Stamp { epoch: 0, step: 1000 }, 2_000_000));
    let show = |joints: Six, moves: bool| {
        let robots = [at(joints)].into();
        served.shown.send_replace(Shown { text: None, stamp, robots, moves, over: None });
    };
    let mut page = served.known();
    page.say(&json!({"n": 1, "do": "take"}));
    assert_eq!(page.answer(1).expect("answered")["outcome"], "done");
    let mut ask = |n: u64, message: &Value| {
        let mut message = message.clone();
        message["n"] = json!(n);
        (message["epoch"], message["step"]) = (json!(0), json!(1000));
        page.say(&message);
        page.answer(n).expect("answered")
    };
    let teach = json!({"do": "teach", "robot": "arm", "name": "pick"});
    show(there, true);
    assert!(ask(2, &teach)["text"].as_str().is_some_and(|why| why.contains("let them come to rest")));
    show(there, false);
    assert_eq!(ask(3, &teach)["outcome"], "done");
    show(home, false);
    // Straight in joint space: as the generator goes.
    let way = ask(4, &json!({"do": "way", "robot": "arm", "name": "pick"}));
    let places = way["way"].as_array().expect("places");
    for (i, place) in places.iter().enumerate() {
        let share = i as f64 / (places.len() - 1) as f64;
        let tool = Irp6::nominal().forward(&(home + (there - home) * share)).translation.vector;
        let off = (0..3).map(|k| (place[k].as_f64().expect("a number") - tool[k]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{i}: {place} {tool}");
    }
    assert_eq!(
        ask(5, &json!({"do": "rename", "robot": "arm", "name": "pick", "to": "place"}))["outcome"],
        "done"
    );
    assert_eq!(ask(6, &json!({"do": "way", "robot": "arm", "name": "pick"}))["outcome"], "refused");
    let taught = mrroc_generators::teach::Taught::read(&folder.join("poses/arm.txt")).expect("in order");
    assert_eq!(taught.select(&["place"]).expect("there").poses[0].coordinates(), there.as_slice());
    assert_eq!(ask(7, &json!({"do": "forget", "robot": "arm", "name": "place"}))["outcome"], "done");
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn a_page_is_shown_the_links_and_the_tool_where_the_robots_own_kinematics_have_them() {
    use mrroc_core::pose::Pose;
    use mrroc_core::robot::Robot;
    use mrroc_robots::{Irp6, Six};
    let joints = Six::new(0.3, -1.4, 0.1, -0.2, 4.6, 0.5);
    let tool = Irp6::nominal().forward(&joints) * Pose::translation(0.0, 0.0, 0.1);
    let mut robot = crate::now::RobotNow {
        name: "arm".to_owned(),
        time: 0.0,
        demanded: joints.as_slice().to_vec(),
        measured: joints.as_slice().to_vec(),
        tool,
        doing: String::new(),
        jogs: false,
        stop: String::new(),
        carried: crate::beside::Carried::default(),
    };
    let state = looks().state(&Now { robots: vec![robot.clone()], ..Now::default() });
    let numbers = |value: &Value| {
        value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect::<Vec<_>>()
    };
    let shown = numbers(&state["robots"][0]["tool"]);
    let at = tool.translation.vector;
    assert!((0..3).all(|i| (shown[i] - at[i]).abs() < 1e-6), "{shown:?} {at}");
    let mut flange = Vec::new();
    Irp6::nominal().frames(&joints, &mut |frame| flange = frame.translation.vector.as_slice().to_vec());
    let last =
        numbers(state["robots"][0]["frames"].as_array().and_then(|frames| frames.last()).expect("a frame"));
    assert!((0..3).all(|i| (last[i] - flange[i]).abs() < 1e-6), "{last:?} {flange:?}");
    assert!(state["robots"][0]["links"].as_array().is_some_and(|links| links.len() > 2));
    // It is where it is demanded, to less than 2 mm: there is no ghost. Turned by 0.1 rad about its upright first axis, the flange is
    // demanded r * 2 sin(0.05) away.
    assert_eq!(state["robots"][0]["ghost"], json!([]));
    robot.demanded[0] += 0.1;
    let state = looks().state(&Now { robots: vec![robot], ..Now::default() });
    let end = |which: &str| {
        let links = state["robots"][0][which].as_array().expect("links");
        numbers(links.last().expect("a link"))
    };
    let (link, ghost) = (end("links"), end("ghost"));
    let apart = (link[3] - ghost[3]).hypot(link[4] - ghost[4]);
    let chord = link[3].hypot(link[4]) * 2.0 * 0.05_f64.sin();
    assert!((apart - chord).abs() < 5e-6 && (link[5] - ghost[5]).abs() < 2e-6, "{apart} {chord}");
}
