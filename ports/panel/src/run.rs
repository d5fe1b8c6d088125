//! The process, or the thread, that has the panel.
//!
//! In: a cell that runs, or the course of one that is over. Out: an address at the terminal, and a page there, until the cell ends or
//! this process is ended.

use std::io;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use mrroc_core::console::{refused, say};
use mrroc_core::observe::layout::Layout;
use tokio::net::TcpListener;
use tokio::sync::watch;

use crate::course::Course;
use crate::desk::{Desk, Shown};
use crate::now::Looks;
use crate::rules::token::Token;
use crate::server::{Panel, Source, serve};
use crate::socket::look_after;

/// How long pages are told of the end of a cell.
const FAREWELL: Duration = Duration::from_millis(500);

/// The nice value of who comes last.
const LAST: i32 = 19;

/// The port that is asked for by this variable of the environment; otherwise the system gives one that is free.
const PORT: &str = "MRROC_PANEL_PORT";

/// Shows a cell that runs, until it ends.
pub fn attend(layout: &Layout, cell: &Path) -> ExitCode {
    // It takes the time that the cell leaves. Where it may not be set, it is shown all the same.
    let _ = rustix::process::setpriority_process(None, LAST);
    let looks = Arc::new(Looks::of(layout));
    match Desk::open(cell, Arc::clone(&looks)) {
        Ok((desk, shown)) => begin(looks, Source::Running(desk, shown), Some(cell)),
        Err(error) => refused(&error),
    }
}

/// Shows a run that is over, until this process is ended.
pub fn play(looks: Arc<Looks>, course: Course) -> ExitCode {
    begin(looks, Source::Over(Box::new(course)), None)
}

fn begin(looks: Arc<Looks>, source: Source, cell: Option<&Path>) -> ExitCode {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build();
    let ended = match runtime {
        Ok(runtime) => runtime.block_on(run(looks, source, cell)),
        Err(error) => Err(error),
    };
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => refused(&format!("the panel cannot be shown: {error}")),
    }
}

async fn run(looks: Arc<Looks>, source: Source, cell: Option<&Path>) -> io::Result<()> {
    let port = std::env::var(PORT).ok().and_then(|port| port.parse().ok()).unwrap_or(0);
    let listener = TcpListener::bind(("127.0.0.1", port)).await?;
    let port = listener.local_addr()?.port();
    let token = Token::draw()?;
    let shown = match &source {
        Source::Running(_, shown) => Some(shown.clone()),
        Source::Over(_) => None,
    };
    let panel = Panel::new(source, looks, token, port);
    let panel = Arc::new(cell.into_iter().fold(panel, Panel::teaching));
    let how = if shown.is_some() { "" } else { "; Ctrl-C ends it" };
    let _ = say(&format!("panel: http://127.0.0.1:{port}/#token={token}{how}\n"));
    tokio::select! {
        served = serve(listener, Arc::clone(&panel)) => served,
        () = look_after(panel) => Ok(()),
        () = end(shown) => Ok(()),
    }
}

/// Waits until the cell has ended, and its pages know it.
async fn end(shown: Option<watch::Receiver<Shown>>) {
    match shown {
        Some(mut shown) => {
            // The thread that shows the cell says why it ends.
            let _ = shown.wait_for(|shown| shown.over.is_some()).await;
            tokio::time::sleep(FAREWELL).await;
        }
        None => std::future::pending().await,
    }
}
