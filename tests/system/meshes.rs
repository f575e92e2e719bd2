//! `plan` with parts from STL files.

use std::fmt::Write;

use integration_tests::{Ended, TestDomain};
use mesh::Block;
use serde_json::{Value, json};

type Corner = [f64; 3];

/// The text of an STL file with these boxes, in millimetres; they may overlap.
fn stl(boxes: &[[Corner; 2]]) -> String {
    let mut text = String::from("solid part\n");
    for &[min, max] in boxes {
        for triangle in (Block { min, max }).surface() {
            text.push_str("facet normal 0 0 0\nouter loop\n");
            for [x, y, z] in triangle {
                _ = writeln!(text, "vertex {} {} {}", x * 1000.0, y * 1000.0, z * 1000.0);
            }
            text.push_str("endloop\nendfacet\n");
        }
    }
    text + "endsolid part\n"
}

const PART: [[Corner; 2]; 2] =
    [[[2.0, 1.5, 1.125], [3.25, 2.5, 2.0]], [[3.0, 1.5, 1.75], [4.0, 2.5, 4.0]]];

const HOUSING: [[Corner; 2]; 6] = [
    [[0.0, 0.0, 0.0], [7.0, 4.0, 1.0]],
    [[0.0, 0.0, 1.0], [1.0, 4.0, 6.0]],
    [[1.0, 1.0, 5.0], [3.5, 3.0, 6.0]],
    [[5.0, 0.0, 1.0], [7.0, 4.0, 4.5]],
    [[1.0, 0.0, 1.0], [7.0, 1.0, 6.0]],
    [[1.0, 3.0, 1.0], [7.0, 4.0, 6.0]],
];

fn scene(body: &Value, solid: &Value) -> String {
    let scene = json!({
        "id": 5, "task": "disassemble", "free_space": {"solids": [solid]}, "body": body,
        "clearance": {"each": [0.05, "safest"]}, "sampling": {"count": 20},
    });
    scene.to_string()
}

fn boxes(boxes: &[[Corner; 2]]) -> Value {
    let boxes: Vec<_> = boxes.iter().map(|[min, max]| json!({"min": min, "max": max})).collect();
    json!({ "boxes": boxes })
}

fn plan(test: &TestDomain, scene: &str) -> Ended {
    let path = test.write("scene.json", scene);
    test.run("plan", &["--local", "--format", "json", path.to_str().unwrap()])
}

#[test]
fn a_mesh_stands_for_the_boxes_inside() {
    let test = TestDomain::new();
    test.write("part.stl", &stl(&PART));
    test.write("housing.stl", &stl(&HOUSING));
    let mesh = |file: &str| json!({"mesh": file, "unit": "mm"});
    // The same union without overlaps.
    let parts = [PART[0], [[3.0, 1.5, 2.0], PART[1][1]], [[3.25, 1.5, 1.75], [4.0, 2.5, 2.0]]];
    let expected = plan(&test, &scene(&boxes(&parts), &boxes(&HOUSING)));
    assert_eq!(expected.code, Some(0), "{expected:?}");
    let body_only = plan(&test, &scene(&mesh("part.stl"), &boxes(&HOUSING)));
    assert_eq!(body_only, expected);
    let both = plan(&test, &scene(&mesh("part.stl"), &mesh("housing.stl")));
    assert_eq!(both.code, Some(0), "{both:?}");
    let length = |ended: &Ended, answer: usize| {
        let reply: Value = serde_json::from_str(&ended.stdout).unwrap();
        reply["trajectories"][answer]["length"].as_f64().unwrap()
    };
    for answer in 0..2 {
        assert!((length(&both, answer) - length(&expected, answer)).abs() < 1e-9);
    }
}

#[test]
fn what_is_no_rectilinear_mesh_is_refused_by_name() {
    let test = TestDomain::new();
    test.write("open.stl", &stl(&PART).replacen("facet", "endsolid\nfacet", 3));
    let slanted = stl(&PART).replacen("vertex 2000 1500 1125", "vertex 2100 1600 1225", 1);
    test.write("slanted.stl", &slanted);
    test.write("words.stl", "not a mesh");
    let refused = |body: Value, message: &str| {
        let ended = plan(&test, &scene(&body, &boxes(&HOUSING)));
        assert_eq!(ended.code, Some(1), "{ended:?}");
        let reply: Value = serde_json::from_str(&ended.stdout).unwrap();
        let said = reply["error"]["message"].as_str().unwrap();
        assert!(said.starts_with("body: ") && said.contains(message), "{said}");
        assert_eq!((&reply["id"], &reply["error"]["field"]), (&json!(5), &json!("body")));
    };
    refused(json!({"mesh": "gone.stl"}), "gone.stl: can't be read: No such file");
    refused(json!({"mesh": "slanted.stl"}), "slanted.stl: triangle ");
    refused(json!({"mesh": "words.stl"}), "words.stl: no STL: ");
    refused(json!({"mesh": "open.stl"}), "open.stl: ");
    refused(json!({"mesh": "part.stl", "unit": "ft"}), "unit must be \"m\", \"mm\" or \"in\"");
    refused(json!({"mesh": "part.stl", "scale": 2}), "unknown field `scale`");
}
