//! Joining a domain, and leaving it.

use std::fs::File;
use std::ops::Deref;
use std::path::PathBuf;
use std::time::Duration;

use iceoryx2::prelude::{Node, NodeBuilder, NodeName, SignalHandlingMode, ipc};
use iceoryx2::service::Service;

use crate::cause::Cause;
use crate::domain::{Domain, DomainError};
use crate::janitor;
use crate::log;
use crate::memory::{self, Shortage};
use crate::presence::Presence;
use crate::root::{Root, RootError};
use crate::site::Site;
use crate::wait;

/// How long a program waits until others have joined or left.
const PATIENCE: Duration = Duration::from_secs(10);

/// How long it waits for that when it has ended already.
const LEAVING: Duration = Duration::from_secs(1);

/// This program as a member of a domain. Dropping it leaves the domain; whoever leaves last
/// removes all its files.
#[derive(Debug)]
pub(crate) struct Member<S: Service = ipc::Service> {
    // Dropped in this order.
    node: Node<S>,
    stay: Stay,
}

#[derive(Debug)]
struct Stay {
    domain: Domain,
    role: &'static str,
    site: Site,
    presence: Option<Presence>,
    _kept: File,
}

impl<S: Service> Member<S> {
    /// The directory of the domain.
    pub(crate) fn directory(&self) -> PathBuf {
        self.stay.site.directory()
    }

    /// Clears away programs that died in the domain, if there are any and no planner does it.
    /// Cheap if there are none.
    pub(crate) fn sweep(&self) {
        self.sweep_after(|| {});
    }

    /// The same; `before` is called when it is known who died, before they are taken out.
    pub(crate) fn sweep_after(&self, before: impl FnOnce()) {
        let Stay { domain, role, site, .. } = &self.stay;
        site.renew();
        janitor::sweep(domain.chosen_root(), site, role, before);
    }

    /// Takes all memory of the files that this process has made in the domain.
    pub(crate) fn take_memory(&self) -> Result<(), Shortage> {
        memory::take_files(&self.stay.site.in_memory(), janitor::is_mine)
    }

    /// The domain that it is in.
    pub(crate) fn domain(&self) -> &Domain {
        &self.stay.domain
    }

    /// The numbers of the ports at both ends of each connection of the domain: who sends, and who
    /// receives.
    pub(crate) fn connections(&self) -> impl Iterator<Item = (u128, u128)> {
        let names = self.stay.site.in_memory().into_iter();
        names.filter(|name| name.ends_with(".connection")).filter_map(|name| {
            let mut numbers = janitor::numbers(&name);
            Some((numbers.next()?, numbers.next()?))
        })
    }

    /// Takes all memory of the files that a port of this number has made.
    pub(crate) fn take_memory_of(&self, port: u128) -> Result<(), Shortage> {
        let wanted = |name: &str| janitor::numbers(name).any(|number| number == port);
        memory::take_files(&self.stay.site.in_memory(), wanted)
    }
}

impl<S: Service> Deref for Member<S> {
    type Target = Node<S>;

    fn deref(&self) -> &Self::Target {
        &self.node
    }
}

impl Drop for Stay {
    fn drop(&mut self) {
        drop(self.presence.take());
        self.domain.tidy();
    }
}

impl Domain {
    /// Joins this domain as `role`, after clearing away what died in it.
    pub(crate) fn join(&self, role: &'static str) -> Result<Member, DomainError> {
        self.join_with(role)
    }

    /// The same with ports of another kind.
    pub(crate) fn join_with<S: Service>(
        &self,
        role: &'static str,
    ) -> Result<Member<S>, DomainError> {
        log::forward_to_tracing();
        let failed = |cause: String| DomainError::Join { domain: self.clone(), cause };
        wait::handle_signals().map_err(failed)?;
        let stay = self.stay(role)?;
        let node = NodeBuilder::new()
            .name(&NodeName::new(role).expect("roles are short"))
            .config(&stay.site.config())
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<S>()
            .map_err(|error| failed(Cause::from(error).to_string()))?;
        Ok(Member { node, stay })
    }

    /// Shows in this domain that the program lives. It is made if nobody is there.
    fn stay(&self, role: &'static str) -> Result<Stay, DomainError> {
        let root = Root::lock(self.chosen_root(), true, PATIENCE)?;
        let root = root.expect("it was made if it was missing");
        let failed = |problem| RootError { path: root.path().to_owned(), problem };
        let mut site = Site::find(root.path(), self.name()).map_err(failed)?;
        if let Some(left) = site.take_if(|site| janitor::is_deserted(site)) {
            // Others have seen the names of its files; the next have new ones.
            left.remove();
        }
        let site = match site {
            Some(site) => {
                site.furnish().map_err(|error| failed(error.into()))?;
                if janitor::is_up_to(role, &site) {
                    janitor::clear(&site, || {});
                }
                site
            }
            None => Site::create(root.path(), self.name()).map_err(failed)?,
        };
        let presence = Presence::show(&site, role).map_err(|error| failed(error.into()))?;
        let kept = site.keep().map_err(|error| failed(error.into()))?;
        Ok(Stay { domain: self.clone(), role, site, presence: Some(presence), _kept: kept })
    }

    /// Whether anybody has died in this domain and is not cleared away.
    pub(crate) fn has_dead(&self) -> bool {
        self.site().is_some_and(|site| janitor::has_dead(&site))
    }

    /// Whether a planner has died in this domain and is not cleared away.
    pub(crate) fn has_dead_planner(&self) -> bool {
        self.site().is_some_and(|site| janitor::has_dead_planner(&site))
    }

    /// Its files, if it is there.
    fn site(&self) -> Option<Site> {
        let root = self.root().ok()?;
        Site::find(&root, self.name()).ok().flatten()
    }

    /// Removes what is left of this domain if nobody lives in it.
    pub fn tidy(&self) {
        let Ok(Some(root)) = Root::lock(self.chosen_root(), false, LEAVING) else { return };
        if let Ok(Some(site)) = Site::find(root.path(), self.name())
            && janitor::is_deserted(&site)
        {
            site.remove();
        }
        root.remove_if_empty();
    }
}

#[cfg(test)]
mod tests;
