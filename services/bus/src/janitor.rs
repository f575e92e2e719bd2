//! Clears away what died in a domain.
//!
//! iceoryx2 takes the dead out of its services and removes what it has registered. What it has
//! not registered yet, or no more, stays: the files of a program that was killed while it started
//! or ended. Their names tell the process that made them, and [`crate::presence`] whether it lives.

use std::collections::BTreeSet;
use std::fs::Metadata;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use iceoryx2::node::{DeadNodeView, NodeCleanupFailure, NodeState, NodeView};
use iceoryx2::prelude::{CallbackProgression, Node, ipc};

use crate::presence::{self, Visitor};
use crate::root::Root;
use crate::site::{self, MEMORY, Site};

/// How long a sweep waits for programs that start or end; the next one is soon.
const PATIENCE: Duration = Duration::from_millis(20);

/// Within a process, iceoryx2 clears away in one thread at a time.
static CLEARING: Mutex<()> = Mutex::new(());

/// Clears away what died, if anything has and it is up to `role`: else it costs about 3 µs for each
/// that lives. `before` is called when it is known who died.
pub(crate) fn sweep(chosen: Option<&Path>, site: &Site, role: &str, before: impl FnOnce()) {
    if is_up_to(role, site)
        && let Ok(Some(_root)) = Root::lock(chosen, false, PATIENCE)
        // A planner may have started meanwhile.
        && is_up_to(role, site)
    {
        clear(site, before);
    }
}

/// Whether there is something to clear away that nobody does better. Dead clients are up to the
/// planner as long as it lives: it takes their requests before, because iceoryx2 loses those whose
/// client is gone.
pub(crate) fn is_up_to(role: &str, site: &Site) -> bool {
    let (visitors, strangers) = members(site);
    let is_client = |visitor: &Visitor| visitor.role == Visitor::CLIENT;
    let dead: Vec<_> = visitors.iter().filter(|visitor| !visitor.lives).collect();
    let planner_lives =
        || visitors.iter().any(|visitor| visitor.lives && visitor.role == Visitor::PLANNER);
    match role {
        Visitor::PLANNER => strangers || !dead.is_empty(),
        _ if strangers || dead.iter().any(|visitor| is_client(visitor)) => !planner_lives(),
        _ => !dead.is_empty(),
    }
}

/// Whether anybody may have died in a domain.
pub(crate) fn has_dead(site: &Site) -> bool {
    let (visitors, strangers) = members(site);
    strangers || visitors.iter().any(|visitor| !visitor.lives)
}

/// Whether a planner has died in a domain.
pub(crate) fn has_dead_planner(site: &Site) -> bool {
    let is_dead = |visitor: Visitor| visitor.role == Visitor::PLANNER && !visitor.lives;
    presence::visitors(site).any(is_dead)
}

/// Our programs in a domain, and whether there may be others: they show no presence, so that only
/// iceoryx2 knows of them.
fn members(site: &Site) -> (Vec<Visitor>, bool) {
    let visitors: Vec<_> = presence::visitors(site).collect();
    let nodes = site::names(&site.nodes()).filter(|name| name.ends_with(".node_monitor")).count();
    let strangers = nodes > visitors.len();
    (visitors, strangers)
}

/// Whether nobody lives in a domain. Asked under the lock of the root, it stays true.
pub(crate) fn is_deserted(site: &Site) -> bool {
    if presence::visitors(site).any(|visitor| visitor.lives) {
        return false;
    }
    // Others than our programs show no presence, but iceoryx2 has a lock for each.
    let mut alive = false;
    let listed = Node::<ipc::Service>::list(&site.config(), |node| {
        alive = matches!(node, NodeState::Alive(_) | NodeState::Inaccessible(_));
        if alive { CallbackProgression::Stop } else { CallbackProgression::Continue }
    });
    listed.is_ok() && !alive
}

/// Clears away what died, under the lock of the root: nobody joins meanwhile. `before` is called
/// when it is known who died.
pub(crate) fn clear(site: &Site, before: impl FnOnce()) {
    let _alone = CLEARING.lock().unwrap_or_else(PoisonError::into_inner);
    let visitors: Vec<_> = presence::visitors(site).collect();
    let mut living = presence::living(&visitors);
    let Some(dead) = dead_nodes(site, &mut living) else { return };
    before();
    remove_half_made(site, &living);
    if !dead.into_iter().all(|node| take_out(site, node)) {
        return;
    }
    remove_strays(&site.nodes(), &site.prefix(), &living, |_| true);
    remove_strays(&site.directory(), &site.prefix(), &living, |_| true);
    let services = remove_services(site, &living);
    remove_strays(Path::new(MEMORY), &site.prefix(), &living, |name| {
        // A service outlives who made it.
        !name.ends_with(".dynamic") || services.as_ref().is_some_and(|kept| !kept.contains(name))
    });
    site.close_to_others();
    // Last: their files say that there is something to do.
    visitors.iter().filter(|visitor| !visitor.lives).for_each(Visitor::forget);
}

/// The dead that iceoryx2 knows, if it can say; those that it knows to live are added to `living`.
fn dead_nodes(site: &Site, living: &mut BTreeSet<u32>) -> Option<Vec<DeadNodeView<ipc::Service>>> {
    let mut dead = Vec::new();
    let listed = Node::<ipc::Service>::list(&site.config(), |node| {
        match node {
            NodeState::Alive(node) => living.extend(process(node.id().value())),
            NodeState::Inaccessible(id) => living.extend(process(id.value())),
            // Without its details, iceoryx2 would look for its files elsewhere. They were
            // removed last, or are not there yet: it is in no service.
            NodeState::Dead(node) if node.details().is_some() => dead.push(node),
            NodeState::Dead(_) | NodeState::Undefined(_) => {}
        }
        CallbackProgression::Continue
    });
    listed.is_ok().then_some(dead)
}

/// Removes memory that one of the dead was just making: iceoryx2 would wait for it for ever.
fn remove_half_made(site: &Site, living: &BTreeSet<u32>) {
    for name in site.in_memory().iter().filter(|name| !makers(name).is_subset(living)) {
        let path = Path::new(MEMORY).join(name);
        let is_half_made = |found: Metadata| found.len() == 0 || found.mode() & 0o400 == 0;
        if std::fs::symlink_metadata(&path).is_ok_and(is_half_made) {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Has iceoryx2 take a dead node out of the services. False asks for another try.
fn take_out(site: &Site, node: DeadNodeView<ipc::Service>) -> bool {
    match node.try_remove_stale_resources() {
        Err(NodeCleanupFailure::Interrupt) => return false,
        // Another janitor was killed at it, or a service that was never finished stands in
        // the way: then the files go.
        Err(error) => tracing::debug!(domain = site.name(), ?error, "a dead program is left"),
        Ok(()) => {}
    }
    true
}

/// Removes what the dead made: files, sockets and directories whose names have numbers of
/// theirs only.
fn remove_strays(
    directory: &Path,
    prefix: &str,
    living: &BTreeSet<u32>,
    may_go: impl Fn(&str) -> bool,
) {
    for name in site::names(directory) {
        let makers = makers(name.strip_prefix(prefix).unwrap_or(&name));
        let is_ours = name.starts_with(prefix) || directory != Path::new(MEMORY);
        if is_ours && !makers.is_empty() && makers.is_disjoint(living) && may_go(&name) {
            let path = directory.join(&name);
            let _ = std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir_all(&path));
        }
    }
}

/// Removes services that no living node has. The names of the files in memory of the others, if
/// they are known.
fn remove_services(site: &Site, living: &BTreeSet<u32>) -> Option<BTreeSet<String>> {
    let directory = site.directory().join("services");
    // In this order: who makes a service marks it as used before.
    let found: Vec<_> = site::names(&directory).collect();
    let mut used = BTreeSet::new();
    let nodes = site.nodes();
    for node in site::names(&nodes).filter(|name| !makers(name).is_disjoint(living)) {
        used.extend(
            site::names(&nodes.join(node))
                .filter_map(|name| Some(name.strip_suffix("_tag")?.to_owned())),
        );
    }
    for unused in found.iter().filter(|name| !used.contains(*name)) {
        let _ = std::fs::remove_file(directory.join(unused));
    }
    let kept: Option<BTreeSet<_>> = found
        .iter()
        .filter(|name| used.contains(*name))
        .map(|name| number_of(&std::fs::read_to_string(directory.join(name)).ok()?))
        .collect();
    let kept = kept?;
    let names = site.in_memory().into_iter();
    Some(names.filter(|name| numbers(name).any(|number| kept.contains(&number))).collect())
}

/// The number of a service, which the names of its files in memory have, from its settings in
/// iceoryx2's file. (iceoryx2 itself looks at every node for every service that it lists.)
fn number_of(settings: &str) -> Option<u128> {
    let (_, number) = settings.split_once("[unique_service_id]")?;
    let part = |name| {
        let value = number.lines().find_map(|line| line.strip_prefix(name))?;
        value.trim().strip_prefix('=')?.trim().parse::<u64>().ok()
    };
    Some(u128::from(part("unique_value")?) << 64 | u128::from(part("payload_value")?))
}

/// Whether this process is one of those that made a file.
pub(crate) fn is_mine(name: &str) -> bool {
    makers(name).contains(&presence::host())
}

/// The processes whose numbers a file's name has.
fn makers(name: &str) -> BTreeSet<u32> {
    numbers(name).filter_map(process).collect()
}

/// The numbers in the name of a file of iceoryx2, before its first dot.
pub(crate) fn numbers(name: &str) -> impl Iterator<Item = u128> {
    let stem = name.split('.').next().unwrap_or_default();
    stem.split('_')
        .filter(|part| part.bytes().all(|c| c.is_ascii_digit()))
        .filter_map(|part| part.parse().ok())
}

/// The process in a number of iceoryx2: from its lowest bits on, seconds, nanoseconds, process and
/// count, 32 bits each.
fn process(number: u128) -> Option<u32> {
    let process = (number >> 64) as u32;
    (process != 0).then_some(process)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::Server;
    use crate::test_domain::TestRoot;
    use crate::{Domain, ServerOptions};

    #[test]
    fn files_of_services_that_are_used_are_known() {
        let root = TestRoot::new();
        let domain = Domain::new("used").unwrap().under(root.path());
        let _server = Server::open(&domain, &ServerOptions::default()).unwrap();
        let site = Site::find(root.path(), "used").unwrap().unwrap();
        let services = site.directory().join("services");
        let numbers_of_services: BTreeSet<_> = site::names(&services)
            .map(|name| number_of(&std::fs::read_to_string(services.join(name)).unwrap()).unwrap())
            .collect();
        let files = site.in_memory();
        let dynamic: BTreeSet<_> = files
            .iter()
            .filter(|name| name.ends_with(".dynamic"))
            .flat_map(|name| numbers(name))
            .collect();
        assert!(dynamic.len() > 4);
        assert_eq!(dynamic, numbers_of_services);
        let living = BTreeSet::from([std::process::id()]);
        let kept = remove_services(&site, &living).unwrap();
        assert!(
            files.iter().filter(|name| name.ends_with(".dynamic")).all(|name| kept.contains(name))
        );
        // Nobody uses them.
        assert_eq!(remove_services(&site, &BTreeSet::new()), Some(BTreeSet::new()));
        assert_eq!(site::names(&services).count(), 0);
    }
}
