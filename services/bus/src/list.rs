//! Who is in which domain.

use std::path::PathBuf;

use crate::domain::{Domain, DomainError};
use crate::presence::{self, Visitor};
use crate::root::{self, RootError};
use crate::site::Site;

/// A domain of this user, and who is in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DomainStatus {
    /// The domain.
    pub domain: Domain,
    /// Its planner, if there is one.
    pub planner: Option<PlannerStatus>,
    /// Clients that live.
    pub clients: usize,
    /// Recorders that live.
    pub recorders: usize,
    /// Where its small files and sockets are.
    pub directory: PathBuf,
    /// What the names of its files in `/dev/shm` begin with.
    pub prefix: String,
}

/// A domain's planner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlannerStatus {
    /// The number of its process.
    pub process: u32,
    /// Whether it lives: what one that died left behind stays until others come.
    pub lives: bool,
}

/// The domains under the directory of the environment in which somebody lives, or has died, in
/// the order of their names.
pub fn domains() -> Result<Vec<DomainStatus>, DomainError> {
    let (path, _) = root::find(None)?;
    let failed = |problem| RootError { path: path.clone(), problem };
    if root::open(&path, false).map_err(failed)?.is_none() {
        return Ok(Vec::new());
    }
    let sites = Site::all(&path).map_err(|error| failed(error.into()))?;
    Ok(sites.iter().filter_map(status).collect())
}

fn status(site: &Site) -> Option<DomainStatus> {
    let visitors: Vec<_> = presence::visitors(site).collect();
    let living = |role| visitors.iter().filter(move |found| found.lives && found.role == role);
    let planners = visitors.iter().filter(|found| found.role == Visitor::PLANNER);
    let planner = planners.max_by_key(|found| found.lives);
    let planner = planner.map(|found| PlannerStatus { process: found.process, lives: found.lives });
    let domain = Domain::new(site.name()).ok().filter(|_| !visitors.is_empty())?;
    Some(DomainStatus {
        domain,
        planner,
        clients: living(Visitor::CLIENT).count(),
        recorders: living(Visitor::RECORDER).count(),
        directory: site.directory(),
        prefix: site.prefix(),
    })
}
