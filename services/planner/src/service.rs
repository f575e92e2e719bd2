//! The service loop: take a request, answer it, wait.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

use answer::{CacheStats, StopFlag, Workspace};
use bus::{Incoming, ReplyOptions, Server, ServerOptions, Wait, Woken};
use configuration::{Config, WaitFor};
use schemas::message::{ErrorCode, Refusal};
use schemas::wire::{RequestHeader, given};

use crate::watchdog::Watchdog;

/// After this many requests without a pause the loop looks for signals.
const WITHOUT_PAUSE: u32 = 64;

/// The memory of requests that are not larger than this is used again, cells.
const KEPT_CELLS: usize = 1 << 17;

/// What a planner has done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Served {
    /// Requests taken.
    pub requests: u64,
    /// Replies that their client did not take, or that had no client any more.
    pub undelivered: u64,
    /// What the cache did since the last defect, if there was one.
    pub cache: CacheStats,
}

/// Serves until a signal asks it to end.
pub fn serve(server: &mut Server, config: &Config) -> Served {
    let workspace = new_workspace(config);
    let mut memory = Memory {
        config,
        cells: Vec::new(),
        workspace,
        stop: Arc::default(),
        watchdog: Watchdog::start(bus::terminated),
    };
    let mut served = Served::default();
    loop {
        let mut without_pause = 0;
        while without_pause < WITHOUT_PAUSE
            && let Some(incoming) = server.receive()
        {
            memory.serve(incoming, &mut served);
            without_pause += 1;
        }
        let pressed = without_pause == WITHOUT_PAUSE;
        if (pressed && server.terminated()) || server.wait() == Woken::Terminate {
            return Served { cache: memory.workspace.cache_stats(), ..served };
        }
    }
}

fn new_workspace(config: &Config) -> Workspace {
    Workspace::new(config.caps, config.cache)
}

struct Memory<'a> {
    config: &'a Config,
    cells: Vec<u64>,
    workspace: Workspace,
    /// Of the request in hand, and of the next as long as it is not set.
    stop: Arc<StopFlag>,
    watchdog: Watchdog,
}

/// When a request that has just arrived is to be answered. What is no possible deadline is
/// refused when the request is read.
fn deadline(header: &RequestHeader) -> Option<Instant> {
    if header.given & given::DEADLINE == 0 {
        return None;
    }
    let left = Duration::try_from_secs_f64(header.deadline).ok().filter(|left| !left.is_zero())?;
    Instant::now().checked_add(left)
}

impl Memory<'_> {
    fn serve(&mut self, mut incoming: Incoming, served: &mut Served) {
        served.requests += 1;
        let cells = incoming.cells();
        // Don't even copy what is too large.
        let readable = self.config.caps.check_cells(cells);
        let header = match readable {
            Ok(()) => incoming.copy(&mut self.cells),
            Err(_) => incoming.header(),
        };
        let (mut sink, client) = incoming.reply_to_client();
        let sent = if let Err(refusal) = readable {
            Workspace::refuse(&header, &refusal, &mut sink)
        } else {
            if self.stop.reason().is_some() {
                self.stop = Arc::default();
            }
            let Self { workspace, cells, stop, watchdog, .. } = self;
            let answered = watchdog.watch(stop, deadline(&header), |stop| {
                // A defect in planning must not take the service with it.
                catch_unwind(AssertUnwindSafe(|| {
                    let is_wanted = || client.is_waiting();
                    workspace.answer_while(&header, cells, (stop, &is_wanted), &mut sink)
                }))
            });
            answered.unwrap_or_else(|_| {
                self.workspace = new_workspace(self.config);
                let message = "internal error while planning this request; please report it \
                               (other requests are served)";
                let refusal = Refusal::new(ErrorCode::Internal, message);
                Workspace::refuse(&header, &refusal, &mut sink)
            })
        };
        self.cells.clear();
        self.cells.shrink_to(KEPT_CELLS);
        match sent {
            Ok(()) => tracing::debug!(
                client = header.client,
                sequence = header.sequence,
                cells,
                cache = ?self.workspace.cache_stats(),
                "answered"
            ),
            Err(error) => {
                served.undelivered += 1;
                tracing::warn!(
                    client = header.client,
                    sequence = header.sequence,
                    ?error,
                    "the client did not take its reply"
                );
            }
        }
    }
}

/// The bus's part of the configuration.
pub fn server_options(config: &Config) -> ServerOptions {
    ServerOptions {
        max_clients: config.max_clients,
        requests_per_client: config.requests_per_client,
        max_recorders: config.max_recorders,
        tap_buffer: config.tap_buffer,
        wait: match config.wait {
            WaitFor::Event => Wait::Event,
            WaitFor::Hybrid => Wait::Hybrid,
            WaitFor::Poll => Wait::Poll,
        },
        reply: ReplyOptions { patience: Duration::from_secs_f64(config.patience) },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_of_the_configuration_are_those_of_the_bus() {
        assert_eq!(server_options(&Config::default()), ServerOptions::default());
    }
}
