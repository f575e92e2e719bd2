//! What a planner says of itself: a JSON object on the topic [`STATUS`](crate::topic::STATUS).

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// The planner's state, and what it has done since it started.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Its version.
    pub version: String,
    /// Its process.
    pub pid: u32,
    /// Seconds since it started.
    pub uptime: f64,
    /// Requests taken.
    pub requests: u64,
    /// Requests whose reply its client has taken or can take, refusals included.
    pub answered: u64,
    /// Requests whose client left, died, dropped them or did not take the reply.
    pub undelivered: u64,
    /// Refusals by their code; a request with several answers can have several.
    pub refused: BTreeMap<String, u64>,
    /// What waits for a worker.
    pub queue: QueueStatus,
    /// What is being planned.
    pub workers: WorkerStatus,
    /// Bytes of replies that their clients have not taken yet.
    pub unsent: u64,
    /// What is kept of earlier requests.
    pub cache: CacheStatus,
    /// From taking a request to the last part of its reply, microseconds.
    pub latency: Latency,
    /// The planner's settings, `caps` among them; null where it is of an earlier version.
    #[serde(default)]
    pub config: Value,
}

/// The requests that wait for a worker.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct QueueStatus {
    /// How many.
    pub requests: u64,
    /// The most there may be.
    pub most: u64,
    /// Their size.
    pub bytes: u64,
}

/// The workers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct WorkerStatus {
    /// How many plan at a time.
    pub count: u64,
    /// Requests that have begun; more than `count` where long ones take turns.
    pub planning: u64,
}

/// The cache.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct CacheStatus {
    /// Look-ups that found what they looked for.
    pub hits: u64,
    /// Look-ups that had to make it.
    pub misses: u64,
    /// Entries.
    pub entries: u64,
    /// Their memory.
    pub bytes: u64,
}

/// A distribution of times, microseconds, two digits each.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Latency {
    /// How many there are.
    pub count: u64,
    /// All of them together.
    pub sum: f64,
    /// Half took no longer.
    pub p50: f64,
    /// 90 % took no longer.
    pub p90: f64,
    /// 99 % took no longer.
    pub p99: f64,
    /// 99.9 % took no longer.
    pub p999: f64,
    /// The longest.
    pub max: f64,
}

impl Status {
    /// As JSON, on one line.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("names and numbers")
    }

    /// Reads JSON; fields of later versions are ignored.
    ///
    /// # Errors
    ///
    /// If it is no such object.
    pub fn from_json(text: &str) -> Result<Self, serde_json::Error> {
        serde_json::from_str(text)
    }

    /// The JSON Schema of it, for viewers: the names and kinds of its fields.
    pub fn schema() -> String {
        let mut example = serde_json::to_value(Self::default()).expect("names and numbers");
        // What a default does not show.
        example["config"] = json!({});
        let mut schema = schema_of(&example);
        schema["title"] = json!("Clearway planner status");
        schema["properties"]["refused"]["additionalProperties"] = json!({"type": "integer"});
        schema.to_string()
    }

    /// In Prometheus's text format.
    pub fn to_prometheus(&self) -> String {
        use std::fmt::Write;
        let Self {
            version,
            pid: _,
            uptime,
            requests,
            answered,
            undelivered,
            refused,
            queue,
            workers,
            unsent,
            cache,
            latency,
            config: _,
        } = self;
        let mut text = String::new();
        let mut metric = |name: &str, kind: &str, help: &str, values: &[(String, f64)]| {
            let _ = writeln!(text, "# HELP clearway_{name} {help}\n# TYPE clearway_{name} {kind}");
            for (labels, value) in values {
                let _ = writeln!(text, "clearway_{name}{labels} {value}");
            }
        };
        let one = |value: f64| [(String::new(), value)];
        let label = format!("{{version={version:?}}}");
        metric("info", "gauge", "The planner's version.", &[(label, 1.0)]);
        metric("uptime_seconds", "gauge", "Time since the start.", &one(*uptime));
        metric("requests_total", "counter", "Requests taken.", &one(*requests as f64));
        metric("answered_total", "counter", "Requests answered.", &one(*answered as f64));
        let help = "Requests whose client left or did not take the reply.";
        metric("undelivered_total", "counter", help, &one(*undelivered as f64));
        let by_code: Vec<_> = refused
            .iter()
            .map(|(code, count)| (format!("{{code={code:?}}}"), *count as f64))
            .collect();
        metric("refused_total", "counter", "Refusals by code.", &by_code);
        let help = "Requests that wait for a worker.";
        metric("queue_requests", "gauge", help, &one(queue.requests as f64));
        metric("queue_bytes", "gauge", "Their size.", &one(queue.bytes as f64));
        metric("queue_most", "gauge", "The most that may wait.", &one(queue.most as f64));
        metric("workers", "gauge", "Workers.", &one(workers.count as f64));
        let help = "Requests being planned.";
        metric("planning_requests", "gauge", help, &one(workers.planning as f64));
        metric("unsent_bytes", "gauge", "Replies not taken yet.", &one(*unsent as f64));
        metric("cache_hits_total", "counter", "Look-ups that found it.", &one(cache.hits as f64));
        let help = "Look-ups that had to make it.";
        metric("cache_misses_total", "counter", help, &one(cache.misses as f64));
        metric("cache_entries", "gauge", "Entries of the cache.", &one(cache.entries as f64));
        metric("cache_bytes", "gauge", "Memory of the cache.", &one(cache.bytes as f64));
        let seconds = |micros: f64| micros / 1e6;
        let quantiles = [
            ("0.5", latency.p50),
            ("0.9", latency.p90),
            ("0.99", latency.p99),
            ("0.999", latency.p999),
        ]
        .map(|(quantile, value)| (format!("{{quantile={quantile:?}}}"), seconds(value)));
        let help = "From taking a request to the last part of its reply.";
        metric("latency_seconds", "summary", help, &quantiles);
        let _ = writeln!(
            text,
            "clearway_latency_seconds_sum {}\nclearway_latency_seconds_count {}",
            seconds(latency.sum),
            latency.count
        );
        text
    }
}

/// The JSON Schema of values like this one.
fn schema_of(example: &Value) -> Value {
    let kind = match example {
        Value::Object(fields) => {
            let properties: serde_json::Map<_, _> =
                fields.iter().map(|(name, value)| (name.clone(), schema_of(value))).collect();
            return json!({"type": "object", "properties": properties});
        }
        Value::Number(number) if number.is_u64() => "integer",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Bool(_) => "boolean",
        Value::Array(_) => "array",
        Value::Null => "null",
    };
    json!({"type": kind})
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status() -> Status {
        Status {
            version: "1.2.3".into(),
            pid: 7,
            uptime: 2.5,
            requests: 5,
            refused: BTreeMap::from([("no_route".to_owned(), 2)]),
            latency: Latency { count: 5, sum: 50.0, p50: 8.0, ..Latency::default() },
            ..Status::default()
        }
    }

    #[test]
    fn json_is_read_back() {
        let text = status().to_json();
        assert_eq!(Status::from_json(&text).unwrap(), status());
        let newer = text.replacen('{', "{\"colour\":1,", 1);
        assert_eq!(Status::from_json(&newer).unwrap(), status());
        assert!(Status::from_json("{}").is_err());
    }

    #[test]
    fn the_schema_has_every_field() {
        let schema: Value = serde_json::from_str(&Status::schema()).unwrap();
        let fields = serde_json::to_value(status()).unwrap();
        for (name, _) in fields.as_object().unwrap() {
            assert!(schema["properties"][name]["type"].is_string(), "{name}");
        }
        assert_eq!(schema["properties"]["latency"]["properties"]["p50"]["type"], "number");
        assert_eq!(schema["properties"]["queue"]["properties"]["most"]["type"], "integer");
    }

    #[test]
    fn prometheus_gets_a_line_for_each_value() {
        let text = status().to_prometheus();
        for line in [
            "clearway_info{version=\"1.2.3\"} 1",
            "clearway_uptime_seconds 2.5",
            "clearway_requests_total 5",
            "clearway_refused_total{code=\"no_route\"} 2",
            "clearway_latency_seconds{quantile=\"0.5\"} 0.000008",
            "clearway_latency_seconds_sum 0.00005",
            "clearway_latency_seconds_count 5",
        ] {
            assert!(text.lines().any(|other| other == line), "{line} in {text}");
        }
        // Every metric is explained once.
        let names: Vec<_> = text.lines().filter(|line| line.starts_with("# HELP")).collect();
        assert_eq!(names.len(), text.matches("# TYPE").count());
    }
}
