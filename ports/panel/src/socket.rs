//! One page that is connected.
//!
//! In: its messages. Out: what the cell does, and answers. Nothing is shown and nothing is done before the page has shown the token. A
//! page that speaks too much, says what is no message, or does not read, is disconnected; no other page and no cell waits for it.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message as Frame, Utf8Bytes, WebSocket};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use mrroc_processes::{OnBehalf, Reply, Request};
use serde_json::json;
use tokio::sync::{OwnedSemaphorePermit, mpsc, oneshot};
use tokio::time::timeout;

use crate::rules::authority::Page;
use crate::rules::rate::Rate;
use crate::rules::request::{Asked, Message, Stamp};
use crate::server::{Panel, Source};
use crate::stand::monotonic;
use crate::teaching;

/// How long a page may take to show the token, and to read what it is sent.
const TOKEN: Duration = Duration::from_secs(5);
const READS: Duration = Duration::from_secs(5);

/// Answers that wait for a page.
const ANSWERS: usize = 64;

/// Messages that are none, until a page is disconnected.
const BAD: usize = 8;

/// Answers to a page, of any task.
pub type Answers = mpsc::Sender<Utf8Bytes>;

/// Serves a page until it goes.
pub async fn serve(socket: WebSocket, panel: Arc<Panel>, place: OwnedSemaphorePermit) {
    let (mut sends, mut hears) = socket.split();
    let shown = timeout(TOKEN, hears.next()).await;
    let token = match shown {
        Ok(Some(Ok(Frame::Text(text)))) => Message::read(&text).map(|message| message.asked),
        Ok(_) | Err(_) => return,
    };
    match token {
        Ok(Asked::Token(token)) if panel.token.is(&token) => {}
        Ok(_) | Err(_) => {
            let _ = timeout(READS, sends.send(closing("this is not the token"))).await;
            return;
        }
    }
    let page = panel.number();
    panel.note(&format!("page {page} looks on"));
    let (answers, waiting) = mpsc::channel(ANSWERS);
    let writes = tokio::spawn(write(sends, Arc::clone(&panel), waiting, page));
    let why = read(&mut hears, &panel, page, &answers).await;
    // First of all: nobody holds anything for a page that is gone.
    tell_desk(&panel, OnBehalf { page, heard: monotonic() }, panel.stand.leave(page));
    panel.note(&format!("page {page} is gone{why}"));
    // What it was sent last is told why.
    drop(answers);
    let _ = timeout(Duration::from_secs(1), writes).await;
    drop(place);
}

fn closing(why: &'static str) -> Frame {
    Frame::Close(Some(CloseFrame { code: 1008, reason: why.into() }))
}

/// Sends what the cell does, and answers, to a page.
async fn write(
    mut sends: SplitSink<WebSocket, Frame>,
    panel: Arc<Panel>,
    mut answers: mpsc::Receiver<Utf8Bytes>,
    page: Page,
) {
    let lasts = match &panel.source {
        Source::Running(..) => None,
        Source::Over(course) => Some(course.lasts()),
    };
    let mut layout = panel.looks.layout(lasts);
    layout["page"] = json!(page);
    let mut notes = panel.notes.subscribe();
    let mut shown = match &panel.source {
        Source::Running(_, shown) => Some(shown.clone()),
        Source::Over(_) => None,
    };
    if let Some(shown) = &mut shown {
        shown.mark_changed();
    }
    let mut taught = panel.taught.subscribe();
    taught.mark_changed();
    let mut next: Option<Utf8Bytes> = Some(layout.to_string().into());
    let mut meshes = panel.looks.meshes().messages().iter();
    let mut told = None;
    loop {
        if let Some(text) = next.take() {
            match timeout(READS, sends.send(Frame::Text(text))).await {
                Ok(Ok(())) => {}
                Ok(Err(_)) | Err(_) => return,
            }
        }
        if let Some(mesh) = meshes.next() {
            next = Some(mesh.as_str().into());
            continue;
        }
        // Who has authority, whenever that has changed.
        let holder = panel.stand.holder();
        if told != Some(holder) {
            told = Some(holder);
            next = Some(
                json!({"kind": "authority", "page": holder, "yours": holder == Some(page)})
                    .to_string()
                    .into(),
            );
            continue;
        }
        next = tokio::select! {
            biased;
            answer = answers.recv() => match answer {
                Some(answer) => Some(answer),
                None => {
                    let _ = timeout(READS, sends.send(closing("the panel has closed the connection"))).await;
                    return;
                }
            },
            note = notes.recv() => {
                note.ok().map(|text| json!({"kind": "note", "text": &*text}).to_string().into())
            }
            _ = taught.changed() => taught.borrow_and_update().clone(),
            changed = changed(shown.as_mut()) => changed,
            () = tokio::time::sleep(Duration::from_millis(250)) => None,
        };
    }
}

/// The next thing that a running cell does; of a run that is over, nothing.
async fn changed(shown: Option<&mut tokio::sync::watch::Receiver<crate::desk::Shown>>) -> Option<Utf8Bytes> {
    let Some(shown) = shown else { return std::future::pending().await };
    if shown.changed().await.is_err() {
        return std::future::pending().await;
    }
    let shown = shown.borrow_and_update();
    match &shown.over {
        Some(why) => Some(json!({"kind": "over", "text": why}).to_string().into()),
        None => shown.text.clone(),
    }
}

/// Takes the messages of a page until it goes; why, in words that follow others.
async fn read(
    hears: &mut SplitStream<WebSocket>,
    panel: &Arc<Panel>,
    page: Page,
    answers: &Answers,
) -> String {
    let mut rate = Rate::begin(panel.now());
    let (mut bad, mut stopping) = (0, None::<tokio::task::JoinHandle<()>>);
    while let Some(frame) = hears.next().await {
        let text = match frame {
            Ok(Frame::Text(text)) => text,
            Ok(Frame::Ping(_) | Frame::Pong(_)) if rate.may(panel.now()) => continue,
            Ok(Frame::Close(_)) => break,
            Ok(Frame::Binary(_) | Frame::Ping(_) | Frame::Pong(_)) => {
                return ": it sent what is no text".to_owned();
            }
            Err(error) => return format!(": {error}"),
        };
        let by = OnBehalf { page, heard: monotonic() };
        let may = rate.may(panel.now());
        let message = match Message::read(&text) {
            // A stop is taken however much was said before; one that comes while the page's last one is under way is part of it.
            Ok(Message { number, asked: Asked::Stop }) => {
                if stopping.as_ref().is_none_or(tokio::task::JoinHandle::is_finished) {
                    stopping = stop(panel, by, number, answers);
                }
                continue;
            }
            _ if !may => return ": it said too much".to_owned(),
            Ok(message) => message,
            Err(why) => {
                bad += 1;
                if bad > BAD {
                    return ": it said what is no message".to_owned();
                }
                if answer(answers, 0, "refused", &why.to_string()).is_err() {
                    return ": it does not read".to_owned();
                }
                continue;
            }
        };
        if obey(panel, by, message, answers).is_err() {
            return ": it does not read".to_owned();
        }
    }
    String::new()
}

/// A page's answers are full.
pub struct DoesNotRead;

/// Answers what a page has asked for.
///
/// # Errors
/// [`DoesNotRead`]
pub fn answer(answers: &Answers, number: u64, outcome: &str, text: &str) -> Result<(), DoesNotRead> {
    if number == 0 && outcome == "done" {
        return Ok(());
    }
    let said = json!({"kind": "answer", "n": number, "outcome": outcome, "text": text}).to_string();
    answers.try_send(said.into()).map_err(|_| DoesNotRead)
}

/// Stops the cell, for any page with the token.
fn stop(
    panel: &Arc<Panel>,
    by: OnBehalf,
    number: u64,
    answers: &Answers,
) -> Option<tokio::task::JoinHandle<()>> {
    match &panel.source {
        Source::Running(desk, _) => Some(carry(panel, by.page, "stop", desk.stop(by), number, answers)),
        Source::Over(_) => {
            let _ = answer(answers, number, "refused", "the run is over");
            None
        }
    }
}

/// Does what a page asks for, or says why not.
fn obey(panel: &Arc<Panel>, by: OnBehalf, message: Message, answers: &Answers) -> Result<(), DoesNotRead> {
    let page = by.page;
    let Message { number, asked } = message;
    let refused = |why: &str| answer(answers, number, "refused", why);
    let (desk, shown) = match &panel.source {
        Source::Running(desk, shown) => (desk, shown),
        Source::Over(course) => {
            return match asked {
                Asked::Frame(at, minute) => match course.at(at) {
                    Some(now) => {
                        let mut state = panel.looks.state(now);
                        if minute {
                            state["minute"] = course.minute(at).map(|now| panel.looks.plotted(now)).collect();
                        }
                        answers.try_send(state.to_string().into()).map_err(|_| DoesNotRead)
                    }
                    None => refused("nothing was seen of this run"),
                },
                Asked::Beat => Ok(()),
                _ => refused("the run is over: there is nothing to operate"),
            };
        }
    };
    let ask = |word: &str, request: Request| {
        carry(panel, page, word, desk.ask(request, by), number, answers);
        Ok(())
    };
    let now = panel.now();
    let is_new = |stamp: Stamp| match shown.borrow().stamp {
        Some((newest, period)) => stamp.check(newest, period).map_err(|old| old.to_string()),
        None => Err("the cell has not been seen yet".to_owned()),
    };
    match asked {
        Asked::Beat => {
            panel.stand.beat(page, now);
            Ok(())
        }
        Asked::Take => match panel.stand.take(page, now) {
            Ok(()) => ask("take control", Request::Take),
            Err(why) => refused(&why.to_string()),
        },
        Asked::LetGo => {
            tell_desk(panel, by, panel.stand.leave(page));
            panel.note(&format!("page {page}: let go of control"));
            answer(answers, number, "done", "nobody has control")
        }
        Asked::Press(button, stamp) => {
            match panel.stand.check(page, now).map_err(|why| why.to_string()).and_then(|()| is_new(stamp)) {
                Ok(()) => ask(&button.to_string(), Request::Press(button)),
                Err(why) => refused(&why),
            }
        }
        Asked::Hold(_, stamp) | Asked::Jog(.., stamp) => {
            let (begins, jog) = match asked {
                Asked::Jog(begins, robot, order, _) => (begins, Some((robot, order))),
                Asked::Hold(begins, _) => (begins, None),
                _ => (false, None),
            };
            match panel.stand.check(page, now).map_err(|why| why.to_string()).and_then(|()| is_new(stamp)) {
                Ok(()) => match panel.stand.renew(begins, jog, now) {
                    Ok(button) if begins => {
                        let word = jog.map(|(robot, order)| format!("jog {robot} {order}"));
                        ask(word.as_deref().unwrap_or("hold"), Request::Press(button))
                    }
                    Ok(button) => {
                        renew(desk.ask(Request::Press(button), by), number, answers);
                        Ok(())
                    }
                    Err(why) => refused(&why.to_string()),
                },
                Err(why) => refused(&why),
            }
        }
        Asked::Release => match panel.stand.check(page, now).ok().and_then(|()| panel.stand.release()) {
            Some(button) => ask("let go", Request::Press(button)),
            None => answer(answers, number, "done", "nothing is held"),
        },
        Asked::Teach(..) | Asked::Rename(..) | Asked::Forget(..) | Asked::Way(..) => {
            let may = match &asked {
                Asked::Way(..) => Ok(()),
                _ => panel.stand.check(page, now).map_err(|why| why.to_string()),
            };
            let may = may.and_then(|()| match &asked {
                Asked::Teach(.., stamp) => is_new(*stamp),
                _ => Ok(()),
            });
            match may {
                Ok(()) => teaching::begin(panel, page, number, asked, shown.borrow().clone(), answers),
                Err(why) => refused(&why),
            }
        }
        Asked::Token(_) | Asked::Frame(..) => {
            refused("this is a cell that runs, and the page is let in already")
        }
        Asked::Stop => Ok(()),
    }
}

/// Tells a page, and all others, what became of what it asked for.
fn carry(
    panel: &Arc<Panel>,
    page: Page,
    word: &str,
    answered: oneshot::Receiver<Reply>,
    number: u64,
    answers: &Answers,
) -> tokio::task::JoinHandle<()> {
    let (panel, word, answers) = (Arc::clone(panel), word.to_owned(), answers.clone());
    tokio::spawn(async move {
        let (outcome, text) = match answered.await {
            Ok(Reply::Done(text)) => ("done", text),
            Ok(Reply::Refused(text)) => ("refused", text),
            Ok(Reply::Pending(text)) => ("pending", text),
            Err(_) => ("refused", "the panel is ending".to_owned()),
        };
        if word == "take control" && outcome == "refused" {
            // Another console has it: this page has nothing either.
            panel.stand.leave(page);
        }
        panel.note(&format!("page {page}: {word}: {outcome}: {text}"));
        let _ = answer(&answers, number, outcome, &text);
    })
}

/// Tells a page why a hold that it renews moves nothing: ten times a second at most, so that no other page is told.
fn renew(answered: oneshot::Receiver<Reply>, number: u64, answers: &Answers) {
    let answers = answers.clone();
    tokio::spawn(async move {
        if let Ok(Reply::Refused(why) | Reply::Pending(why)) = answered.await {
            let _ = answer(&answers, number, "refused", &why);
        }
    });
}

/// Asks the desk for something of which no page waits for the answer.
fn tell_desk(panel: &Panel, by: OnBehalf, requests: Vec<Request>) {
    if let Source::Running(desk, _) = &panel.source {
        for request in requests {
            drop(desk.ask(request, by));
        }
    }
}

/// How often it is looked whether a page has said nothing for too long: one that holds, and any other.
const HOLDS: Duration = Duration::from_millis(4);
const LOOKS: Duration = Duration::from_millis(20);

/// Ends the hold of a page that has said nothing for too long, and takes authority from it, again and again.
pub async fn look_after(panel: Arc<Panel>) {
    loop {
        tokio::time::sleep(if panel.stand.holds() { HOLDS } else { LOOKS }).await;
        if let Some((page, button)) = panel.stand.lapsed_hold(panel.now()) {
            tell_desk(&panel, OnBehalf { page, heard: monotonic() }, vec![Request::Press(button)]);
            panel.note(&format!("page {page} did not renew its hold"));
        }
        if let Some((page, requests)) = panel.stand.lapse(panel.now()) {
            tell_desk(&panel, OnBehalf { page, heard: monotonic() }, requests);
            panel.note(&format!("page {page} was silent for too long, and has lost control"));
        }
    }
}
