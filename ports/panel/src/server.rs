//! What answers browsers: on the loopback interface, or on a network by TLS.
//!
//! In: connections. Out: the files of the page, and a [`socket`](crate::socket) for each page that connects. No request changes
//! anything in the cell: that is for messages of a page that has shown the token.

use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::extract::{Request, State, WebSocketUpgrade};
use axum::http::{Method, Response, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::IntoResponse;
use axum::routing::get;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpListener;
use tokio::sync::Semaphore;
use tokio::time::timeout;

use crate::driver::{Panel, Place};
use crate::page;
use crate::rules::door::Way;
use crate::rules::{CONNECTIONS, LONGEST};
use crate::secured::Secured;
use crate::socket;

/// How long a browser may take to say what it wants.
const HEADER: Duration = Duration::from_secs(5);

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
    places: Arc<Semaphore>,
}

impl Connections {
    /// Of this panel; there are none yet.
    pub fn of(panel: Arc<Panel>) -> Connections {
        let router = Router::new()
            .route("/connect", get(connect))
            .fallback(|request: Request| async move { page::file(request.uri().path()) })
            .layer(from_fn_with_state(Arc::clone(&panel), admit))
            .with_state(panel);
        Connections { router, places: Arc::new(Semaphore::new(CONNECTIONS)) }
    }

    /// Answers a connection once keys are agreed on. One too many is closed at once, and who does not agree on keys in time is told nothing.
    pub fn take<S: AsyncRead + AsyncWrite + Unpin + Send + 'static>(
        &self,
        agreed: impl Future<Output = std::io::Result<S>> + Send + 'static,
    ) {
        let Ok(place) = Arc::clone(&self.places).try_acquire_owned() else { return };
        let router = self.router.clone();
        tokio::spawn(async move {
            if let Ok(Ok(stream)) = timeout(HEADER, agreed).await {
                answer(stream, router).await;
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
    let Some(key) = panel.update(|pages, _| pages.connect()) else {
        return page::told(StatusCode::SERVICE_UNAVAILABLE, "too many pages look on: close one of them");
    };
    let place = Place { panel, key };
    let upgrade = upgrade.max_message_size(LONGEST).max_frame_size(LONGEST).write_buffer_size(0);
    upgrade.on_upgrade(move |socket| socket::serve(socket, place)).into_response()
}
