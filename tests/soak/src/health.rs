//! What the planner takes while it has nothing to do.

use std::path::Path;

use integration_tests::TestDomain;

/// What a serving process and its domain take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Health {
    /// The process.
    pub(crate) process: u32,
    /// Its open files, sockets and the like.
    pub(crate) descriptors: u64,
    pub(crate) threads: u64,
    /// Memory that it shares with nobody, bytes.
    pub(crate) memory: u64,
    /// Files of the domain, in memory and on disk.
    pub(crate) files: u64,
    /// What those in memory can take, bytes: which part of it is in use changes all the time.
    pub(crate) shared: u64,
}

/// By how much a process may grow: its allocator keeps what it had at the busiest moment, bytes.
const SLACK: u64 = 256 << 20;

impl Health {
    pub(crate) fn of(test: &TestDomain, process: u32) -> std::io::Result<Self> {
        let directory = format!("/proc/{process}");
        let directory = Path::new(&directory);
        let count = |name: &str| Ok::<_, std::io::Error>(directory.join(name).read_dir()?.count());
        let status = std::fs::read_to_string(directory.join("status"))?;
        let memory = status.lines().find_map(|line| line.strip_prefix("RssAnon:"));
        let memory =
            memory.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
        let files = test.left();
        let in_memory = files.iter().filter(|path| path.starts_with("/dev/shm"));
        // One may go while they are counted.
        let bytes = in_memory.filter_map(|path| Some(path.metadata().ok()?.len()));
        Ok(Self {
            process,
            descriptors: count("fd")? as u64,
            threads: count("task")? as u64,
            memory: memory.unwrap_or_default() << 10,
            files: files.len() as u64,
            shared: bytes.sum(),
        })
    }

    /// What it takes more than before.
    pub(crate) fn growth(&self, before: &Self) -> Vec<String> {
        let Self { process, descriptors, threads, memory, files, shared } = *self;
        let mut all = vec![("files of the domain", files, before.files, 0)];
        if process == before.process {
            all.extend([
                ("descriptors", descriptors, before.descriptors, 0),
                ("threads", threads, before.threads, 0),
                ("bytes of its own", memory, before.memory, SLACK),
                ("bytes of shared memory", shared, before.shared, 0),
            ]);
        }
        let grown = all.into_iter().filter(|(_, now, before, slack)| *now > before + slack);
        grown.map(|(what, now, before, _)| format!("{now} {what}, before {before}")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_noticed() {
        let before =
            Health { process: 1, descriptors: 9, threads: 4, memory: 0, files: 30, shared: 0 };
        assert!(before.growth(&before).is_empty());
        assert_eq!(Health { descriptors: 10, ..before }.growth(&before).len(), 1);
        assert_eq!(Health { memory: SLACK + 1, files: 31, ..before }.growth(&before).len(), 2);
        // Another process starts with its own.
        assert!(Health { process: 2, descriptors: 10, ..before }.growth(&before).is_empty());
    }
}
