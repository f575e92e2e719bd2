//! Robots among walls.

use super::*;

/// Two rooms with a door of 1.2 m between them; the robot has to turn around in the first.
const ROOMS: &str = r#"{ "task": "drive",
  "body": { "footprint": { "width": 0.6, "length": 0.9 } },
  "start": { "position": [2, 3], "heading": 3.141592653589793 },
  "goal": { "position": [8, 3], "heading": 0 },
  "free_space": { "bounds": { "min": [0, 0], "max": [10, 6] }, "solids": [
    { "polygon": [[4.9, 0], [5.1, 0], [5.1, 2.4], [4.9, 2.4]] },
    { "polygon": [[4.9, 3.6], [5.1, 3.6], [5.1, 6], [4.9, 6]] } ] },
  "clearance": { "gap": 0.1 } }"#;

#[test]
fn walls_are_dark_and_turns_are_marked() {
    let (scene, reply) = planned(ROOMS);
    let picture = sound(&scene, &reply);
    let document = Document::parse(&picture).unwrap();
    let [walls] = of_class(&document, "walls")[..] else { panic!("one area of walls") };
    assert_eq!(walls.attribute("fill"), Some(style::SOLID));
    assert_eq!(walls.attribute("d").unwrap().matches('Z').count(), 2);
    assert!(of_class(&document, "channels").is_empty());
    // A turn, which is half around: an arc and its tip.
    assert_eq!(of_class(&document, "turns")[0].children().count(), 2);
    assert!(of_class(&document, "reverse").is_empty());
    let texts = texts(&document);
    for (sign, is_shown) in
        [("walls", true), ("turns in place", true), ("in reverse", false), ("unknown", false)]
    {
        assert_eq!(texts.iter().any(|text| text == sign), is_shown, "{sign} in {texts:?}");
    }
}

#[test]
fn what_is_unknown_is_light() {
    let (scene, reply) = planned(ROOMS);
    let vertices = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]].map(Vector::from);
    let unknown = [Solid::Polygon(vertices.to_vec())];
    let picture = draw_with(&scene, &reply, Look { unknown: &unknown, ..Look::default() });
    let document = Document::parse(&picture).unwrap();
    let [area] = of_class(&document, "unknown")[..] else { panic!("one area") };
    assert_eq!(area.attribute("fill"), Some(style::UNKNOWN));
    assert!(texts(&document).iter().any(|text| text == "unknown"));
}

#[test]
fn legs_in_reverse_have_their_own_colour() {
    let (scene, mut reply) = planned(ROOMS);
    let answer = reply.answers.as_mut().unwrap()[0].as_mut().unwrap();
    let (from, to) = (Vector::from([2.0, 3.0]), Vector::from([3.0, 3.0]));
    let curve = Curve::Line { from, to, heading: 3.0, turned: 0.0 };
    answer.legs.insert(0, Leg { curve, length: 1.0, reverse: true, ..answer.legs[0] });
    let picture = sound(&scene, &reply);
    let document = Document::parse(&picture).unwrap();
    assert_eq!(of_class(&document, "reverse").len(), 1);
    assert!(texts(&document).iter().any(|text| text == "in reverse"));
}

/// Where the marks of a refusal are, in metres.
#[track_caller]
fn places(json: &str, code: ErrorCode) -> Vec<[f64; 2]> {
    let (scene, reply) = planned(json);
    let refusal = match &reply.answers {
        Err(refusal) => refusal,
        Ok(answers) => answers[0].as_ref().unwrap_err(),
    };
    assert_eq!(refusal.code, code, "{refusal:?}");
    let picture = sound(&scene, &reply);
    let document = Document::parse(&picture).unwrap();
    // The bounds' corners are known in both.
    let view = of_class(&document, "view")[0];
    let number = |node: Node, name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
    // The region is 10 m wide, with a margin of 5 % of that on either side.
    let scale = number(view, "width") / 11.0;
    let height = number(view, "height");
    let place = of_class(&document, "place");
    let circles = place[0].children().filter(|node| node.has_tag_name("circle"));
    circles
        .map(|node| {
            let (x, y) = (number(node, "cx"), height - number(node, "cy"));
            [x / scale - 0.5, y / scale - 0.5].map(|value| (value * 10.0).round() / 10.0)
        })
        .collect()
}

#[test]
fn the_passage_that_is_too_narrow_is_marked() {
    let narrow = ROOMS.replace("2.4]", "2.8]").replace("3.6]", "3.2]");
    let mut ends = places(&narrow, ErrorCode::NoRoute);
    ends.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let [[x0, y0], [x1, y1]] = ends[..] else { panic!("{ends:?}") };
    assert_eq!((y0, y1), (2.8, 3.2));
    assert!([x0, x1].iter().all(|x| (4.9..=5.1).contains(x)), "{ends:?}");
}

#[test]
fn the_wall_that_a_robot_stands_in_is_marked() {
    let inside = ROOMS.replace("[2, 3]", "[4.7, 1]");
    let [[x, _]] = places(&inside, ErrorCode::BodyOutsideFreeSpace)[..] else { panic!("one") };
    assert!((4.9..=5.1).contains(&x), "{x}");
}

#[test]
fn a_robot_in_reverse_is_drawn_about_its_reference_point() {
    let offset = ROOMS.replace("\"length\": 0.9", "\"front\": 0.2, \"rear\": 0.8");
    let (scene, mut reply) = planned(&offset);
    let answer = reply.answers.as_mut().unwrap()[0].as_mut().unwrap();
    // Half around to the left, backwards: it begins at (3, 3), heading down.
    let center = Vector::from([2.0, 3.0]);
    let curve = Curve::Arc { center, radius: 1.0, start_angle: 0.0, sweep: 3.0 };
    answer.legs = vec![Leg { curve, length: 3.0, reverse: true, ..answer.legs[0] }];
    let picture = sound(&scene, &reply);
    let document = Document::parse(&picture).unwrap();
    assert!(texts(&document).iter().any(|text| text == "path of the reference point"));
    let robot = of_class(&document, "way-points")[0].first_child().unwrap();
    let data = robot.attribute("d").unwrap().trim_start_matches('M').trim_end_matches('Z');
    let numbers: Vec<f64> = data.split([' ', 'L']).map(|text| text.parse().unwrap()).collect();
    let scale = (numbers[0] - numbers[4]).abs() / 0.6;
    // Front left first: 0.2 m below the reference point, the rear left 0.8 m above it.
    assert!(((numbers[1] - numbers[3]) / scale - 1.0).abs() < 0.01, "{numbers:?}");
    let path = path_numbers(&document, 0);
    assert!(((numbers[1] - path[1]) / scale - 0.2).abs() < 0.01, "{numbers:?} about {path:?}");
}
