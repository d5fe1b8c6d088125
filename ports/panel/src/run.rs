//! The process, or the thread, that has the panel.
//!
//! In: a cell that runs, or the history of one that is over. Out: an address at the terminal, and a page there, until the cell ends or
//! this process is ended.

use std::ffi::OsString;
use std::io;
use std::net::SocketAddr;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use mrroc_core::console::{refused, say};
use mrroc_core::observe::layout::Layout;
use mrroc_launch::RunObserver;
use tokio::net::TcpListener;
use tokio::sync::watch;

use crate::console_session::{CellSnapshot, ConsoleSession};
use crate::driver::{Panel, Source, look_after};
use crate::now::Appearance;
use crate::rules::token::Token;
use crate::run_history::{OnMemory, RunHistory};
use crate::secured::Secured;
use crate::server::serve;

/// How long pages are told of the end of a cell.
const FAREWELL: Duration = Duration::from_millis(500);

/// How much nicer the thread is that serves pages than the processes of the cell. It does little, and pages that it hears late lose control: with the nice value of who
/// comes last a machine on which much else runs lets it wait for a second.
const SERVES: i32 = 5;

/// The address and port that are asked for by this variable of the environment; otherwise the panel answers on loopback, at a port that is
/// free.
const ADDRESS: &str = "MRROC_PANEL_ADDRESS";

/// The folder of certificates beside the cell's file.
const CERTIFICATES: &str = "certificates";

/// Shows a cell that runs, until it ends.
pub fn attend(layout: &Layout, cell: &Path) -> ExitCode {
    let looks = Arc::new(Appearance::of(layout));
    match ConsoleSession::open(cell, Arc::clone(&looks)) {
        Ok((console, shown)) => {
            // Of this thread and those that it begins. Where it may not be set, the cell is shown all the same.
            let _ = rustix::process::nice(SERVES);
            begin(looks, Source::Running(Box::new(console), shown), Some(cell))
        }
        Err(error) => refused(&error),
    }
}

/// Shows a run that is over, until this process is ended.
pub fn play(looks: Arc<Appearance>, history: RunHistory) -> ExitCode {
    begin(looks, Source::Over(Box::new(history)), None)
}

impl RunObserver for OnMemory {
    fn show(&self) -> ExitCode {
        let (looks, history) = self.take();
        play(Arc::new(looks), history)
    }
}

fn begin(looks: Arc<Appearance>, source: Source, cell: Option<&Path>) -> ExitCode {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build();
    let ended = match runtime {
        Ok(runtime) => {
            let ended = runtime.block_on(run(looks, source, cell));
            // A file that does not answer holds up no end.
            runtime.shutdown_background();
            ended
        }
        Err(error) => Err(error),
    };
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => refused(&format!("the panel cannot be shown: {error}")),
    }
}

/// Where the panel is to answer.
///
/// # Errors
/// What is wrong with what was asked for.
fn asked(variable: Option<OsString>) -> io::Result<SocketAddr> {
    let Some(text) = variable else { return Ok(SocketAddr::from(([127, 0, 0, 1], 0))) };
    let bad = |why: &str| {
        let text = text.to_string_lossy();
        io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("{ADDRESS}={text} {why}, such as 192.168.1.5:7411"),
        )
    };
    let address: SocketAddr = text
        .to_str()
        .and_then(|text| text.parse().ok())
        .ok_or_else(|| bad("is no address: write one of this machine and a port"))?;
    if address.ip().is_unspecified() {
        return Err(bad("means all networks of this machine: write its address in the one that is meant"));
    }
    Ok(address)
}

async fn run(looks: Arc<Appearance>, source: Source, cell: Option<&Path>) -> io::Result<()> {
    let asked = asked(std::env::var_os(ADDRESS))?;
    let secured = if asked.ip().is_loopback() {
        None
    } else {
        let folder = cell.and_then(Path::parent).map(|folder| folder.join(CERTIFICATES));
        Some(Secured::at(asked.ip(), folder.as_deref())?)
    };
    let listener = TcpListener::bind(asked).await?;
    let address = listener.local_addr()?;
    let token = Token::draw()?;
    let shown = match &source {
        Source::Running(_, shown) => Some(shown.clone()),
        Source::Over(_) => None,
    };
    let panel = Panel::new(source, looks, token, address);
    let panel = Arc::new(cell.into_iter().fold(panel, Panel::teaching));
    let how = if shown.is_some() { "" } else { " (Ctrl-C ends it)" };
    let scheme = panel.origins.scheme();
    let mut told = format!("panel: {scheme}{address}/#token={token}{how}\n");
    if let Some(secured) = &secured {
        told += &format!(
            "panel: compare the SHA-256 fingerprint of its certificate before you trust it:\n  {}\n",
            secured.fingerprint()
        );
    }
    let _ = say(&told);
    tokio::select! {
        served = serve(listener, Arc::clone(&panel), secured) => served,
        () = look_after(panel) => Ok(()),
        () = end(shown) => Ok(()),
    }
}

/// Waits until the cell has ended, and its pages know it.
async fn end(shown: Option<watch::Receiver<CellSnapshot>>) {
    match shown {
        Some(mut shown) => {
            // The thread that shows the cell says why it ends.
            let _ = shown.wait_for(|shown| shown.over.is_some()).await;
            tokio::time::sleep(FAREWELL).await;
        }
        None => std::future::pending().await,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fault_201_a_panel_answers_on_loopback_unless_one_address_is_asked_for() {
        let asked = |text: &str| asked(Some(text.into()));
        assert!(super::asked(None).is_ok_and(|address| address.ip().is_loopback()));
        assert!(asked("192.0.2.1:7411").is_ok_and(|address| address.port() == 7411));
        for (text, said) in
            [("0.0.0.0:7411", "all networks"), ("[::]:7411", "all networks"), ("7411", "is no address")]
        {
            let why = asked(text).expect_err("refused").to_string();
            assert!(why.contains(said) && why.contains(text), "{why}");
        }
    }
}
