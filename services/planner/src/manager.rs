//! What the planner tells a service manager such as systemd (`sd_notify`): that it is ready, that
//! it ends, and that it is not stuck. Without one, nothing is said.

use std::time::{Duration, Instant};

use bus::Domain;
use sd_notify::NotifyState;

/// The service manager, as the process that serves sees it.
#[derive(Debug)]
pub(crate) struct Manager {
    /// How often it wants to hear that the service is not stuck.
    watchdog: Option<Duration>,
    told: Instant,
}

impl Manager {
    /// Tells it that the planner serves a domain.
    pub(crate) fn ready(domain: &Domain) -> Self {
        let status = format!("serving domain {domain}");
        tell(&[NotifyState::Ready, NotifyState::Status(&status)]);
        // Half of the time leaves room for a late one.
        let watchdog = sd_notify::watchdog_enabled().map(|limit| limit / 2);
        Self { watchdog, told: Instant::now() }
    }

    /// Tells it now and then that the loop which serves goes round.
    pub(crate) fn is_alive(&mut self) {
        if self.watchdog.is_some_and(|often| self.told.elapsed() >= often) {
            tell(&[NotifyState::Watchdog]);
            self.told = Instant::now();
        }
    }
}

/// Tells it that the planner has been asked to end.
pub(crate) fn stopping() {
    tell(&[NotifyState::Stopping, NotifyState::Status("ending")]);
}

/// Tells it that the process which serves has died.
pub(crate) fn restarting(cause: &str) {
    tell(&[NotifyState::Status(&format!("starting again after {cause}"))]);
}

fn tell(states: &[NotifyState]) {
    if let Err(error) = sd_notify::notify(states) {
        tracing::warn!(%error, "can't tell the service manager (NOTIFY_SOCKET)");
    }
}
