//! The operator's live view of a running cell, in a terminal.
//!
//! In: pictures of the cell, up to 20 a second, answers to what was pressed, and keys. Out: a screen, and requests to
//! the cell. `screen` draws the screen and `keys` gives the meaning of a key. The view is a console like any other:
//! the cell does not wait for it.

mod keys;
mod screen;

use std::io;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Duration;

use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{Event, KeyEventKind, poll, read};

use keys::{Pressed, meaning};
use mrroc_processes::{Asks, Caller, Heard, Hears, Request};
use screen::{Screen, draw};

/// How long the view waits for a key before it looks for a picture.
const LOOK: Duration = Duration::from_millis(25);

/// Shows the cell until the operator quits or the cell ends.
///
/// # Errors
/// There is no terminal to draw on, or what came from the console server is neither an answer nor a picture.
pub fn view(caller: Caller) -> io::Result<()> {
    let Caller { mut asks, hears } = caller;
    asks.ask(&Request::Watch)?;
    let heard = listen(hears)?;
    let no_terminal = |error| io::Error::other(format!("no terminal to draw on: {error}"));
    let mut terminal = ratatui::try_init().map_err(no_terminal)?;
    let outcome = show(&mut terminal, &mut asks, &heard);
    ratatui::restore();
    outcome
}

/// Receives from the console server in a thread of its own, which ends with the connection.
fn listen(mut hears: Hears) -> io::Result<Receiver<io::Result<Heard>>> {
    let (sender, heard) = channel();
    std::thread::Builder::new().name("hears".to_owned()).spawn(move || {
        loop {
            let came = hears.hear();
            let over = came.is_err();
            if sender.send(came).is_err() || over {
                return;
            }
        }
    })?;
    Ok(heard)
}

fn show(
    terminal: &mut DefaultTerminal,
    asks: &mut Asks,
    heard: &Receiver<io::Result<Heard>>,
) -> io::Result<()> {
    let mut screen = Screen::default();
    loop {
        loop {
            match heard.try_recv() {
                Ok(Ok(Heard::Picture(picture))) => screen.picture = Some(*picture),
                Ok(Ok(Heard::Reply(reply))) => screen.reply = Some(reply),
                // The last picture stays on the screen until the operator quits.
                Ok(Err(error)) => screen.over = Some(error.to_string()),
                Err(TryRecvError::Empty | TryRecvError::Disconnected) => break,
            }
        }
        terminal.draw(|frame| draw(frame, &screen))?;
        if !poll(LOOK)? {
            continue;
        }
        let Event::Key(key) = read()? else { continue };
        if key.kind != KeyEventKind::Press {
            continue;
        }
        let speed = screen.picture.as_ref().map_or(1.0, |picture| picture.speed);
        match meaning(key, speed) {
            Pressed::Quit => return Ok(()),
            // The connection is closed, so that no request can be sent.
            Pressed::Ask(_) if screen.over.is_some() => {}
            Pressed::Ask(request) => {
                if let Err(error) = asks.ask(&request) {
                    screen.over = Some(error.to_string());
                }
            }
            Pressed::Nothing => {}
        }
    }
}
