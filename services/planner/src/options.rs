//! The bus's part of the configuration.

use std::time::Duration;

use bus::{ReplyOptions, ServerOptions, Wait};
use configuration::{Config, WaitFor};

/// What the bus is opened with.
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
        reserve: config.reserve,
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
