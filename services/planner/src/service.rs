//! The service loop: take a request, answer it, wait.

use std::panic::{AssertUnwindSafe, catch_unwind};

use bus::{Incoming, Server, Woken};
use schemas::message::{ErrorCode, Refusal};

use crate::Workspace;

/// The largest request that is looked at, in cells of 8 bytes: 512 MiB.
const MOST_CELLS: usize = 64 << 20;

/// After this many requests without a pause the loop looks for signals.
const WITHOUT_PAUSE: u32 = 64;

/// What a planner has done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Served {
    /// Requests taken.
    pub requests: u64,
    /// Replies that did not reach their client, because it had left or did not take them.
    pub undelivered: u64,
}

/// Serves until SIGINT or SIGTERM.
pub fn serve(server: &mut Server) -> Served {
    let mut memory = Memory::default();
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
            return served;
        }
    }
}

#[derive(Default)]
struct Memory {
    cells: Vec<u64>,
    workspace: Workspace,
}

impl Memory {
    fn serve(&mut self, mut incoming: Incoming, served: &mut Served) {
        served.requests += 1;
        let cells = incoming.cells();
        let header = match cells <= MOST_CELLS {
            true => incoming.copy(&mut self.cells),
            false => incoming.header(),
        };
        let mut sink = incoming.reply();
        let sent = if cells > MOST_CELLS {
            Workspace::refuse(&header, &too_large(cells), &mut sink)
        } else {
            // A defect in planning must not take the service with it.
            let answered = catch_unwind(AssertUnwindSafe(|| {
                self.workspace.answer(&header, &self.cells, &mut sink)
            }));
            answered.unwrap_or_else(|_| {
                self.workspace = Workspace::default();
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

fn too_large(cells: usize) -> Refusal {
    let message = format!("the request has {cells} cells of memory, at most {MOST_CELLS} are read");
    let refusal = Refusal::invalid("request", message);
    Refusal { needs: Some(cells as f64), has: Some(MOST_CELLS as f64), ..refusal }
}
