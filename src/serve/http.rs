//! Who carries requests and answers between a browser and the [`Site`]: HTTP on 127.0.0.1 alone.
//!
//! Every address begins with a token that only who started it has seen.

use std::io::Read;
use std::path::Path;

use anyhow::{Context, Result, anyhow};
use serde_json::json;
use tiny_http::{Header, Request, Response};

use super::{Answer, Refusal, Site, refuse};
use crate::cli::Global;

/// Largest body of a request, bytes.
const BODY_MAX: usize = 64 << 20;
/// Bytes of the token.
const TOKEN: usize = 16;

/// The server.
pub struct Server {
    http: tiny_http::Server,
    site: Site,
    token: String,
    host: String,
}

impl Server {
    /// One for the files of a folder, at a port or at any that is free (0).
    ///
    /// # Errors
    /// A folder that is not there, a port that is taken.
    pub fn bind(folder: &Path, port: u16, global: &Global) -> Result<Self> {
        let site = Site::new(folder, global)?;
        let http = tiny_http::Server::http(("127.0.0.1", port));
        let http = http.map_err(|cause| anyhow!("127.0.0.1:{port}: {cause}"))?;
        let mut bytes = [0; TOKEN];
        getrandom::fill(&mut bytes).context("no random token")?;
        let address = http.server_addr().to_ip().context("no address")?;
        Ok(Self {
            http,
            token: bytes.iter().map(|byte| format!("{byte:02x}")).collect(),
            host: format!("127.0.0.1:{}", address.port()),
            site,
        })
    }

    /// Where a browser finds it.
    pub fn address(&self) -> String {
        format!("http://{}/{}/", self.host, self.token)
    }

    /// Answers requests, one after the other.
    pub fn run(&self) {
        for mut request in self.http.incoming_requests() {
            let answer = self.answer(&mut request);
            if let Err(Refusal(code, why)) = &answer {
                tracing::info!("{} {}: {code} {why}", request.method(), request.url());
            }
            // A browser that has gone away needs no answer.
            let _ = request.respond(response(answer));
        }
    }

    fn answer(&self, request: &mut Request) -> Result<Answer, Refusal> {
        let host = request.headers().iter().find(|h| h.field.equiv("Host"));
        // A name of somebody else's that leads here is not asked for by a page of ours.
        if host.is_none_or(|host| host.value.as_str() != self.host) {
            return refuse(403, format!("only http://{} is served", self.host));
        }
        let url = request.url().to_owned();
        let path = url.strip_prefix('/').unwrap_or_default();
        let (token, path) = path.split_once('/').unwrap_or((path, ""));
        if token != self.token {
            return refuse(
                403,
                "the address has no valid token: take it from the terminal",
            );
        }
        let method = request.method().to_string();
        self.site.answer(&method, path, || body(request))
    }
}

fn body(request: &mut Request) -> Result<Vec<u8>, Refusal> {
    let mut bytes = Vec::new();
    let most = BODY_MAX as u64 + 1;
    let read = request.as_reader().take(most).read_to_end(&mut bytes);
    read.map_err(|cause| Refusal(400, format!("the body cannot be read: {cause}")))?;
    match bytes.len() > BODY_MAX {
        true => refuse(413, format!("the body has more than {BODY_MAX} bytes")),
        false => Ok(bytes),
    }
}

fn response(answer: Result<Answer, Refusal>) -> Response<std::io::Cursor<Vec<u8>>> {
    let (code, kind, text) = match answer {
        Ok(Answer::Page(html)) => (200, "text/html; charset=utf-8", html),
        Ok(Answer::Data(data)) => (200, "application/json", data.to_string()),
        Err(Refusal(code, why)) => (
            code,
            "application/json",
            json!({ "error": why }).to_string(),
        ),
    };
    let headers = [
        ("Content-Type", kind),
        ("Cache-Control", "no-store"),
        ("Referrer-Policy", "no-referrer"),
        ("X-Content-Type-Options", "nosniff"),
        ("X-Frame-Options", "DENY"),
    ];
    let response = Response::from_string(text).with_status_code(code);
    let header = |(name, value): &(&str, &str)| Header::from_bytes(*name, *value).ok();
    headers
        .iter()
        .filter_map(header)
        .fold(response, Response::with_header)
}
