//! What a workspace keeps from one request to the next, counted by the allocator.

use std::alloc::{GlobalAlloc, Layout, System};
use std::convert::Infallible;
use std::sync::atomic::{AtomicUsize, Ordering};

use answer::{Caps, StopFlag, Workspace};
use schemas::convert::{CellWriter, PartSink, write_scene};
use schemas::json::read_scene;
use schemas::message::{
    AxisBox, Choice, ClearanceWish, FreeSpace, Gap, Goal, RequestKey, SceneRequest, Solid,
};
use schemas::wire::{PART_CELLS, ReplyHeader, RequestHeader};

/// Bytes allocated and not given back.
static LIVE: AtomicUsize = AtomicUsize::new(0);
/// The most of them at a time.
static PEAK: AtomicUsize = AtomicUsize::new(0);

struct Counting;

#[global_allocator]
static COUNTING: Counting = Counting;

fn grow(bytes: usize) {
    let live = LIVE.fetch_add(bytes, Ordering::Relaxed) + bytes;
    PEAK.fetch_max(live, Ordering::Relaxed);
}

#[expect(unsafe_code, reason = "an allocator is unsafe by its nature")]
// SAFETY: everything is passed on to the system's allocator as it comes.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grow(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        LIVE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(memory, layout) }
    }
}

struct Nowhere(Vec<u64>);

impl PartSink for Nowhere {
    type Error = Infallible;

    fn part(
        &mut self,
        _: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Infallible> {
        fill(&mut CellWriter::new(&mut self.0[..cells]));
        Ok(())
    }
}

fn request(scene: &SceneRequest) -> (RequestHeader, Vec<u64>) {
    let mut cells = Vec::new();
    (write_scene(scene, RequestKey::default(), 0, &mut cells).unwrap(), cells)
}

fn small() -> SceneRequest {
    read_scene(include_str!("../../../recordings/scenes/disassemble-solids.json")).unwrap()
}

/// Scenes that take much memory, each in its own way.
fn huge() -> Vec<SceneRequest> {
    let drive = read_scene(include_str!("../../../recordings/scenes/drive-a.json")).unwrap();
    let mut in_order = drive.clone();
    // Up, right, up, ...: every channel begins where the one before it ends.
    let channel = |index: i32| {
        let (x, y) = (f64::from(index / 2) * 10.0, f64::from((index + 1) / 2) * 10.0);
        let (long, wide) = (13.0, 3.0);
        let (width, height) = if index % 2 == 0 { (wide, long) } else { (long, wide) };
        AxisBox { min: [x, y].into(), max: [x + width, y + height].into() }
    };
    in_order.free_space.channels = Some((0..10_000).map(channel).collect());

    let mut crowded = drive.clone();
    let pillar = |index: i32| {
        let at = [f64::from(index % 70) * 3.0 + 4.0, f64::from(index / 70) * 3.0 + 4.0];
        Solid::Box(AxisBox { min: at.into(), max: at.map(|x| x + 1.0).into() })
    };
    crowded.free_space = FreeSpace {
        solids: Some((0..4_900).map(pillar).collect()),
        bounds: Some(AxisBox { min: [0.0, 0.0].into(), max: [220.0, 220.0].into() }),
        ..FreeSpace::default()
    };
    crowded.goal = Some(Goal { position: [30.0, 30.0].into(), heading: None });
    crowded.clearance = ClearanceWish::Gap(Gap::Uniform(0.1));

    let mut pillars = small();
    let solids = pillars.free_space.solids.as_mut().unwrap();
    solids.extend((0..5_000).map(|index| {
        let (x, z) = (10.0 + f64::from(index % 70) * 3.0, f64::from(index / 70) * 3.0);
        Solid::Box(AxisBox { min: [x, z].into(), max: [x + 1.0, z + 1.0].into() })
    }));

    let mut wishes = small();
    let gaps = || Choice::Gaps(vec![Gap::Uniform(0.1); 40]);
    wishes.clearance = ClearanceWish::Each((0..9_000).map(|_| gaps()).collect());
    vec![in_order, crowded, pillars, wishes]
}

/// What the workspace itself is, and the hash table of its cache, bytes.
const SLACK: usize = 1 << 14;

#[test]
fn what_is_kept_stays_within_the_bound() {
    let scenes: Vec<_> = huge().iter().map(request).collect();
    let small = request(&small());
    let mut sink = Nowhere(vec![0; PART_CELLS]);
    let stop = StopFlag::new();
    for bound in [0, 1 << 20, 64 << 20] {
        let before = LIVE.load(Ordering::Relaxed);
        let mut workspace = Workspace::new(Caps::default(), bound);
        let mut answer = |(header, cells): &(RequestHeader, Vec<u64>)| {
            PEAK.store(LIVE.load(Ordering::Relaxed), Ordering::Relaxed);
            let Ok(()) = workspace.answer(header, cells, &stop, &mut sink);
            let kept = LIVE.load(Ordering::Relaxed) - before;
            let counted = workspace.bytes();
            assert!(counted <= bound, "{counted} bytes are counted, at most {bound} are allowed");
            assert!(kept <= bound + SLACK, "{kept} bytes are kept, at most {bound} are allowed");
            assert!(kept <= counted + SLACK, "{kept} bytes are kept, {counted} are counted");
            PEAK.load(Ordering::Relaxed) - before
        };
        for scene in &scenes {
            assert!(answer(scene) > 1 << 19, "it takes no memory to speak of");
            answer(&small);
        }
    }
}
