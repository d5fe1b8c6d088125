//! The connection of one page: frames there and back, as its [session](crate::session) has them.

use std::task::{Context, Poll};

use axum::Error;
use axum::extract::ws::{CloseFrame, Message as Frame, WebSocket};
use futures_util::stream::SplitSink;
use futures_util::{Sink, StreamExt};

use crate::driver::Place;
use crate::events::PageEvent;
use crate::session::Outgoing;

/// Serves a page until it goes.
pub async fn serve(socket: WebSocket, place: Place) {
    let (panel, key) = (&place.panel, place.key);
    let (mut sends, mut hears) = socket.split();
    let mut news = panel.news();
    let mut sending: Option<Sending> = None;
    panel.update(|pages, now| pages.begin(key, now));
    loop {
        news.mark_unchanged();
        let Some(next) = panel.update(|pages, now| pages.poll(key, now)) else { return };
        if let Some(send) = next.send {
            sending = Some(Sending::of(send));
        }
        tokio::select! {
            biased;
            sent = send(&mut sending, &mut sends) => {
                sending = None;
                panel.update(|pages, now| match sent {
                    Ok(()) => pages.sent(key),
                    Err(error) => pages.fail(key, now, &error.to_string()),
                });
            }
            frame = hears.next(), if next.listens => {
                panel.update(|pages, now| match &frame {
                    Some(Ok(Frame::Text(text))) => pages.hear(key, now, PageEvent::Text(text)),
                    Some(Ok(Frame::Ping(_) | Frame::Pong(_))) => pages.hear(key, now, PageEvent::Control),
                    Some(Ok(Frame::Binary(_))) => pages.hear(key, now, PageEvent::Binary),
                    Some(Ok(Frame::Close(_))) | None => pages.hear(key, now, PageEvent::Closed),
                    Some(Err(error)) => pages.hear(key, now, PageEvent::Failed(error.to_string())),
                });
            }
            _ = news.changed() => {}
            () = panel.wait(next.until) => {}
        }
    }
}

/// A frame that is being sent.
enum Sending {
    /// It waits until the connection takes it.
    Waits(Frame),
    /// The connection has it, and sends it.
    Goes,
}

impl Sending {
    fn of(send: Outgoing) -> Sending {
        Sending::Waits(match send {
            Outgoing::Text(text) => Frame::Text(text),
            Outgoing::Close(why) => Frame::Close(Some(CloseFrame { code: 1008, reason: why.into() })),
        })
    }

    /// Goes on with it: nothing of it is lost if it is not ready.
    fn poll(
        &mut self,
        sends: &mut SplitSink<WebSocket, Frame>,
        context: &mut Context<'_>,
    ) -> Poll<Result<(), Error>> {
        let mut sends = std::pin::Pin::new(sends);
        if let Sending::Waits(_) = self {
            std::task::ready!(sends.as_mut().poll_ready(context))?;
            if let Sending::Waits(frame) = std::mem::replace(self, Sending::Goes) {
                sends.as_mut().start_send(frame)?;
            }
        }
        sends.poll_flush(context)
    }
}

/// Sends on what is begun, if anything is.
async fn send(sending: &mut Option<Sending>, sends: &mut SplitSink<WebSocket, Frame>) -> Result<(), Error> {
    std::future::poll_fn(|context| match sending {
        Some(sending) => sending.poll(sends, context),
        None => Poll::Pending,
    })
    .await
}
