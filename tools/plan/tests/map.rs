//! Floor plans from files, and `plan --map`.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use plan::map::{self, MOST_BOXES, MapError};
use schemas::message::{AxisBox, FreeSpace, Solid};
use tempfile::TempDir;

const YAML: &str = "image: floor.pgm\nresolution: 0.5\norigin: [10, -4, 0]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.25\n";

/// A folder with a map in it: the YAML and the picture.
fn folder(yaml: &str, picture: &[u8]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("maps")).unwrap();
    fs::write(folder.path().join("maps/floor.pgm"), picture).unwrap();
    let path = folder.path().join("maps/floor.yaml");
    fs::write(&path, yaml).unwrap();
    (folder, path)
}

fn cells(min: [f64; 2], max: [f64; 2]) -> AxisBox {
    AxisBox { min: min.into(), max: max.into() }
}

#[test]
fn the_last_row_of_the_picture_is_at_the_origin() {
    // A wall along the left and the bottom, longer upwards; a stone at the upper right.
    let picture = b"P2 # by hand\n3 4 255\n0 255 0\n0 255 255\n0 255 255\n0 0 255\n";
    let (_folder, path) = folder(YAML, picture);
    let solids = [
        cells([10.0, -4.0], [10.5, -2.0]),
        cells([10.5, -4.0], [11.0, -3.5]),
        cells([11.0, -2.5], [11.5, -2.0]),
    ];
    let expected = FreeSpace {
        solids: Some(solids.map(Solid::Box).to_vec()),
        bounds: Some(cells([10.0, -4.0], [11.5, -2.0])),
        ..FreeSpace::default()
    };
    assert_eq!(map::read(&path).unwrap(), expected);
}

#[test]
fn all_forms_of_a_picture_give_the_same() {
    let drawn = image::GrayImage::from_fn(5, 3, |x, y| {
        image::Luma([if (x * 3 + y * 2) % 4 == 0 { 0 } else { 254 }])
    });
    let grey = image::DynamicImage::from(drawn);
    let mut maps = Vec::new();
    for picture in [grey.clone(), grey.to_luma16().into(), grey.to_rgb8().into()] {
        for format in [image::ImageFormat::Pnm, image::ImageFormat::Png] {
            let mut bytes = std::io::Cursor::new(Vec::new());
            picture.write_to(&mut bytes, format).unwrap();
            // What a file is, not its name, says how it is read.
            let (_folder, path) = folder(YAML, bytes.get_ref());
            maps.push(map::read(&path).unwrap());
        }
    }
    assert!(maps[0].solids.as_ref().is_some_and(|solids| solids.len() > 2));
    for other in &maps {
        assert_eq!(other, &maps[0]);
    }
}

#[test]
fn shades_are_relative_to_the_greatest_that_the_picture_names() {
    // Of 20, 16 is four fifths.
    let (_folder, path) = folder(YAML, b"P2\n3 1\n20\n16 14 20\n");
    let solids = map::read(&path).unwrap().solids.unwrap();
    assert_eq!(solids, [Solid::Box(cells([10.5, -4.0], [11.0, -3.5]))]);
}

#[test]
fn neighbours_meet_exactly() {
    // 0.05 and its multiples are not floats; the pieces of a checkerboard must still touch.
    let yaml = YAML.replace("0.5\n", "0.05\n").replace("10, -4", "-12.2, 3.1");
    let rows =
        (0..40).map(|y| (0..40).map(|x| if (x + y) % 2 == 0 { "0 " } else { "9 " }).collect());
    let picture = format!("P2\n40 40\n9\n{}", rows.collect::<Vec<String>>().join("\n"));
    let (_folder, path) = folder(&yaml, picture.as_bytes());
    let map = map::read(&path).unwrap();
    let solids = map.solids.unwrap();
    assert_eq!(solids.len(), 800);
    for axis in 0..2 {
        let sides = |solid: &Solid| match solid {
            Solid::Box(cells) => [cells.min, cells.max].map(|corner| corner.as_slice()[axis]),
            Solid::Polygon(_) => panic!("not a box"),
        };
        let mut all: Vec<_> = solids.iter().flat_map(sides).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        assert_eq!(all.len(), 41);
    }
}

/// The error of reading a map with this YAML and picture, and its message without the folder.
fn refusal(yaml: &str, picture: &[u8]) -> (MapError, String) {
    let (folder, path) = folder(yaml, picture);
    let error = map::read(&path).unwrap_err();
    let message = error.to_string().replace(&format!("{}/", folder.path().display()), "");
    (error, message)
}

#[test]
fn errors_name_the_file_and_both_numbers() {
    let (_, message) = refusal(YAML, b"P5\n8193 8192\n255\n");
    assert_eq!(
        message,
        "maps/floor.pgm: the picture has 8193 x 8192 = 67117056 cells, but at most 67108864 are \
         allowed"
    );
    let (_, message) = refusal(YAML, b"P5\n0 4\n255\n");
    assert_eq!(message, "maps/floor.pgm: the picture has 0 x 4 cells, but needs at least 1 x 1");
    let (_, message) = refusal(YAML, b"P2\n3 1\n255\n0 100 191\n");
    assert_eq!(
        message,
        "maps/floor.yaml: none of the picture's 3 cells is free: no occupancy is less than \
         free_thresh, 0.25"
    );
    let (_, message) = refusal(&YAML.replace("10, -4", "10, 1e16"), b"P2\n1 1\n1\n1\n");
    assert_eq!(
        message,
        "maps/floor.yaml: cells of 0.5 m are too small at the coordinate 10000000000000000 m: \
         their corners round to the same number; move the origin closer to 0"
    );
    let (_, message) = refusal(&YAML.replace("resolution: 0.5", "resolution: 0"), b"");
    assert_eq!(
        message,
        "maps/floor.yaml: resolution must be a number of metres greater than 0, not 0"
    );
}

#[test]
fn unreadable_pictures_are_refused() {
    for picture in [&b""[..], b"GIF89a", b"P5\n4 4\n255\nshort", b"P2\n2 1\n255\n0 256\n"] {
        let (error, message) = refusal(YAML, picture);
        assert!(matches!(error, MapError::Picture { .. }), "{message}");
        assert!(message.starts_with("maps/floor.pgm: "), "{message}");
    }
    let (error, message) = refusal(&YAML.replace("floor.pgm", "roof.pgm"), b"");
    assert!(matches!(error, MapError::Read { .. }), "{message}");
    assert!(message.starts_with("can't read maps/roof.pgm: "), "{message}");
}

#[test]
fn noise_is_refused() {
    let side = 1450;
    let mut picture = format!("P5\n{side} {side}\n255\n").into_bytes();
    picture.extend((0..side * side).map(|i| if (i / side + i % side) % 2 == 0 { 0 } else { 255 }));
    let (error, _) = refusal(YAML, &picture);
    let MapError::TooManyBoxes { has, most, .. } = error else { panic!("{error}") };
    assert_eq!((has, most), (side * side / 2, MOST_BOXES));
}

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../recordings/scenes")
}

fn plan(arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("plan").unwrap();
    command.current_dir(scenes()).args(["--local", "--format", "json"]).args(arguments);
    command
}

/// The replies printed, one a line.
fn replies(command: &mut Command) -> Vec<serde_json::Value> {
    let output = command.output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn the_map_is_the_free_space_of_every_scene() {
    let scene = fs::read_to_string(scenes().join("drive-office.json")).unwrap();
    let line = scene.replace('\n', " ").replace("\"id\": 14", "\"id\": 13");
    let mut command = plan(&["--map", "office.yaml", "drive-office.json", "drive-a.json", "-"]);
    let replies = replies(command.write_stdin(format!("{line}\n\n{line}\n")));
    let ids: Vec<_> = replies.iter().map(|reply| reply["id"].as_u64()).collect();
    assert_eq!(ids, [Some(14), Some(10), Some(13), Some(13)]);
    // That scene has channels.
    assert_eq!(replies[1]["error"]["field"], "free_space");
    for index in [0, 2, 3] {
        assert_eq!(replies[index]["trajectories"].as_array().unwrap().len(), 3);
    }
    assert_eq!(replies[2], replies[3]);
}

#[test]
fn without_a_map_the_free_space_is_missing() {
    let replies = replies(&mut plan(&["drive-office.json"]));
    let message = replies[0]["error"]["message"].as_str().unwrap();
    assert!(message.contains("free_space is missing"), "{message}");
}

#[test]
fn an_unreadable_map_ends_the_program() {
    let output = plan(&["--map", "drive-a.json", "drive-office.json"]).output().unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0));
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(message, "plan: drive-a.json: image is missing\n");
}
