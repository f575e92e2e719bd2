//! The running planner of a domain.

use std::time::Duration;

use bus::{CallError, Client, ConnectError, Domain, Wait};
use comparison::compare::depends_on_load;
use program::{Diagnostics, LogFormat};
use schemas::message::{Reply, Request, RequestContent, SceneRequest};

use crate::arguments::Bus;

/// From now on signals set a flag instead of ending the process, so that nothing is left in shared
/// memory.
pub(crate) fn begin() {
    program::start_diagnostics(Diagnostics::Warnings, LogFormat::Text);
    bus::forward_to_tracing();
}

/// A client of the planner that the arguments name.
pub(crate) fn connect(arguments: &Bus) -> Result<Client, ConnectError> {
    let domain: Domain = arguments.domain.clone().unwrap_or_default();
    Client::connect_within(&domain, Wait::Hybrid, arguments.wait)
}

/// Asks the planner. What can't be sent is refused as the planner would.
pub(crate) fn ask(
    client: &Client,
    scene: &SceneRequest,
    limit: Duration,
) -> Result<Reply, CallError> {
    match client.call(scene, limit) {
        Err(CallError::Scene(refusal)) => {
            let (key, id) = (Default::default(), scene.id);
            Ok(Reply { key, id, answers: Err(refusal) })
        }
        done => done,
    }
}

/// The planner's reply under the request's own key, or why there is none to compare.
pub(crate) fn reply_to(
    client: &Client,
    request: &Request,
    limit: Duration,
) -> Result<Reply, String> {
    let RequestContent::Scene(scene) = &request.content else {
        return Err("it is not a scene and can't be sent".to_owned());
    };
    let reply = ask(client, scene, limit).map_err(|error| error.to_string())?;
    let refusals = || match &reply.answers {
        Err(refusal) => vec![refusal],
        Ok(answers) => answers.iter().filter_map(|answer| answer.as_ref().err()).collect(),
    };
    match refusals().into_iter().find(|refusal| depends_on_load(refusal)) {
        Some(refusal) => Err(format!("the planner had no time: {}", refusal.message)),
        None => Ok(Reply { key: request.key, ..reply }),
    }
}
