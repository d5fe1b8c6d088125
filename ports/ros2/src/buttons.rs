//! The operator's buttons as services.
//!
//! In: a request of another node. Out: the same request of a console to the cell, and its answer. Each service has a thread and a connection of its
//! own, so that no other request holds up a stop.

use std::path::Path;
use std::time::{Duration, Instant};

use mrroc_core::operator::button::Button;
use mrroc_core::operator::{Answer, Request};
use mrroc_processes::{Caller, ConsoleMessage};
use ros2_client::Server;

use crate::messages::{TriggerRequest, TriggerResponse};
use crate::node::RosNode;

/// The services.
const BUTTONS: [(&str, Button); 6] = [
    ("stop", Button::Stop),
    ("abort", Button::Abort),
    ("suspend", Button::Suspend),
    ("resume", Button::Resume),
    ("acknowledge", Button::Acknowledge),
    ("reset", Button::Reset),
];

/// How often services that bring robots to rest look for requests, and how often the others do.
const SOON: Duration = Duration::from_millis(2);
const LOOK: Duration = Duration::from_millis(20);

/// A request that has waited for so long behind another one is not carried out: who asked may have given up.
const STALE: Duration = Duration::from_secs(2);

/// Presses a button of the cell whose file is at `cell`; what became of it.
///
/// # Errors
/// Why it was refused, or no cell is there.
pub fn press(cell: &Path, button: Button) -> Result<String, String> {
    let mut caller = Caller::to(cell).map_err(|error| error.to_string())?;
    let answered = caller.ask(&Request::Press(button), None).map_err(|error| error.to_string())?;
    match answered {
        ConsoleMessage::Answer(Answer::Done(text) | Answer::Pending(text)) => Ok(text),
        ConsoleMessage::Answer(Answer::Refused(why)) => Err(why),
        ConsoleMessage::Picture(_) => Err("the cell answered by a picture".to_owned()),
    }
}

/// Offers all buttons of the cell whose file is at `cell`.
///
/// # Errors
/// Why a service cannot be offered.
pub fn offer(node: &mut RosNode, cell: &Path) -> Result<(), String> {
    for (name, button) in BUTTONS {
        let server = node.service(name, ("std_srvs", "Trigger"))?;
        let cell = cell.to_owned();
        std::thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || serve(&server, &cell, button))
            .map_err(|error| format!("service {name}: {error}"))?;
    }
    Ok(())
}

fn serve(server: &Server<TriggerRequest, TriggerResponse>, cell: &Path, button: Button) {
    let is_urgent = matches!(button, Button::Stop | Button::Abort);
    let answer = |asked, pressed: Result<String, String>| {
        let success = pressed.is_ok();
        let message = pressed.unwrap_or_else(|why| why);
        drop(server.send_response(asked, TriggerResponse { success, message }));
    };
    loop {
        // A request that cannot be read is another node's fault, and is not answered.
        while let Ok(Some((asked, _))) = server.receive_request() {
            let since = Instant::now();
            answer(asked, press(cell, button));
            if since.elapsed() < STALE || is_urgent {
                continue;
            }
            while let Ok(Some((asked, _))) = server.receive_request() {
                answer(
                    asked,
                    Err("it waited for another request, to which the cell did not answer: ask again"
                        .to_owned()),
                );
            }
        }
        std::thread::sleep(if is_urgent { SOON } else { LOOK });
    }
}
