use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::*;
use crate::test_domain::{TestRoot, test_domain};

/// The files of a member's domain in shared memory.
fn in_memory(member: &Member) -> Vec<String> {
    member.stay.site.in_memory()
}

#[test]
fn the_longest_name_can_be_joined_and_rung_in() {
    let root = TestRoot::new();
    let domain = Domain::new(&"x".repeat(64)).unwrap().under(root.path());
    let member = domain.join("test").unwrap();
    let bell = crate::ports::create_wake(&member, &crate::ServerOptions::default()).unwrap();
    bell.listener_builder().create().unwrap();
}

#[test]
fn the_last_to_leave_leaves_nothing() {
    let root = TestRoot::new();
    let [first, second] = ["a", "b"].map(|name| Domain::new(name).unwrap().under(root.path()));
    let (one, another, other) =
        (first.join("test").unwrap(), first.join("test").unwrap(), second.join("test").unwrap());
    let site = one.stay.site.clone();
    assert_eq!(in_memory(&one), in_memory(&another));
    assert_eq!(in_memory(&one).len(), 1);
    drop(one);
    assert_eq!(in_memory(&another).len(), 1, "somebody is there");
    drop(another);
    assert_eq!(site.in_memory(), [""; 0]);
    assert!(!site.directory().exists());
    assert_eq!(in_memory(&other).len(), 1);
    drop(other);
    assert_eq!(std::fs::read_dir(root.path()).unwrap().count(), 0);
}

#[test]
fn equal_names_under_other_directories_are_other_domains() {
    let (here, there) = (TestRoot::new(), TestRoot::new());
    let [here, there] = [&here, &there].map(|root| Domain::new("same").unwrap().under(root.path()));
    let (here, there) = (here.join("test").unwrap(), there.join("test").unwrap());
    assert_ne!(in_memory(&here), in_memory(&there));
}

#[test]
fn others_can_open_nothing() {
    let root = TestRoot::new();
    let domain = Domain::new("modes").unwrap().under(root.path());
    let member = domain.join("test").unwrap();
    let bell = crate::ports::create_wake(&member, &crate::ServerOptions::default()).unwrap();
    let _listener = bell.listener_builder().create().unwrap();
    let names = in_memory(&member);
    assert_eq!(names.len(), 3, "iceoryx2 takes the counter that is there: {names:?}");
    let mode = |path: PathBuf| std::fs::metadata(path).unwrap().mode() & 0o077;
    for name in names {
        assert_eq!(mode(Path::new("/dev/shm").join(&name)), 0, "{name}");
    }
    assert_eq!(mode(root.path().to_owned()), 0);
}

#[test]
fn who_comes_while_the_last_one_leaves_can_join() {
    let root = TestRoot::new();
    std::thread::scope(|threads| {
        for name in ["a", "b", "b"] {
            let domain = Domain::new(name).unwrap().under(root.path());
            threads.spawn(move || {
                for _ in 0..50 {
                    drop(domain.join("test").unwrap());
                }
            });
        }
    });
    assert_eq!(std::fs::read_dir(root.path()).unwrap().count(), 0);
}

#[test]
fn a_damaged_file_is_named() {
    let root = TestRoot::new();
    std::fs::write(root.path().join("a.toml"), "prefix = \"cw_../../..\"\n").unwrap();
    let failed = Domain::new("a").unwrap().under(root.path()).join("test").unwrap_err();
    assert!(failed.to_string().contains("its file a.toml is damaged"), "{failed}");
}

#[test]
fn nobody_is_swept_away_who_shows_no_presence() {
    let domain = test_domain();
    let config = domain.join("test").unwrap().stay.site.config();
    assert!(!Path::new(&config.global.root_path().to_string()).exists());
    let member = domain.join("test").unwrap();
    let config = member.stay.site.config();
    let bare = NodeBuilder::new().config(&config).create::<ipc::Service>().unwrap();
    drop(member);
    // The domain still stands, as iceoryx2 has a lock for it.
    let again = domain.join("test").unwrap();
    assert_eq!(again.stay.site.config(), config);
    drop(bare);
}

#[test]
fn a_sweep_with_nothing_to_do_is_cheap() {
    let root = TestRoot::new();
    let domain = Domain::new("busy").unwrap().under(root.path());
    let members: Vec<_> = (0..8).map(|_| domain.join("test").unwrap()).collect();
    let time = |sweep: &dyn Fn()| {
        let begin = std::time::Instant::now();
        sweep();
        begin.elapsed()
    };
    // The machine may be busy, but not all the time.
    let least = (0..200).map(|_| time(&|| members[0].sweep())).min().unwrap();
    println!("a sweep among {} takes {least:?}", members.len());
    assert!(least < Duration::from_micros(100), "{least:?}");
}

#[test]
fn what_removes_old_files_leaves_a_domain_alone() {
    let root = TestRoot::new();
    let member = Domain::new("old").unwrap().under(root.path()).join("test").unwrap();
    let directory = File::open(member.stay.site.directory()).unwrap();
    let lock = rustix::fs::FlockOperation::NonBlockingLockExclusive;
    assert!(rustix::fs::flock(&directory, lock).is_err(), "it is locked");
    let file = File::open(root.path().join("old.toml")).unwrap();
    file.set_modified(std::time::UNIX_EPOCH).unwrap();
    member.sweep();
    let age = file.metadata().unwrap().modified().unwrap().elapsed().unwrap();
    assert!(age < Duration::from_secs(60), "{age:?}");
}
