//! Text or JSON on stderr.

use std::str::FromStr;
use std::sync::OnceLock;

/// What diagnostics look like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LogFormat {
    /// Lines for people.
    #[default]
    Text,
    /// A JSON object on each line.
    Json,
}

impl FromStr for LogFormat {
    type Err = &'static str;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "text" => Ok(Self::Text),
            "json" => Ok(Self::Json),
            _ => Err("it is either text or json"),
        }
    }
}

static FORMAT: OnceLock<LogFormat> = OnceLock::new();

/// Chooses it once and for all; the first choice counts.
pub(crate) fn choose(format: LogFormat) -> LogFormat {
    *FORMAT.get_or_init(|| format)
}

/// Whether everything on stderr has to be JSON.
pub(crate) fn are_json() -> bool {
    FORMAT.get() == Some(&LogFormat::Json)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_have_names() {
        assert_eq!(("text".parse(), "json".parse()), (Ok(LogFormat::Text), Ok(LogFormat::Json)));
        assert!("JSON".parse::<LogFormat>().is_err());
    }
}
