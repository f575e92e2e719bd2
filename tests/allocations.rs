//! On the warm path from request to reply the planner allocates nothing.
//!
//! The bus itself does: iceoryx2 0.10 counts references to each request that is taken and
//! to each part that is loaned in a cell of the heap, 2 small allocations for a reply of
//! one part. These are all; the tests would show one more.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::time::Instant;

use answer::{StopFlag, Workspace};
use bus::{Client, Incoming, Server, ServerOptions, Wait};
use integration_tests::{LONG, TestDomain, scene};
use schemas::message::{Choice, ClearanceWish, Gap, SceneRequest, Solid, Task};

thread_local! {
    /// How many allocations this thread made while it was watched; none when it is not.
    static ALLOCATIONS: Cell<Option<u64>> = const { Cell::new(None) };
}

/// The system's allocator; counts what it is asked for.
struct Counting;

#[global_allocator]
static COUNTING: Counting = Counting;

fn count() {
    // Threads that are ending have no count any more.
    let _ = ALLOCATIONS.try_with(|count| count.set(count.get().map(|count| count + 1)));
}

#[expect(unsafe_code, reason = "an allocator is unsafe by its nature")]
// SAFETY: everything is passed on to the system's allocator as it comes.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as above.
        unsafe { System.realloc(memory, layout, size) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(memory, layout) }
    }
}

/// How many allocations `work` makes in this thread.
fn allocations(work: impl FnOnce()) -> u64 {
    ALLOCATIONS.set(Some(0));
    work();
    ALLOCATIONS.take().expect("it was watched")
}

/// Takes, plans and answers the request that waits, as the service does.
fn serve(server: &mut Server, cells: &mut Vec<u64>, workspace: &mut Workspace) -> Incoming {
    let mut incoming = server.receive().expect("a request waits");
    let header = incoming.copy(usize::MAX, cells).expect("it is there");
    let stop = StopFlag::new();
    let sent = workspace.answer(&header, cells, &stop, &mut incoming.reply());
    sent.expect("the client is there");
    incoming
}

/// iceoryx2's allocations for a request that is taken (`port/server.rs`,
/// `create_active_request`).
const FOR_A_REQUEST: u64 = 1;

/// iceoryx2's allocations for a part of a reply that is loaned
/// (`port/details/chunk_mut_shared_state.rs`), whether there is room for it or not.
const FOR_A_PART: u64 = 1;

/// Parts of a reply that find room before its client takes any.
const ROOM: u64 = 4;

/// After a few requests of these kinds the next ones allocate nothing beside what the bus
/// does.
#[track_caller]
fn check_warm(scenes: &[SceneRequest]) {
    for how in [Wait::Poll, Wait::Hybrid] {
        check_client(how, scenes);
    }
}

#[track_caller]
fn check_client(how: Wait, scenes: &[SceneRequest]) {
    let test = TestDomain::new();
    let options = ServerOptions { wait: Wait::Poll, ..ServerOptions::default() };
    let mut server = Server::open(&test.domain(), &options).unwrap();
    let client = Client::connect(&test.domain(), how).unwrap();
    let (mut cells, mut workspace) = (Vec::new(), Workspace::default());
    // How many allocations there are beside the bus's.
    let mut round = || -> i64 {
        let exchange = |scene| {
            let mut pending = client.send(scene).unwrap();
            let mut serving = None;
            let made = allocations(|| {
                serving = Some(serve(&mut server, &mut cells, &mut workspace));
            });
            let mut incoming = serving.expect("it was served");
            let mut parts = 0;
            loop {
                let part = pending.wait_part(Instant::now() + LONG).unwrap();
                assert!(part.content.is_ok(), "{:?}", part.content);
                parts += 1;
                if part.last {
                    break;
                }
                // Those that found no room.
                incoming.flush().unwrap();
            }
            // Of those that find no room, only the first is tried for certain.
            let (least, most) = (FOR_A_PART * parts.min(ROOM + 1), FOR_A_PART * parts);
            let beside = (made - FOR_A_REQUEST) as i64;
            beside - beside.clamp(least as i64, most as i64)
        };
        scenes.iter().map(exchange).sum()
    };
    let cold: i64 = (0..3).map(|_| round()).sum();
    assert!(cold > 0, "else nothing is counted");
    let warm: Vec<_> = (0..50).map(|_| round()).collect();
    assert_eq!(warm, [0; 50], "the client's way: {how:?}");
}

fn wish(clearance: ClearanceWish) -> SceneRequest {
    SceneRequest { clearance, ..scene("disassemble-channels.json") }
}

#[test]
fn channels_and_one_gap() {
    check_warm(&[wish(ClearanceWish::Gap(Gap::Uniform(0.2)))]);
    check_warm(&[wish(ClearanceWish::Gap(Gap::PerAxis([0.1, 0.2].into())))]);
    check_warm(&[wish(ClearanceWish::Safest)]);
}

#[test]
fn channels_and_several_gaps() {
    let each = [Choice::Gap(Gap::Uniform(0.01)), Choice::Gap(Gap::Uniform(0.2)), Choice::Safest];
    check_warm(&[wish(ClearanceWish::Each(each.to_vec()))]);
    // More parts than find room at once.
    check_warm(&[wish(ClearanceWish::Curve(7))]);
}

#[test]
fn solids_for_walls() {
    check_warm(&[scene("disassemble.json")]);
    check_warm(&[scene("assemble.json")]);
}

#[test]
fn several_exits() {
    use schemas::message::Direction::{MinusZ, PlusZ};
    let one = wish(ClearanceWish::Safest);
    check_warm(&[SceneRequest { exit: vec![PlusZ], ..one.clone() }]);
    check_warm(&[SceneRequest { exit: vec![PlusZ, MinusZ], ..one }]);
}

#[test]
fn free_spaces_by_turns() {
    let part = wish(ClearanceWish::Safest);
    let mut taller = part.clone();
    taller.free_space.channels.as_mut().unwrap()[2].max = [5.0, 8.0].into();
    let scenes = [part, taller];
    check_warm(&scenes);
    check_warm(&scenes.map(|mut scene| {
        scene.free_space.in_order = false;
        scene
    }));

    let part = scene("disassemble.json");
    let mut thicker = part.clone();
    let solids = thicker.free_space.solids.as_mut().unwrap();
    let Solid::Polygon(points) = &mut solids[0] else { panic!("section 4 has a polygon") };
    points[0] = [-1.0, -1.0].into();
    check_warm(&[part, thicker]);
}

#[test]
fn robots_in_corridors() {
    check_warm(&[scene("drive-a.json")]);
    check_warm(&[scene("drive-b.json")]);
}

#[test]
fn section_4_both_ways_by_turns() {
    let (out, back) = (scene("disassemble.json"), scene("assemble.json"));
    assert_ne!(out.task, Task::Assemble);
    check_warm(&[out, back]);
}
