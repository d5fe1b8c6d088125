//! The files of the page, and what a browser is told beside them.
//!
//! In: a path. Out: a file that was built from `web/` and is part of this program, so that nothing is fetched from anywhere else.

use axum::body::Body;
use axum::http::{Response, StatusCode, header};

/// What the page may do: run its own script, and connect to its own panel.
const POLICY: &str =
    "default-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; object-src 'none'";

const FILES: [(&str, &str, &[u8]); 5] = [
    ("/", "text/html; charset=utf-8", include_bytes!("../web/dist/index.html")),
    ("/panel.js", "text/javascript; charset=utf-8", include_bytes!("../web/dist/panel.js")),
    ("/panel.css", "text/css; charset=utf-8", include_bytes!("../web/dist/panel.css")),
    ("/icon.svg", "image/svg+xml", include_bytes!("../web/dist/icon.svg")),
    ("/notices.txt", "text/plain; charset=utf-8", include_bytes!("../web/dist/notices.txt")),
];

/// The file at a path.
pub fn file(path: &str) -> Response<Body> {
    match FILES.iter().find(|(at, ..)| *at == path) {
        Some((_, kind, bytes)) => answer(StatusCode::OK, kind, Body::from(*bytes)),
        None => told(StatusCode::NOT_FOUND, "the panel has no such file"),
    }
}

/// A refusal, in words.
pub fn told(status: StatusCode, why: &str) -> Response<Body> {
    answer(status, "text/plain; charset=utf-8", Body::from(format!("{why}\n")))
}

fn answer(status: StatusCode, kind: &str, body: Body) -> Response<Body> {
    let answer = Response::builder()
        .status(status)
        .header(header::CONTENT_TYPE, kind)
        .header(header::CONTENT_SECURITY_POLICY, POLICY)
        .header(header::X_CONTENT_TYPE_OPTIONS, "nosniff")
        .header(header::REFERRER_POLICY, "no-referrer")
        .header("cross-origin-resource-policy", "same-origin")
        .header("cross-origin-opener-policy", "same-origin")
        .header(header::CACHE_CONTROL, "no-store")
        .body(body);
    // All of it is constant and valid.
    answer.unwrap_or_default()
}
