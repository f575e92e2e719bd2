//! The status for Prometheus, over HTTP.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use schemas::status::Status;

/// How long a peer has to ask and to take the answer.
const PATIENCE: Duration = Duration::from_secs(2);

/// The longest question, bytes.
const MOST_BYTES: u64 = 8192;

/// What is served: the latest status.
#[derive(Debug, Clone, Default)]
pub(crate) struct Latest(Arc<Mutex<Status>>);

impl Latest {
    pub(crate) fn set(&self, status: Status) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = status;
    }

    fn text(&self) -> String {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).to_prometheus()
    }
}

/// Serves the latest status at this address until the process ends, one peer at a time.
///
/// # Errors
///
/// If the address can't be had.
pub(crate) fn serve(address: SocketAddr, latest: Latest) -> io::Result<()> {
    let listener = TcpListener::bind(address)?;
    tracing::info!(address = %listener.local_addr()?, "metrics at /metrics");
    thread::Builder::new().name("metrics".into()).spawn(move || {
        for stream in listener.incoming() {
            let answered = stream.and_then(|stream| answer(&stream, &latest));
            if let Err(error) = answered {
                tracing::debug!(%error, "a peer did not get its metrics");
            }
        }
    })?;
    Ok(())
}

fn answer(stream: &TcpStream, latest: &Latest) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let head = read_head(stream)?;
    let path = head.strip_prefix("GET ").and_then(|rest| rest.split_whitespace().next());
    let (status, text) = match path {
        Some("/metrics" | "/") => ("200 OK", latest.text()),
        Some(_) => ("404 Not Found", "metrics are at /metrics\n".to_owned()),
        None => ("405 Method Not Allowed", "GET only\n".to_owned()),
    };
    let length = text.len();
    let mut stream = stream;
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: text/plain; version=0.0.4\r\n\
         Content-Length: {length}\r\nConnection: close\r\n\r\n{text}"
    )
}

/// What a peer says up to the empty line.
fn read_head(stream: &TcpStream) -> io::Result<String> {
    let mut head = Vec::new();
    let mut stream = stream.take(MOST_BYTES);
    let mut buffer = [0; 1024];
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        match stream.read(&mut buffer)? {
            0 => break,
            count => head.extend_from_slice(&buffer[..count]),
        }
    }
    Ok(String::from_utf8_lossy(&head).into_owned())
}

/// Reads an address: `9464`, `:9464` (both on this machine only) or `0.0.0.0:9464`.
///
/// # Errors
///
/// If it is neither.
pub fn address(text: &str) -> Result<SocketAddr, String> {
    let port = text.strip_prefix(':').unwrap_or(text).parse();
    if let Ok(port) = port {
        return Ok(SocketAddr::from(([127, 0, 0, 1], port)));
    }
    text.parse().map_err(|_| format!("{text:?} is neither a port nor an address with a port"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_on_this_machine() {
        let local = SocketAddr::from(([127, 0, 0, 1], 9464));
        assert_eq!((address("9464"), address(":9464")), (Ok(local), Ok(local)));
        assert_eq!(address("[::1]:1").unwrap().to_string(), "[::1]:1");
        assert!(address("localhost").unwrap_err().contains("localhost"));
        assert!(address("99999").is_err());
    }
}
