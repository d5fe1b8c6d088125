//! What answers browsers: on the loopback interface, or on a network by TLS.
//!
//! In: connections. Out: the files of the page, and a [`socket`](crate::socket) for each page that connects. No request changes
//! anything in the cell: that is for messages of a page that has shown the token.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::extract::{Request, State, WebSocketUpgrade};
use axum::http::header::GetAll;
use axum::http::{HeaderValue, Method, Response, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::IntoResponse;
use axum::routing::get;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpListener;
use tokio::task::AbortHandle;
use tokio::time::timeout;

use crate::driver::{Panel, Place};
use crate::page;
use crate::rules::origin::{NotAdmitted, RequestTarget};
use crate::rules::{CONNECTIONS, LONGEST};
use crate::secured::Secured;
use crate::socket;

/// How long a browser may take to say what it wants.
const HEADER: Duration = Duration::from_secs(5);

/// How long files are asked for, and answered, over one connection: browsers open another one then.
const FILES: Duration = Duration::from_secs(30);

/// Serves a panel until this future is dropped; `secured` on a network.
///
/// # Errors
/// No connection can be taken any more.
pub async fn serve(
    listener: TcpListener,
    panel: Arc<Panel>,
    secured: Option<Secured>,
) -> std::io::Result<()> {
    let connections = Connections::of(panel);
    loop {
        let (stream, _) = match listener.accept().await {
            Ok(accepted) => accepted,
            // Too few files may be open: those that are there go on.
            Err(_) => {
                tokio::time::sleep(Duration::from_millis(100)).await;
                continue;
            }
        };
        let _ = stream.set_nodelay(true);
        match secured.clone() {
            None => connections.take(async { Ok(stream) }),
            Some(secured) => connections.take(async move { secured.accept(stream).await }),
        }
    }
}

/// The connections of a panel, whatever they go over.
pub struct Connections {
    router: Router,
    /// Those that files are asked over, or that are still to become a page's, the oldest one first.
    served: Mutex<VecDeque<AbortHandle>>,
}

impl Connections {
    /// Of this panel; there are none yet.
    pub fn of(panel: Arc<Panel>) -> Connections {
        let router = Router::new()
            .route("/connect", get(connect))
            .fallback(|request: Request| async move { page::file(request.uri().path()) })
            .layer(from_fn_with_state(Arc::clone(&panel), admit))
            .with_state(panel);
        Connections { router, served: Mutex::default() }
    }

    /// Answers a connection once keys are agreed on; who does not agree on keys in time is told nothing. Where there are too many, the
    /// oldest one is closed: a page that is opened is answered at once, and a crowd that keeps its places waits for nothing.
    pub fn take<S: AsyncRead + AsyncWrite + Unpin + Send + 'static>(
        &self,
        agreed: impl Future<Output = std::io::Result<S>> + Send + 'static,
    ) {
        let router = self.router.clone();
        let serving = tokio::spawn(async move {
            if let Ok(Ok(stream)) = timeout(HEADER, agreed).await {
                answer(stream, router).await;
            }
        });
        let mut served = self.served.lock().unwrap_or_else(PoisonError::into_inner);
        served.retain(|serving| !serving.is_finished());
        if served.len() >= CONNECTIONS
            && let Some(oldest) = served.pop_front()
        {
            oldest.abort();
        }
        served.push_back(serving.abort_handle());
    }
}

/// Answers what one connection asks for, until it is a page's, or for as long as that may take.
async fn answer(stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static, router: Router) {
    let mut connection = http1::Builder::new();
    connection.timer(TokioTimer::new()).header_read_timeout(HEADER).max_headers(64);
    let service = TowerToHyperService::new(router);
    // A browser that goes away is nobody's fault. The place of a page is kept by its socket from then on.
    let answered = connection.serve_connection(TokioIo::new(stream), service).with_upgrades();
    let _ = timeout(FILES, answered).await;
}

/// Answers only what comes from this panel's own page.
async fn admit(State(panel): State<Arc<Panel>>, request: Request, next: Next) -> Response<Body> {
    let target =
        if request.uri().path() == "/connect" { RequestTarget::Connection } else { RequestTarget::File };
    if request.uri().authority().is_some() {
        return page::told(StatusCode::BAD_REQUEST, "the panel is no proxy: ask for a path alone");
    }
    if request.method() != Method::GET {
        return page::told(
            StatusCode::METHOD_NOT_ALLOWED,
            "the panel is only read; it is operated by its page",
        );
    }
    let admitted = {
        let header = |name| said_once(request.headers().get_all(name));
        match (header(header::HOST), header(header::ORIGIN)) {
            (Ok(host), Ok(origin)) => panel.origins.admit(target, host, origin),
            (Err(Unclear), _) => Err(NotAdmitted::Host),
            (_, Err(Unclear)) => Err(NotAdmitted::Origin),
        }
    };
    match admitted {
        Ok(()) => next.run(request).await,
        Err(why) => page::told(StatusCode::FORBIDDEN, &why.to_string()),
    }
}

/// A header that is said more than once, or is no text.
struct Unclear;

/// What a header says; `None` where it is not there.
fn said_once(values: GetAll<'_, HeaderValue>) -> Result<Option<&str>, Unclear> {
    let mut values = values.into_iter();
    let first = values.next().map(|value| value.to_str().map_err(|_| Unclear)).transpose()?;
    values.next().map_or(Ok(first), |_| Err(Unclear))
}

/// A page connects.
async fn connect(State(panel): State<Arc<Panel>>, upgrade: WebSocketUpgrade) -> Response<Body> {
    let Some(key) = panel.update(|pages, _| pages.connect()) else {
        return page::told(StatusCode::SERVICE_UNAVAILABLE, "too many pages look on: close one of them");
    };
    let place = Place { panel, key };
    let upgrade = upgrade.max_message_size(LONGEST).max_frame_size(LONGEST).write_buffer_size(0);
    upgrade.on_upgrade(move |socket| socket::serve(socket, place)).into_response()
}
