use roxmltree::{Document, Node};
use schemas::message::{
    AxisBox, Body, ClearanceWish, Curve, ErrorCode, Frames, FreeSpace, Gap, Leg, Pose, Request,
    RequestContent, RequestKey, Sample, Solid, Vector,
};

use super::*;

mod corridors;
mod floor_plans;

const DISASSEMBLE: &str = include_str!("../../../../recordings/scenes/disassemble.json");

/// A box in a channel that turns twice, in three dimensions.
const IN_SPACE: &str = r#"{ "task": "disassemble", "exit": ["+z", "+x"],
  "free_space": { "channels": [ {"min": [0,0,0], "max": [4,3,2.5]},
    {"min": [2,0,0], "max": [4,8,2.5]}, {"min": [2,5,0], "max": [4,8,7]} ], "in_order": true },
  "body": { "box": {"min": [0.3,0.5,0.3], "max": [1.5,2.0,1.6]} },
  "clearance": { "each": [0.1, "safest"] } }"#;

fn planned(json: &str) -> (SceneRequest, Reply) {
    let scene = schemas::json::read_scene(json).expect("a scene");
    let content = RequestContent::Scene(scene.clone());
    let reply = answer::reply_to(
        &Request { key: RequestKey::default(), sent_ns: 0, content },
        &answer::Caps::default(),
    );
    (scene, reply)
}

fn refused(message: &str) -> Reply {
    let refusal = Refusal::new(ErrorCode::JunctionTooSmall, message);
    Reply { key: RequestKey::default(), id: None, answers: Err(refusal) }
}

/// The picture, once it is known to be sound whatever it shows.
#[track_caller]
fn sound(scene: &SceneRequest, reply: &Reply) -> String {
    let picture = draw(scene, reply);
    assert!(picture.len() <= MOST_BYTES, "{} bytes", picture.len());
    let document = Document::parse(&picture).expect("well-formed XML");
    for attribute in document.descendants().flat_map(|node| node.attributes()) {
        let value = attribute.value();
        assert!(!value.contains("NaN") && !value.contains("inf"), "{attribute:?}");
    }
    assert_eq!(draw(scene, reply), picture, "the same bytes again");
    picture
}

fn of_class<'a>(document: &'a Document, class: &str) -> Vec<Node<'a, 'a>> {
    document.descendants().filter(|node| node.attribute("class") == Some(class)).collect()
}

fn texts(document: &Document) -> Vec<String> {
    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
    texts.filter_map(|node| node.text()).map(str::to_owned).collect()
}

/// The numbers of the path in the given panel.
fn path_numbers(document: &Document, panel: usize) -> Vec<f64> {
    let data = of_class(document, "path")[panel].attribute("d").expect("path data");
    let numbers = data.split(['M', 'L', 'A', ' ']).filter(|text| !text.is_empty());
    numbers.map(|text| text.parse().expect("a number")).collect()
}

/// Drawn lying on its side, and turned upright by its frame.
#[test]
fn body_is_drawn_in_the_fixed_frame() {
    let (plain, reply) = planned(DISASSEMBLE);
    let Body::Polygon(vertices) = &plain.body else { panic!("a polygon") };
    let lying = vertices.iter().map(|vertex| {
        let [x, z, _] = world::point(vertex);
        Vector::from([z - 1.0, 4.0 - x])
    });
    let mut turned = plain.clone();
    turned.body = Body::Polygon(lying.collect());
    let pose = |position: [f64; 2], heading| Pose { position: position.into(), heading };
    turned.frames = Some(Frames {
        fixed: pose([0.0, 0.0], 0.0),
        fixed_at_end: None,
        moving: Some(pose([4.0, 1.0], std::f64::consts::FRAC_PI_2)),
        samples: None,
    });
    // The title has its size as it is given.
    let picture = sound(&turned, &reply).replace("2.99 × 2.49", "2.49 × 2.99");
    assert_eq!(picture, sound(&plain, &reply));
}

#[test]
fn every_answer_has_its_panel_and_caption() {
    let (scene, reply) = planned(DISASSEMBLE);
    let picture = sound(&scene, &reply);
    let document = Document::parse(&picture).unwrap();
    assert_eq!(of_class(&document, "answer").len(), 3);
    assert_eq!(of_class(&document, "path").len(), 3);
    let texts = texts(&document);
    for expected in ["a) gap 0.01 m", "b) gap 0.2 m", "c) safest gap: 0.255 to 0.755 m"] {
        assert!(texts.iter().any(|text| text == expected), "{expected} in {texts:?}");
    }
    assert!(texts.iter().any(|text| text.starts_with("length 7.403 m")), "{texts:?}");
    assert_eq!(texts.iter().filter(|text| *text == "clearance 0.01 m").count(), 3);
}

#[test]
fn what_stands_still_is_drawn_once() {
    let (scene, reply) = planned(DISASSEMBLE);
    let picture = sound(&scene, &reply);
    let document = Document::parse(&picture).unwrap();
    let count = |name: &str| document.descendants().filter(|n| n.has_tag_name(name)).count();
    assert_eq!(count("use"), 3);
    assert_eq!(of_class(&document, "channels").len(), 1);
}

#[test]
fn the_path_is_that_of_the_first_vertex_to_scale() {
    // docs/method.md 4, gap 0.2.
    let way_points = [[4.5, 1.01], [4.2, 2.2], [2.31, 2.81], [2.31, 7.0]];
    let (scene, reply) = planned(DISASSEMBLE);
    let picture = sound(&scene, &reply);
    let numbers = path_numbers(&Document::parse(&picture).unwrap(), 1);
    assert_eq!(numbers.len(), 8);
    let scale = (numbers[1] - numbers[7]) / (7.0 - 1.01);
    assert!(scale > 20.0, "{scale} pixels per metre, upward");
    for (pixel, way_point) in numbers.chunks(2).zip(way_points) {
        let right = (pixel[0] - numbers[0]) - (way_point[0] - 4.5) * scale;
        let up = (numbers[1] - pixel[1]) - (way_point[1] - 1.01) * scale;
        assert!(right.abs() < 0.02 && up.abs() < 0.02, "{way_point:?} is at {pixel:?}");
    }
}

#[test]
fn arcs_are_arcs_of_the_guiding_circles() {
    let (scene, reply) = corridors::z();
    let picture = sound(&scene, &reply);
    let document = Document::parse(&picture).unwrap();
    let data = of_class(&document, "path")[1].attribute("d").unwrap();
    assert_eq!(data.matches('A').count(), 3);
    // Start (1.2, 1.5), goal (20.5, 18.25), gap 0.6 and half of the width 1.0.
    let numbers = path_numbers(&document, 1);
    let scale = (numbers[numbers.len() - 2] - numbers[0]) / (20.5 - 1.2);
    // M x y, L x y, A rx ry rotation large sweep x y: a turn to the right.
    let [radius, large, sweep] = [numbers[4], numbers[7], numbers[8]];
    assert!((radius - 1.1 * scale).abs() < 0.02, "{radius} at scale {scale}");
    assert_eq!((large, sweep), (0.0, 1.0));
    assert_eq!(numbers[9 + 2 + 2 + 4], 0.0, "the second turn is to the left");
    let circles = of_class(&document, "circles");
    assert_eq!(circles[1].children().count(), 3);
}

#[test]
fn long_corridors_are_sound() {
    let (scene, reply) = corridors::serpentine();
    let picture = sound(&scene, &reply);
    let document = Document::parse(&picture).unwrap();
    assert_eq!(of_class(&document, "answer").len(), 4);
    assert_eq!((of_class(&document, "start").len(), of_class(&document, "goal").len()), (4, 4));
}

#[test]
fn three_dimensions_are_seen_from_three_sides() {
    let (scene, reply) = planned(IN_SPACE);
    let picture = sound(&scene, &reply);
    let document = Document::parse(&picture).unwrap();
    assert_eq!(of_class(&document, "answer").len(), 2);
    assert_eq!(of_class(&document, "view").len(), 6);
    assert_eq!(of_class(&document, "path").len(), 6);
}

#[test]
fn a_refused_answer_says_why_in_its_panel() {
    let (mut scene, _) = planned(DISASSEMBLE);
    let json = schemas::json::scene_to_json(&scene).replace("\"safest\"", "0.3");
    let reply;
    (scene, reply) = planned(&json);
    let picture = sound(&scene, &reply);
    let document = Document::parse(&picture).unwrap();
    assert_eq!(of_class(&document, "answer").len(), 3);
    assert_eq!(of_class(&document, "path").len(), 2);
    let texts = texts(&document);
    assert!(texts.iter().any(|text| text == "c) gap 0.3 m: gap out of range"), "{texts:?}");
    let Err(refusal) = &reply.answers.as_ref().unwrap()[2] else { panic!("it is refused") };
    assert!(texts.join(" ").contains(&refusal.message), "{texts:?}");
}

#[test]
fn a_refused_request_shows_the_scene_and_the_message() {
    let (scene, _) = planned(DISASSEMBLE);
    let message = "junction 1 is 2.40 m wide, <the body> needs \"more\" than 2.49 m & so on \
                   and so on until the line is certainly broken more than once in the picture";
    let picture = sound(&scene, &refused(message));
    let document = Document::parse(&picture).unwrap();
    assert_eq!(of_class(&document, "body").len(), 1);
    assert_eq!(of_class(&document, "path").len(), 0);
    assert!(texts(&document).join(" ").contains(message), "{:?}", texts(&document));
}

#[test]
fn many_answers_are_thinned_to_the_first_and_the_last() {
    let (mut scene, mut reply) = planned(DISASSEMBLE);
    let answer = reply.answers.as_ref().unwrap()[0].clone();
    scene.clearance = ClearanceWish::Curve(1000);
    reply.answers = Ok(vec![answer; 1000]);
    let picture = sound(&scene, &reply);
    let document = Document::parse(&picture).unwrap();
    assert_eq!(of_class(&document, "answer").len(), MOST_PANELS);
    let texts = texts(&document);
    let has = |begin: &str| texts.iter().any(|text| text.starts_with(begin));
    assert!(has("a) point 1 of 1000") && has("1000) point 1000 of 1000"), "{texts:?}");
    assert!(texts.iter().any(|text| text.contains("9 of 1000 answers shown")), "{texts:?}");
}

/// `count` channels up a staircase and a path through them, at a scale of `unit` metres.
fn staircase(count: u32, unit: f64) -> (SceneRequest, Reply) {
    let channel = |index: u32| {
        let (x, z) = (f64::from(index / 2), f64::from(index.div_ceil(2)));
        let (right, up) = if index.is_multiple_of(2) { (2.0, 1.0) } else { (1.0, 2.0) };
        let point = |x: f64, z: f64| Vector::from([x * unit, z * unit]);
        AxisBox { min: point(x, z), max: point(x + right, z + up) }
    };
    let point = |index: u32| [f64::from(index) * unit, f64::from(index % 7) * unit, 0.0];
    let leg = |index: u32| {
        let [a, b] = [point(index), point(index + 1)].map(|[x, z, _]| Vector::from([x, z]));
        let curve = Curve::Line { from: a, to: b, heading: 0.0, turned: 0.0 };
        Leg::new(curve, unit, unit)
    };
    let scene = SceneRequest {
        free_space: FreeSpace {
            channels: Some((0..count).map(channel).collect()),
            in_order: true,
            ..FreeSpace::default()
        },
        body: Body::Box(AxisBox {
            min: [0.1 * unit, 0.1 * unit].into(),
            max: [0.6 * unit, 0.7 * unit].into(),
        }),
        clearance: ClearanceWish::Gap(Gap::Uniform(0.1 * unit)),
        ..SceneRequest::empty()
    };
    let answer = Trajectory {
        dimension: 2,
        length: f64::from(count) * unit,
        legs: (0..count).map(leg).collect(),
        route: (0..u64::from(count)).collect(),
        ..Trajectory::default()
    };
    let reply = Reply { key: RequestKey::default(), id: None, answers: Ok(vec![Ok(answer)]) };
    (scene, reply)
}

#[test]
fn any_scale_can_be_drawn() {
    for unit in [1e-300, 1e-9, 1.0, 1e12, 1e300, f64::NAN, f64::INFINITY, 0.0] {
        let (scene, reply) = staircase(5, unit);
        let picture = sound(&scene, &reply);
        assert_eq!(of_class(&Document::parse(&picture).unwrap(), "body").len(), 1);
    }
    let (mut scene, reply) = staircase(3, 1.0);
    scene.body = Body::Polygon(vec![[1e12, 0.0].into(), [1e12 + 1.0, 0.0].into()]);
    sound(&scene, &reply);
    sound(&SceneRequest::empty(), &refused(""));
    sound(&SceneRequest::empty(), &Reply { answers: Ok(Vec::new()), ..refused("") });
}

#[test]
fn large_scenes_make_bounded_pictures() {
    let (mut scene, mut reply) = staircase(10_000, 1.0);
    sound(&scene, &reply);

    // Many legs, many vertices, many answers; then samples alone.
    let turn = |index: u32| std::f64::consts::TAU * f64::from(index) / 100_000.0;
    let round = |index| {
        let far = 3000.0 + f64::from(index % 2);
        Vector::from([far * libm::cos(turn(index)), far * libm::sin(turn(index))])
    };
    let polygon: Vec<Vector> = (0..100_000).map(round).collect();
    scene.body = Body::Polygon(polygon.clone());
    scene.free_space.solids = Some(vec![Solid::Polygon(polygon)]);
    let mut answer = reply.answers.as_ref().unwrap()[0].clone().unwrap();
    scene.clearance = ClearanceWish::Curve(9);
    reply.answers = Ok(vec![Ok(answer.clone()); 9]);
    sound(&scene, &reply);

    let leg = answer.legs[0];
    let sample = |index: u32| Sample {
        t: f64::from(index),
        position: [f64::from(index), f64::from(index % 10) * 1000.0, 0.0],
        ..Sample::default()
    };
    answer.legs.clear();
    answer.samples = (0..200_000).map(sample).collect();
    reply.answers = Ok(vec![Ok(answer.clone()); 9]);
    let picture = sound(&scene, &reply);
    assert_eq!(of_class(&Document::parse(&picture).unwrap(), "path").len(), 9);

    let arc = Curve::Arc { center: [0.0, 0.0].into(), radius: 5.0, start_angle: 0.0, sweep: 1e9 };
    answer.legs = vec![Leg { curve: arc, length: 5e9, ..leg }; 10_000];
    reply.answers = Ok(vec![Ok(answer.clone())]);
    sound(&scene, &reply);

    let radius = f64::INFINITY;
    let arc = Curve::Arc { center: [0.0, 0.0].into(), radius, start_angle: 0.0, sweep: 1.0 };
    answer.legs = vec![Leg { curve: arc, length: f64::INFINITY, ..leg }; 10_000];
    reply.answers = Ok(vec![Ok(answer)]);
    sound(&scene, &reply);
}

#[test]
fn many_small_solids_become_an_area() {
    let (mut scene, reply) = staircase(4, 1.0);
    let cell = |index: u32| {
        let (x, z) = (f64::from(index % 200), f64::from(index / 200));
        Solid::Box(AxisBox { min: [x, z].into(), max: [x + 1.0, z + 1.0].into() })
    };
    scene.free_space.solids = Some((0..40_000).map(cell).collect());
    let picture = sound(&scene, &reply);
    assert!(picture.len() < 50_000, "{} bytes", picture.len());
    assert!(picture.contains("crispEdges"));
}
