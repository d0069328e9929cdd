//! Who is let in: only this computer's browser, at the address that was printed.
//!
//! - The address holds a random token of 128 bits. Another program's page does not know it.
//! - The header Host must name the loopback interface: a name of someone else's that leads here (DNS rebinding) is refused.
//! - The header Origin, where there is one, must be this server's, and `Sec-Fetch-Site` must not name another site.

use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};

use super::server::LARGEST_FILE;
use crate::error::Error;

/// Bytes of the token.
const LENGTH: usize = 16;

/// The token and the address.
#[derive(Debug, Clone)]
pub struct Guard {
    token: String,
    port: u16,
}

impl Guard {
    /// One with a new token for a port.
    ///
    /// # Errors
    /// A system without random numbers.
    pub fn new(port: u16) -> Result<Guard, Error> {
        let mut bytes = [0; LENGTH];
        getrandom::fill(&mut bytes).map_err(|e| Error::Internal {
            problem: format!("no random numbers: {e}"),
        })?;
        Ok(Guard {
            token: bytes.iter().map(|b| format!("{b:02x}")).collect(),
            port,
        })
    }

    /// The token.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// The page's address.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// Why a request is refused; `None` if it is let in.
    fn refusal(&self, path: &str, headers: &HeaderMap) -> Option<(StatusCode, &'static str)> {
        let text = |name: header::HeaderName| headers.get(name).map(HeaderValue::as_bytes);
        let hosts = [
            format!("127.0.0.1:{}", self.port),
            format!("localhost:{}", self.port),
        ];
        let is_host = |host: &[u8]| hosts.iter().any(|h| h.as_bytes() == host);
        if !text(header::HOST).is_some_and(is_host) {
            return Some((StatusCode::FORBIDDEN, "another host was asked for"));
        }
        let is_own = |origin: &[u8]| origin.strip_prefix(b"http://").is_some_and(is_host);
        if !text(header::ORIGIN).is_none_or(is_own) {
            return Some((StatusCode::FORBIDDEN, "another page asks"));
        }
        let site = headers.get("sec-fetch-site").map(HeaderValue::as_bytes);
        if !site.is_none_or(|site| site == b"same-origin" || site == b"none") {
            return Some((StatusCode::FORBIDDEN, "another page asks"));
        }
        let length = text(header::CONTENT_LENGTH).and_then(|l| std::str::from_utf8(l).ok());
        let length = length.and_then(|l| l.parse::<usize>().ok());
        if length.is_some_and(|length| length > LARGEST_FILE) {
            // Before a byte of it is read.
            return Some((StatusCode::PAYLOAD_TOO_LARGE, "too large"));
        }
        let token = path.trim_start_matches('/').split('/').next();
        if !token.is_some_and(|t| same(t.as_bytes(), self.token.as_bytes())) {
            return Some((
                StatusCode::NOT_FOUND,
                "not found; the address is printed where `stickslip studio` was started, and is new each time",
            ));
        }
        None
    }
}

/// Whether two texts are the same, in a time that does not tell where they differ.
fn same(a: &[u8], b: &[u8]) -> bool {
    let differences = a.iter().zip(b).fold(0, |sum, (x, y)| sum | (x ^ y));
    a.len() == b.len() && differences == 0
}

/// What the page may do: load from this server alone. Plotly writes styles into its elements.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; \
                      connect-src 'self'; frame-src 'none'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

/// Headers of every answer.
const HEADERS: [(header::HeaderName, &str); 5] = [
    (header::CONTENT_SECURITY_POLICY, POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
    (header::X_FRAME_OPTIONS, "DENY"),
];

/// Lets a request in or refuses it.
pub async fn check(State(guard): State<Guard>, request: Request, next: Next) -> Response {
    let refusal = guard.refusal(request.uri().path(), request.headers());
    let mut response = match refusal {
        Some((status, why)) => (status, Body::from(why)).into_response(),
        None => next.run(request).await,
    };
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers
            .entry(name)
            .or_insert(HeaderValue::from_static(value));
    }
    response
}
