//! What is written in one form and read again is the same.

use proptest::collection::vec;
use proptest::prelude::*;
use schemas::message::{
    Clearance, Curve, Leg, Reply, ReplyAssembler, ReplyPart, Request, RequestContent, Sample,
    SceneRequest, Trajectory,
};
use schemas::wire::{LEG_CELLS, PART_CELLS, SAMPLE_CELLS};
use schemas::{codec, convert, json};

use super::examples::{self, Parts};
use super::memory;
use super::strategies::{finite, key, numbers, part, refusal, scene, trajectory};

proptest! {
    #[test]
    fn scenes_as_json(scene in scene(finite())) {
        let text = json::scene_to_json(&scene);
        prop_assert!(!text.contains("null"), "{text}");
        let read = json::read_scene(&text);
        prop_assert_eq!(read.as_ref(), Ok(&scene), "{}", text);
        prop_assert_eq!(json::scene_to_json(&read.unwrap()), text);
    }

    #[test]
    fn scenes_in_memory(
        key in key(), sent_ns: u64, first in scene(numbers()), second in scene(numbers()),
    ) {
        let mut dirty = SceneRequest::empty();
        let mut cells = vec![7];
        for scene in [&first, &second, &first] {
            cells.truncate(1);
            let header = convert::write_scene(scene, key, sent_ns, &mut cells).unwrap();
            prop_assert_eq!(cells[0], 7, "what was there before");
            convert::read_scene(&header, &cells[1..], &mut dirty).unwrap();
            prop_assert_eq!(&dirty, scene);
            let request = Request { key, sent_ns, content: RequestContent::Scene(scene.clone()) };
            prop_assert_eq!(convert::read_request(&header, &cells[1..]), request);
        }
    }

    #[test]
    fn requests_as_bytes(key in key(), sent_ns: u64, scene in scene(numbers())) {
        let request = Request { key, sent_ns, content: RequestContent::Scene(scene) };
        let bytes = codec::encode(&request);
        prop_assert_eq!(codec::decode::<Request>(&bytes).unwrap(), request);
    }

    #[test]
    fn reply_parts_as_bytes(part in part(numbers())) {
        let bytes = codec::encode(&part);
        prop_assert_eq!(&codec::decode::<ReplyPart>(&bytes).unwrap(), &part);
        let mut apart = part;
        let mut samples = vec![Sample { t: 7.0, ..Sample::default() }];
        if let Ok(trajectory) = &mut apart.content {
            std::mem::swap(&mut trajectory.samples, &mut samples);
        }
        let mut in_place = vec![7];
        codec::encode_part_into(&apart, &samples, &mut in_place);
        prop_assert_eq!(&in_place[1..], bytes);
    }

    #[test]
    fn reply_parts_in_memory(part in part(numbers())) {
        let mut sink = Parts::default();
        examples::write(&part, &mut sink);
        let [(header, cells)] = sink.0.try_into().unwrap();
        prop_assert_eq!(convert::read_part(&header, &cells).unwrap(), part);
    }

    #[test]
    fn replies_of_several_answers(
        key in key(),
        answers in vec(prop_oneof![
            trajectory(numbers()).prop_map(Ok),
            refusal(&numbers()).prop_map(Err),
        ], 1..4),
    ) {
        check_reply(Reply { key, id: Some(3), answers: Ok(answers) });
    }
}

/// Through shared memory, part by part; gives how many parts there were.
#[track_caller]
fn check_reply(reply: Reply) -> usize {
    let mut sink = Parts::default();
    let answers = reply.answers.as_ref().unwrap();
    for (answer, content) in answers.iter().enumerate() {
        let part = ReplyPart {
            key: reply.key,
            id: reply.id,
            sent_ns: 1,
            part: sink.0.len() as u32,
            last: answer + 1 == answers.len(),
            answer: answer as u32,
            answers: answers.len() as u32,
            content: content.clone(),
        };
        examples::write(&part, &mut sink);
    }
    let mut assembler = ReplyAssembler::default();
    let mut assembled = None;
    for (header, cells) in &sink.0 {
        assert!(cells.len() <= PART_CELLS, "{} cells", cells.len());
        assert_eq!(assembled, None, "a part after the last");
        assembled = assembler.push(convert::read_part(header, cells).unwrap()).unwrap();
    }
    assert_eq!(assembled.as_ref(), Some(&reply));
    sink.0.len()
}

fn long(gaps: usize, route: usize, channels: usize, legs: usize, samples: usize) -> Trajectory {
    let curve =
        |at| Curve::Arc { center: [at, 1.0].into(), radius: 2.0, start_angle: 3.0, sweep: 4.0 };
    let leg =
        |at| Leg { curve: curve(at), length: 1.0, clearance: 2.0, ..examples::driving().legs[0] };
    let channel = examples::driving().channels[0];
    Trajectory {
        dimension: 2,
        gaps_per_junction: 2,
        clearance: Clearance::default(),
        gaps: (0..gaps).map(|at| at as f64).collect(),
        route: (0..route as u64).collect(),
        channels: vec![channel; channels],
        legs: (0..legs).map(|at| leg(at as f64)).collect(),
        samples: (0..samples).map(|at| Sample { t: at as f64, ..Sample::default() }).collect(),
        ..Trajectory::default()
    }
}

#[track_caller]
fn check_parts(trajectory: Trajectory, parts: usize) {
    let reply = Reply { key: examples::KEY, id: None, answers: Ok(vec![Ok(trajectory)]) };
    assert_eq!(check_reply(reply), parts);
}

#[test]
fn parts_end_where_they_are_full() {
    // 4,096 cells: 455 samples of 9 and a cell, 292 legs of 14 and 8 cells.
    assert_eq!((PART_CELLS / SAMPLE_CELLS, PART_CELLS % SAMPLE_CELLS), (455, 1));
    assert_eq!((PART_CELLS / LEG_CELLS, PART_CELLS % LEG_CELLS), (292, 8));
    check_parts(long(0, 0, 0, 0, 0), 1);
    check_parts(long(0, 0, 0, 0, 455), 1);
    check_parts(long(0, 0, 0, 0, 456), 2);
    check_parts(long(1, 0, 0, 0, 455), 1);
    check_parts(long(2, 0, 0, 0, 455), 2);
    check_parts(long(0, 0, 1, 0, 454), 1);
    check_parts(long(0, 0, 1, 292, 0), 1);
    check_parts(long(0, 0, 0, 291, 2), 1);
    check_parts(long(0, 0, 0, 291, 3), 2);
    check_parts(long(0, 0, 0, 292, 1), 2);
    check_parts(long(0, 0, 0, 293, 0), 2);
}

#[test]
fn every_list_can_fill_parts() {
    check_parts(long(PART_CELLS, 0, 0, 0, 0), 1);
    check_parts(long(PART_CELLS, 1, 0, 0, 0), 2);
    check_parts(long(PART_CELLS + 1, 0, 0, 0, 0), 2);
    check_parts(long(0, PART_CELLS, 0, 0, 1), 2);
    check_parts(long(0, 2 * PART_CELLS + 1, 0, 0, 0), 3);
    check_parts(long(0, 0, PART_CELLS / 4, 0, 0), 1);
    check_parts(long(1, 0, PART_CELLS / 4, 0, 0), 2);
    check_parts(long(PART_CELLS - 1, 1, 1, 1, 1), 2);
    check_parts(long(3, 3, 3, 2000, 10_000), 29);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn trajectories_of_any_size(
        gaps in 0..40_000_usize, route in 0..40_000_usize, channels in 0..10_000_usize,
        legs in 0..3_000_usize, samples in 0..6_000_usize,
    ) {
        let cells = gaps + route + 4 * channels + LEG_CELLS * legs + SAMPLE_CELLS * samples;
        let trajectory = long(gaps, route, channels, legs, samples);
        let answers = Ok(vec![Ok(trajectory)]);
        let parts = check_reply(Reply { key: examples::KEY, id: Some(1), answers });
        // Items are not split, so parts have some cells to spare.
        let least = cells.div_ceil(PART_CELLS).max(1);
        prop_assert!((least..=least + 1).contains(&parts), "{parts} parts for {cells} cells");
    }
}

#[test]
fn long_texts_are_cut_between_characters() {
    let refusal = schemas::message::Refusal::invalid("f".repeat(5000), "–".repeat(5000));
    let mut sink = Parts::default();
    examples::write(&examples::of_answer(Err(refusal)), &mut sink);
    let [(header, cells)] = sink.0.try_into().unwrap();
    let read = convert::read_part(&header, &cells).unwrap().content.unwrap_err();
    assert_eq!(read.message, "–".repeat(682));
    assert_eq!(read.field, Some("f".repeat(2048)));
}

#[test]
fn scenes_of_the_same_shape_are_read_without_allocation() {
    for (name, text) in examples::SCENES {
        let scene = examples::scene(text);
        let mut cells = Vec::new();
        let write = |cells: &mut Vec<u64>| {
            cells.clear();
            convert::write_scene(&scene, examples::KEY, 0, cells).unwrap()
        };
        let header = write(&mut cells);
        let (again, count) = memory::allocations(|| write(&mut cells));
        assert_eq!((again, count), (header, 0), "{name}: written");
        let mut read = SceneRequest::empty();
        convert::read_scene(&header, &cells, &mut read).unwrap();
        let (_, count) = memory::allocations(|| {
            convert::read_scene(&header, &cells, &mut read).unwrap();
        });
        assert_eq!(count, 0, "{name}: read");
        assert_eq!(read, scene, "{name}");
    }
}
