//! Floor plans from files.

use std::f64::consts::FRAC_PI_2;
use std::fs;
use std::path::PathBuf;

use floor_plan::{CellState, CellsError, FloorPlan, MOST_CORNERS, MapError, UnknownCells};
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

fn read(yaml: &str, picture: &[u8]) -> FloorPlan {
    let (_folder, path) = folder(yaml, picture);
    floor_plan::read(&path, UnknownCells::Occupied).unwrap()
}

fn polygons(free_space: FreeSpace) -> Vec<Vec<[f64; 2]>> {
    let polygon = |solid: Solid| match solid {
        Solid::Polygon(vertices) => {
            vertices.iter().map(|vertex| [vertex.padded()[0], vertex.padded()[1]]).collect()
        }
        other => panic!("{other:?} is not a polygon"),
    };
    free_space.solids.unwrap().into_iter().map(polygon).collect()
}

/// A wall along the left and the bottom, longer upwards; a stone at the upper right.
const CORNER: &[u8] = b"P2 # by hand\n3 4 255\n0 255 0\n0 255 255\n0 255 255\n0 0 255\n";

#[test]
fn the_last_row_of_the_picture_is_at_the_origin() {
    let free_space = read(YAML, CORNER).free_space();
    let bounds = AxisBox { min: [10.0, -4.0].into(), max: [11.5, -2.0].into() };
    assert_eq!((free_space.bounds, free_space.in_order), (Some(bounds), false));
    let wall = [[10.0, -4.0], [11.0, -4.0], [11.0, -3.5], [10.5, -3.5], [10.5, -2.0], [10.0, -2.0]];
    let stone = [[11.0, -2.5], [11.5, -2.5], [11.5, -2.0], [11.0, -2.0]];
    assert_eq!(polygons(free_space), [wall.to_vec(), stone.to_vec()]);
}

#[test]
fn quarter_turns_are_exact() {
    let place = |yaw: f64| {
        let plan = read(&YAML.replace("-4, 0]", &format!("-4, {yaw}]")), CORNER);
        let free_space = plan.free_space();
        let bounds = free_space.bounds.unwrap();
        // No more than the outlines: nothing is between the picture and its bounds.
        assert_eq!(free_space.solids.as_ref().unwrap().len(), 2);
        (bounds.min.padded(), bounds.max.padded(), polygons(free_space)[1][0])
    };
    assert_eq!(place(1e-9), ([10.0, -4.0, 0.0], [11.5, -2.0, 0.0], [11.0, -2.5]));
    assert_eq!(place(-1e-9), place(0.0));
    assert_eq!(place(FRAC_PI_2), ([8.0, -4.0, 0.0], [10.0, -2.5, 0.0], [8.5, -3.0]));
    assert_eq!(place((FRAC_PI_2 * 1e9).round() / 1e9), place(FRAC_PI_2));
    assert_eq!(place(2.0 * FRAC_PI_2), ([8.5, -6.0, 0.0], [10.0, -4.0, 0.0], [9.0, -5.5]));
    assert_eq!(place(-FRAC_PI_2), ([10.0, -5.5, 0.0], [12.0, -4.0, 0.0], [11.5, -5.0]));
    assert_eq!(place(3.0 * FRAC_PI_2), place(-FRAC_PI_2));
}

/// Twice the area, positive if counter-clockwise.
fn area(polygon: &[[f64; 2]]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    // From the first vertex: far from the origin little would be left of it.
    let [x, y] = polygon[0];
    polygon.iter().zip(next).map(|(a, b)| (a[0] - x) * (b[1] - y) - (b[0] - x) * (a[1] - y)).sum()
}

/// How often polygons wind around a point.
fn winding(polygons: &[Vec<[f64; 2]>], [x, y]: [f64; 2]) -> i32 {
    let mut winding = 0;
    for polygon in polygons {
        for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            let left = (b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1]) > 0.0;
            winding += i32::from(a[1] <= y && y < b[1] && left);
            winding -= i32::from(b[1] <= y && y < a[1] && !left);
        }
    }
    winding
}

#[test]
fn a_turned_map_is_solid_where_its_cells_are_and_outside_the_picture() {
    let picture = b"P2\n5 4\n255\n0 0 0 0 0\n0 254 254 0 254\n0 254 0 0 0\n254 0 0 0 205\n";
    for yaw in [0.3, 1.0, -0.01, 2.0, 3.5, 5.0, -2.0, 1e-6, 1.57] {
        let plan = read(&YAML.replace("-4, 0]", &format!("-4, {yaw}]")), picture);
        let free_space = plan.free_space();
        let bounds = free_space.bounds.unwrap();
        let (min, max) = (bounds.min.padded(), bounds.max.padded());
        let polygons = polygons(free_space);
        assert_eq!(polygons.len(), plan.outlines().count() + 4);
        assert!(polygons.iter().all(|polygon| area(polygon) > 0.0));
        for vertex in polygons.iter().flatten() {
            assert!((0..2).all(|i| min[i] <= vertex[i] && vertex[i] <= max[i]), "{vertex:?}");
        }
        let (sin, cos) = (f64::sin(yaw), f64::cos(yaw));
        let turned =
            |x: f64, y: f64| [10.0 + (x * cos - y * sin) * 0.5, -4.0 + (x * sin + y * cos) * 0.5];
        for y in 0..4 {
            for x in 0..5 {
                let middle = turned(x as f64 + 0.5, y as f64 + 0.5);
                let solid = plan.grid().cell(x, y) != Some(CellState::Free);
                assert_eq!(winding(&polygons, middle), i32::from(solid), "{x}, {y} at {yaw}");
                let [u, v] = plan.frame().locate(middle);
                assert!((u - x as f64 - 0.5).abs() < 1e-9 && (v - y as f64 - 0.5).abs() < 1e-9);
            }
        }
        // Everything within the bounds is in the picture or solid, as areas add up.
        let all: f64 = polygons.iter().map(|polygon| area(polygon) / 2.0).sum();
        let is_free = |cell: &usize| plan.grid().cell(cell % 5, cell / 5) == Some(CellState::Free);
        let free = (0..20).filter(is_free).count() as f64 * 0.25;
        let whole = (max[0] - min[0]) * (max[1] - min[1]);
        assert!((all + free - whole).abs() < 1e-9, "{all} + {free} is not {whole} at {yaw}");
    }
}

#[test]
fn what_touches_in_a_turned_map_shares_its_sides() {
    let picture = b"P2\n5 4\n255\n0 0 0 0 0\n0 254 254 0 254\n0 254 0 0 0\n254 0 0 0 205\n";
    let plan = read(&YAML.replace("-4, 0]", "-4, 0.7]"), picture);
    let bounds = plan.free_space().bounds.unwrap();
    let (min, max) = (bounds.min.padded(), bounds.max.padded());
    let polygons = polygons(plan.free_space());
    let sides = |polygon: &[[f64; 2]]| -> Vec<[[u64; 2]; 2]> {
        let bits = |p: [f64; 2]| p.map(f64::to_bits);
        let next = polygon.iter().cycle().skip(1);
        polygon.iter().zip(next).map(|(a, b)| [bits(*a), bits(*b)]).collect()
    };
    let all: Vec<_> = polygons.iter().map(|polygon| sides(polygon)).collect();
    // The outline of each solid cell on the border has a side in common with what is outside.
    let (outlines, outside) = all.split_at(plan.outlines().count());
    let shared = outside
        .iter()
        .flatten()
        .filter(|[a, b]| outlines.iter().flatten().any(|[c, d]| a == d && b == c));
    // Left 1, bottom 1, right 2, top 1.
    assert_eq!(shared.count(), 5);
    for corner in [[min[0], min[1]], [max[0], min[1]], [max[0], max[1]], [min[0], max[1]]] {
        assert_eq!(polygons.iter().filter(|polygon| polygon.contains(&corner)).count(), 1);
    }
}

#[test]
fn unknown_cells_are_free_on_request() {
    let picture = b"P2\n3 1\n255\n0 180 254\n";
    let (_folder, path) = folder(YAML, picture);
    let solids = |unknown| {
        let plan = floor_plan::read(&path, unknown).unwrap();
        assert_eq!(plan.grid().cell(1, 0), Some(CellState::Unknown));
        polygons(plan.free_space())
    };
    let [cell] = &solids(UnknownCells::Free)[..] else { panic!("the wall only") };
    let [both] = &solids(UnknownCells::Occupied)[..] else { panic!("wall and unknown in one") };
    assert_eq!((cell[1], both[1]), ([10.5, -4.0], [11.0, -4.0]));
}

#[test]
fn grey_cells_are_free_where_the_threshold_says_so() {
    let plan = read(YAML, b"P2\n3 1\n255\n0 205 254\n");
    let grid = plan.grid();
    assert_eq!(grid.cell(1, 0), Some(CellState::Free));
    assert_eq!([0, 1, 2].map(|x| grid.is_grey(x, 0)), [false, true, false]);
    assert!(grid.has_grey());
    assert!(!read(YAML, b"P2\n3 1\n255\n0 180 254\n").grid().has_grey());
}

#[test]
fn all_forms_of_a_picture_give_the_same() {
    use image::ImageFormat::{Bmp, Png, Pnm};
    let drawn = image::GrayImage::from_fn(5, 3, |x, y| {
        image::Luma([if (x * 3 + y * 2) % 4 == 0 { 0 } else { 254 }])
    });
    let grey = image::DynamicImage::from(drawn);
    let mut maps = Vec::new();
    for (picture, formats) in [
        (grey.clone(), &[Pnm, Png, Bmp][..]),
        (grey.to_luma16().into(), &[Pnm, Png]),
        (grey.to_rgb8().into(), &[Pnm, Png, Bmp]),
    ] {
        for format in formats {
            let mut bytes = std::io::Cursor::new(Vec::new());
            picture.write_to(&mut bytes, *format).unwrap();
            // What a file is, not its name, says how it is read.
            maps.push(read(YAML, bytes.get_ref()).free_space());
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
    let plan = read(YAML, b"P2\n3 1\n20\n16 14 20\n");
    let states = [0, 1, 2].map(|x| plan.grid().cell(x, 0).unwrap());
    assert_eq!(states, [CellState::Free, CellState::Unknown, CellState::Free]);
}

#[test]
fn neighbours_meet_exactly() {
    // 0.05 and its multiples are not floats; the pieces of a checkerboard must still touch.
    let yaml = YAML.replace("0.5\n", "0.05\n").replace("10, -4", "-12.2, 3.1");
    let rows =
        (0..40).map(|y| (0..40).map(|x| if (x + y) % 2 == 0 { "0 " } else { "9 " }).collect());
    let picture = format!("P2\n40 40\n9\n{}", rows.collect::<Vec<String>>().join("\n"));
    let polygons = polygons(read(&yaml, picture.as_bytes()).free_space());
    assert_eq!(polygons.len(), 800);
    for axis in 0..2 {
        let mut all: Vec<_> = polygons.iter().flatten().map(|vertex| vertex[axis]).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        assert_eq!(all.len(), 41);
    }
}

/// The error of reading a map with this YAML and picture, and its message without the folder.
fn refusal(yaml: &str, picture: &[u8]) -> (MapError, String) {
    let (folder, path) = folder(yaml, picture);
    let error = floor_plan::read(&path, UnknownCells::Occupied).unwrap_err();
    let message = error.to_string().replace(&format!("{}/", folder.path().display()), "");
    (error, message)
}

#[test]
fn errors_name_the_file_and_both_numbers() {
    let (_, message) = refusal(YAML, b"P5\n10001 10000\n255\n");
    assert_eq!(
        message,
        "maps/floor.pgm: the map has 10001 x 10000 = 100010000 cells, but at most 100000000 \
         are allowed"
    );
    let (_, message) = refusal(YAML, b"P5\n0 4\n255\n");
    assert_eq!(message, "maps/floor.pgm: the map has 0 x 4 cells, but needs at least 1 x 1");
    let (_, message) = refusal(YAML, b"P2\n3 1\n255\n0 100 191\n");
    assert_eq!(
        message,
        "maps/floor.yaml: none of the picture's 3 cells is free: no occupancy is less than \
         free_thresh, 0.25"
    );
    let far = "are too small at the coordinate 10000000000000000 m: their corners round to the \
               same number; move the origin closer to 0";
    for origin in ["10, 1e16, 0", "10, 1e16, 0.3"] {
        let (_, message) = refusal(&YAML.replace("10, -4, 0", origin), b"P2\n1 1\n1\n1\n");
        assert_eq!(message, format!("maps/floor.yaml: cells of 0.5 m {far}"));
    }
    let (_, message) = refusal(&YAML.replace("resolution: 0.5", "resolution: 0"), b"");
    assert_eq!(
        message,
        "maps/floor.yaml: resolution must be a number of metres greater than 0, not 0"
    );
}

#[test]
fn unreadable_pictures_are_refused() {
    for picture in
        [&b""[..], b"GIF89a", b"P5\n4 4\n255\nshort", b"P2\n2 1\n255\n0 256\n", b"BM\0\0"]
    {
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
    let (error, message) = refusal(YAML, &picture);
    let MapError::Grid { cause: CellsError::TooManyCorners { has, most }, .. } = error else {
        panic!("{error}")
    };
    assert_eq!((has, most), (side * side * 2, MOST_CORNERS), "{message}");
}

#[test]
fn cells_in_memory_are_the_map_of_their_picture() {
    let picture = b"P2\n3 2\n255\n255 205 0\n255 255 254\n";
    for (unknown, origin) in [(UnknownCells::Occupied, "0"), (UnknownCells::Free, "0.3")] {
        let yaml = YAML.replace("10, -4, 0", &format!("10, -4, {origin}")).replace("0.25", "0.19");
        let (_folder, path) = folder(&yaml, picture);
        let read = floor_plan::read(&path, unknown).unwrap();
        // Rows from below; 101 to 127 and what is less than 0 are no percentages.
        for nothing in [-1, -128, 101, 127] {
            let cells = [0, 25, 1, 0, nothing, 26];
            let origin = [10.0, -4.0, origin.parse().unwrap()];
            let plan = FloorPlan::from_occupancy(&cells, [3, 2], 0.5, origin, 25, unknown).unwrap();
            assert_eq!(plan.free_space(), read.free_space());
        }
    }
}

#[test]
fn cells_that_are_no_map_are_refused() {
    let map = |cells: &[i8], size, resolution, x, free_most| {
        let origin = [x, 0.0, 0.0];
        let unknown = UnknownCells::Occupied;
        FloorPlan::from_occupancy(cells, size, resolution, origin, free_most, unknown)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(map(&[0; 5], [3, 2], 0.5, 0.0, 25), "there are 5 cells, but 3 x 2 = 6 are needed");
    let most = "but at most 100000000 are allowed";
    let large = map(&[], [u32::MAX, u32::MAX], 0.5, 0.0, 25);
    assert_eq!(
        large,
        format!("the map has 4294967295 x 4294967295 = 18446744065119617025 cells, {most}")
    );
    assert_eq!(map(&[], [0, 2], 0.5, 0.0, 25), "the map has 0 x 2 cells, but needs at least 1 x 1");
    assert_eq!(map(&[26, -1], [2, 1], 0.5, 0.0, 25), "none of the map's 2 cells is free");
    let resolution = "must be a number of metres greater than 0";
    assert_eq!(map(&[0], [1, 1], -0.5, 0.0, 25), format!("resolution is -0.5, {resolution}"));
    assert_eq!(map(&[0], [1, 1], f64::NAN, 0.0, 25), format!("resolution is NaN, {resolution}"));
    assert_eq!(map(&[0], [1, 1], 0.5, f64::INFINITY, 25), "origin is inf, must be finite");
    let percentage = "free_most is 100, must be a percentage from 0 to 99";
    assert_eq!(map(&[0], [1, 1], 0.5, 0.0, 100), percentage);
}
