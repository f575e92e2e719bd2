//! The service loop: take a request, answer it, wait.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

use answer::{CacheStats, Workspace};
use bus::{Incoming, ReplyOptions, Server, ServerOptions, Wait, Woken};
use configuration::{Config, WaitFor};
use schemas::message::{ErrorCode, Refusal};

/// After this many requests without a pause the loop looks for signals.
const WITHOUT_PAUSE: u32 = 64;

/// What a planner has done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Served {
    /// Requests taken.
    pub requests: u64,
    /// Replies that did not reach their client, because it had left or did not take them.
    pub undelivered: u64,
    /// What the cache did; after a failure it begins anew.
    pub cache: CacheStats,
}

/// Serves until SIGINT or SIGTERM.
pub fn serve(server: &mut Server, config: &Config) -> Served {
    let workspace = workspace(config);
    let mut memory = Memory { config, cells: Vec::new(), workspace };
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

fn workspace(config: &Config) -> Workspace {
    Workspace::new(config.caps, config.cache)
}

struct Memory<'a> {
    config: &'a Config,
    cells: Vec<u64>,
    workspace: Workspace,
}

impl Memory<'_> {
    fn serve(&mut self, mut incoming: Incoming, served: &mut Served) {
        served.requests += 1;
        let cells = incoming.cells();
        // What is too large is not even copied.
        let readable = self.config.caps.check_cells(cells);
        let header = match readable {
            Ok(()) => incoming.copy(&mut self.cells),
            Err(_) => incoming.header(),
        };
        let mut sink = incoming.reply();
        let sent = if let Err(refusal) = readable {
            Workspace::refuse(&header, &refusal, &mut sink)
        } else {
            // A defect in planning must not take the service with it.
            let answered = catch_unwind(AssertUnwindSafe(|| {
                self.workspace.answer(&header, &self.cells, &mut sink)
            }));
            answered.unwrap_or_else(|_| {
                self.workspace = workspace(self.config);
                let refusal =
                    Refusal::new(ErrorCode::Internal, "the planner failed at this request");
                Workspace::refuse(&header, &refusal, &mut sink)
            })
        };
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
