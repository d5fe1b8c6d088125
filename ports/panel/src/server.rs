//! What answers browsers: on the loopback interface, or on a network by TLS.
//!
//! In: connections. Out: the files of the page, and a [`socket`](crate::socket) for each page that connects. No request changes
//! anything in the cell: that is for messages of a page that has shown the token.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use axum::Router;
use axum::body::Body;
use axum::extract::ws::Utf8Bytes;
use axum::extract::{Request, State, WebSocketUpgrade};
use axum::http::{Method, Response, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::IntoResponse;
use axum::routing::get;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use mrroc_core::console::complain;
use serde_json::json;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, broadcast, watch};
use tokio::time::timeout;

use crate::course::Course;
use crate::desk::{Desk, Shown};
use crate::now::Looks;
use crate::page;
use crate::poses::{Pose, Poses};
use crate::rules::door::{Door, Way};
use crate::rules::token::Token;
use crate::rules::{CONNECTIONS, LONGEST, PAGES};
use crate::secured::Secured;
use crate::socket;
use crate::stand::Stand;

/// How long a browser may take to say what it wants.
const HEADER: Duration = Duration::from_secs(5);

/// Notes that wait for a page.
const NOTES: usize = 32;

/// What a panel shows.
pub enum Source {
    /// A cell that runs: where to ask, and what it does.
    Running(Desk, watch::Receiver<Shown>),
    /// A run that is over.
    Over(Box<Course>),
}

/// All that pages share.
pub struct Panel {
    pub source: Source,
    pub looks: Arc<Looks>,
    pub token: Token,
    pub stand: Stand,
    /// Sentences for all pages.
    pub notes: broadcast::Sender<Arc<str>>,
    /// The poses that robots were taught, and what pages are told of them.
    pub poses: Option<Poses>,
    pub taught: watch::Sender<Option<Utf8Bytes>>,
    /// Places of pages.
    pub pages: Arc<Semaphore>,
    /// Places of pages whose requests wait for files.
    pub files: Arc<Semaphore>,
    door: Door,
    numbers: AtomicU64,
    /// The time since the panel began.
    clock: Box<dyn Fn() -> Duration + Send + Sync>,
}

/// Requests of pages that may wait for files.
const FILES: usize = 16;

impl Panel {
    /// Of a source, at an address, known by a token.
    #[must_use]
    pub fn new(source: Source, looks: Arc<Looks>, token: Token, address: SocketAddr) -> Panel {
        let since = Instant::now();
        Panel {
            source,
            looks,
            token,
            stand: Stand::default(),
            notes: broadcast::channel(NOTES).0,
            poses: None,
            taught: watch::Sender::default(),
            pages: Arc::new(Semaphore::new(PAGES)),
            files: Arc::new(Semaphore::new(FILES)),
            door: Door::at(address),
            numbers: AtomicU64::new(0),
            clock: Box::new(move || since.elapsed()),
        }
    }

    /// The same by the clock of a test.
    #[cfg(test)]
    pub fn by_clock(self, clock: impl Fn() -> Duration + Send + Sync + 'static) -> Panel {
        Panel { clock: Box::new(clock), ..self }
    }

    /// How its pages are reached: `http://`, or `https://` on a network.
    pub fn scheme(&self) -> &'static str {
        self.door.scheme()
    }

    /// The same, which teaches poses beside the file of the cell.
    #[must_use]
    pub fn teaching(mut self, cell: &Path) -> Panel {
        self.poses = Some(Poses::of(cell));
        self.tell_taught();
        self
    }

    /// Tells all pages which poses robots were taught, as the files say, which may take their time.
    pub fn tell_taught(&self) {
        let Some(poses) = &self.poses else { return };
        let of = |robot: &str| match poses.of_robot(robot) {
            Ok(poses) => {
                let pose = |pose: &Pose| json!({"name": pose.name.as_str(), "joints": pose.joints});
                json!({"poses": poses.iter().map(pose).collect::<Vec<_>>()})
            }
            Err(why) => json!({"poses": [], "why": why}),
        };
        let robots: serde_json::Map<_, _> =
            self.looks.robots().map(|robot| (robot.to_owned(), of(robot))).collect();
        let text = json!({"kind": "poses", "robots": robots}).to_string();
        self.taught.send_replace(Some(text.into()));
    }

    /// The number of a new page.
    pub fn number(&self) -> u64 {
        self.numbers.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// The time since the panel began.
    pub fn now(&self) -> Duration {
        (self.clock)()
    }

    /// Tells all pages and the terminal what happened.
    pub fn note(&self, text: &str) {
        complain(&format!("panel: {text}"));
        // Nobody may be there.
        let _ = self.notes.send(text.into());
    }
}

/// Serves a panel until this future is dropped; `secured` on a network.
///
/// # Errors
/// No connection can be taken any more.
pub async fn serve(
    listener: TcpListener,
    panel: Arc<Panel>,
    secured: Option<Secured>,
) -> std::io::Result<()> {
    let router = Router::new()
        .route("/connect", get(connect))
        .fallback(|request: Request| async move { page::file(request.uri().path()) })
        .layer(from_fn_with_state(Arc::clone(&panel), admit))
        .with_state(panel);
    let places = Arc::new(Semaphore::new(CONNECTIONS));
    loop {
        let (stream, _) = match listener.accept().await {
            Ok(accepted) => accepted,
            // Too few files may be open: those that are there go on.
            Err(_) => {
                tokio::time::sleep(Duration::from_millis(100)).await;
                continue;
            }
        };
        // One too many is closed at once.
        let Ok(place) = Arc::clone(&places).try_acquire_owned() else { continue };
        let _ = stream.set_nodelay(true);
        let (router, secured) = (router.clone(), secured.clone());
        tokio::spawn(async move {
            match secured {
                None => answer(stream, router).await,
                Some(secured) => {
                    // Who does not agree on keys in time is told nothing.
                    if let Ok(Ok(stream)) = timeout(HEADER, secured.accept(stream)).await {
                        answer(stream, router).await;
                    }
                }
            }
            drop(place);
        });
    }
}

/// Answers what one connection asks for.
async fn answer(stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static, router: Router) {
    let mut connection = http1::Builder::new();
    connection.timer(TokioTimer::new()).header_read_timeout(HEADER).max_headers(64);
    let service = TowerToHyperService::new(router);
    // A browser that goes away is nobody's fault. The place of a page is kept by its socket from then on.
    let _ = connection.serve_connection(TokioIo::new(stream), service).with_upgrades().await;
}

/// Answers only what comes from this panel's own page.
async fn admit(State(panel): State<Arc<Panel>>, request: Request, next: Next) -> Response<Body> {
    let way = if request.uri().path() == "/connect" { Way::Connection } else { Way::File };
    if request.method() != Method::GET {
        return page::told(
            StatusCode::METHOD_NOT_ALLOWED,
            "the panel is only read; it is operated by its page",
        );
    }
    let admitted = {
        let header = |name| request.headers().get(name).and_then(|value| value.to_str().ok());
        panel.door.admit(way, header(header::HOST), header(header::ORIGIN))
    };
    match admitted {
        Ok(()) => next.run(request).await,
        Err(why) => page::told(StatusCode::FORBIDDEN, &why.to_string()),
    }
}

/// A page connects.
async fn connect(State(panel): State<Arc<Panel>>, upgrade: WebSocketUpgrade) -> Response<Body> {
    let Ok(place) = Arc::clone(&panel.pages).try_acquire_owned() else {
        return page::told(StatusCode::SERVICE_UNAVAILABLE, "too many pages look on: close one of them");
    };
    let upgrade = upgrade.max_message_size(LONGEST).max_frame_size(LONGEST).write_buffer_size(0);
    upgrade.on_upgrade(move |socket| socket::serve(socket, panel, place)).into_response()
}
