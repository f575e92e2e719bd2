//! Why a client or recorder finds no planner.

use iceoryx2::prelude::{Node, PortFactory};
use iceoryx2::service::Service;
use schemas::wire::{self, previous};

use crate::cause::Cause;
use crate::domain::Domain;
use crate::error::ConnectError;
use crate::headers::{Current, Version};
use crate::ports;
use crate::previous::Previous;

/// What is opened.
pub(crate) const REQUESTS: &str = "the planner's service";
pub(crate) const TAP: &str = "the planner's tap";
pub(crate) const STATUS: &str = "the planner's status";

/// Who takes a place, and the planner's setting for how many there are.
pub(crate) type Place = (&'static str, &'static str);
pub(crate) const CLIENTS: Place = ("clients", "max_clients");
pub(crate) const RECORDERS: Place = ("recorders", "max_recorders");
pub(crate) const WATCHERS: Place = ("readers of the status", "not a setting");

pub(crate) fn full(domain: &Domain, (who, setting): Place, most: usize) -> ConnectError {
    ConnectError::Full { domain: domain.clone(), who, most, setting }
}

/// Why `what` of the current version could not be opened.
pub(crate) fn failed<S: Service>(
    node: &Node<S>,
    domain: &Domain,
    what: &'static str,
    cause: Cause,
) -> ConnectError {
    let domain = domain.clone();
    match cause {
        // A planner that starts, stops or was killed leaves its service in any of these.
        Cause::Absent | Cause::InFlux | Cause::Damaged => {
            // One that was just starting has opened the current version first, meanwhile. One that
            // is just leaving or being cleared away has lost the one before the other, and is gone
            // the next time, or is known to have died.
            let is_older = || serves::<Previous, S>(node) && !serves::<Current, S>(node);
            match is_older() && !domain.has_dead_planner() && is_older() {
                true => ConnectError::OlderPlanner { domain, planner: previous::VERSION },
                false => ConnectError::NoPlanner { domain },
            }
        }
        Cause::OtherMessages => ConnectError::OtherLayout { domain, layout: wire::layout_hash() },
        cause => ConnectError::Service { what, domain, cause },
    }
}

/// Whether a planner serves a version.
fn serves<V: Version, S: Service>(node: &Node<S>) -> bool {
    ports::open_plan::<V, S>(node).is_ok_and(|plan| plan.dynamic_config().number_of_servers() > 0)
}
