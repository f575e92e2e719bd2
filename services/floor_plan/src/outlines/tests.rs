use proptest::prelude::*;

use super::*;

/// Drawn as people see it, the last row has the least y.
fn draw(rows: &[&str]) -> (CellSet, [usize; 2]) {
    let size = [rows[0].len(), rows.len()];
    let solid = |x: usize, y: usize| rows[size[1] - 1 - y].as_bytes()[x] == b'#';
    (cells(size, solid), size)
}

fn cells([width, height]: [usize; 2], solid: impl Fn(usize, usize) -> bool) -> CellSet {
    let mut cells = CellSet::new(width, height);
    for y in 0..height {
        for x in (0..width).filter(|x| solid(*x, y)) {
            cells.row_mut(y)[x / 64] |= 1 << (x % 64);
        }
    }
    cells
}

#[track_caller]
fn outlines(rows: &[&str], shared: SharedVertices) -> Vec<Vec<[u32; 2]>> {
    let (cells, size) = draw(rows);
    let outlines = trace(&cells, size, shared, usize::MAX).unwrap();
    check(&cells, size, &outlines, shared);
    outlines.iter().map(<[_]>::to_vec).collect()
}

/// How many vertices each outline has.
#[track_caller]
fn counts(rows: &[&str]) -> Vec<usize> {
    outlines(rows, SharedVertices::Kept);
    outlines(rows, SharedVertices::Dropped).iter().map(Vec::len).collect()
}

/// How often an outline winds around the middle of a cell, from the crossings of the ray to
/// the right.
fn winding(outline: &[[u32; 2]], x: usize, y: usize) -> i32 {
    let sides = outline.iter().zip(outline.iter().cycle().skip(1));
    let crossings =
        sides.filter(|([ax, _], [bx, _])| ax == bx && *ax as usize > x).map(|(a, b)| {
            let (a, b) = (a[1] as usize, b[1] as usize);
            i32::from(a <= y && y < b) - i32::from(b <= y && y < a)
        });
    crossings.sum()
}

/// That outlines are simple polygons, don't overlap, and are exactly the cells.
fn check(cells: &CellSet, [width, height]: [usize; 2], found: &Outlines, shared: SharedVertices) {
    let total: usize = found.iter().map(<[_]>::len).sum();
    assert_eq!(found.vertices(), total);
    for y in 0..height {
        for x in 0..width {
            let times: Vec<i32> = found.iter().map(|outline| winding(outline, x, y)).collect();
            assert!(times.iter().all(|times| (0..=1).contains(times)), "{x}, {y}: {times:?}");
            let expected = i32::from(cells.contains(x, y));
            assert_eq!(times.iter().sum::<i32>(), expected, "{x}, {y}");
        }
    }
    for outline in found.iter() {
        check_is_simple(outline, shared);
    }
}

/// That no point of unit length is passed twice; sides are parallel to the axes.
fn check_is_simple(outline: &[[u32; 2]], shared: SharedVertices) {
    assert!(outline.len() >= 4, "{outline:?}");
    let mut passed = std::collections::HashSet::new();
    let count = outline.len();
    for (index, [ax, ay]) in outline.iter().copied().enumerate() {
        let [bx, by] = outline[(index + 1) % count];
        assert!((ax == bx) != (ay == by), "a side of {outline:?}");
        if shared == SharedVertices::Dropped {
            let [cx, cy] = outline[(index + 2) % count];
            assert!((ax != cx) && (ay != cy), "collinear: {outline:?}");
        }
        let steps = ax.abs_diff(bx) + ay.abs_diff(by);
        let signum = |a: u32, b: u32| (i64::from(b) - i64::from(a)).signum();
        let (dx, dy) = (signum(ax, bx), signum(ay, by));
        for step in 0..i64::from(steps) {
            let point = (i64::from(ax) + step * dx, i64::from(ay) + step * dy);
            assert!(passed.insert(point), "{point:?} twice in {outline:?}");
        }
    }
}

#[test]
fn a_full_grid_is_one_rectangle() {
    let expected = vec![vec![[0, 0], [3, 0], [3, 2], [0, 2]]];
    assert_eq!(outlines(&["###", "###"], SharedVertices::Dropped), expected);
}

#[test]
fn an_empty_grid_has_no_outlines() {
    assert!(outlines(&["..", ".."], SharedVertices::Dropped).is_empty());
}

#[test]
fn steps_in_line_are_merged() {
    assert_eq!(counts(&["#..", "#..", "###"]), [6]);
    assert_eq!(counts(&[".##.", "####", ".##."]), [12]);
}

#[test]
fn cells_that_touch_at_a_corner_are_apart() {
    assert_eq!(counts(&["#.", ".#"]), [4, 4]);
    assert_eq!(counts(&[".#", "#."]), [4, 4]);
    assert_eq!(counts(&["#.#", ".#.", "#.#"]), [4, 4, 4, 4, 4]);
}

#[test]
fn a_ring_is_cut_into_two() {
    assert_eq!(counts(&["####", "#..#", "#..#", "####"]), [4, 8]);
    let kept = outlines(&["####", "#..#", "#..#", "####"], SharedVertices::Kept);
    assert_eq!(kept[0], [[0, 0], [4, 0], [4, 1], [3, 1], [1, 1], [0, 1]]);
}

#[test]
fn a_ring_that_touches_itself_at_a_corner_is_cut() {
    assert_eq!(counts(&["###", "#.#", "##."]), [4, 8]);
    assert_eq!(counts(&["###", "#.#", ".##"]), [4, 8]);
    // Above the cuts, the cell beside the hole touches the rest at a corner only.
    assert_eq!(counts(&[".##", "#.#", "###"]), [4, 4, 6]);
    assert_eq!(counts(&["##.", "#.#", "###"]), [4, 6, 4]);
}

#[test]
fn islands_in_rings_are_outlines_of_their_own() {
    let rows = ["#######", "#.....#", "#.###.#", "#.#.#.#", "#.###.#", "#.....#", "#######"];
    assert_eq!(counts(&rows), [4, 8, 4, 8]);
}

#[test]
fn holes_on_one_line_share_the_cut_between_them() {
    assert_eq!(counts(&["#####", "#.#.#", "#####"]), [4, 12]);
}

#[test]
fn too_many_corners_are_counted() {
    let (cells, size) = draw(&["#.#.", ".#.#"]);
    assert_eq!(trace(&cells, size, SharedVertices::Dropped, 15), Err(16));
    assert!(trace(&cells, size, SharedVertices::Dropped, 16).is_ok());
}

fn grids() -> impl Strategy<Value = (CellSet, [usize; 2])> {
    let sizes = (1usize..24, 1usize..24, 0.0..1.0f64);
    let fine = sizes.prop_flat_map(|(width, height, density)| {
        let cells = prop::collection::vec(prop::bool::weighted(density), width * height);
        cells.prop_map(move |solid| ([width, height], solid))
    });
    // Scaled up they also have long sides, and rows of more than a word.
    (fine, 1usize..5).prop_map(|(([width, height], solid), scale)| {
        let size = [width * scale, height * scale];
        (cells(size, |x, y| solid[y / scale * width + x / scale]), size)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn outlines_are_simple_and_exactly_the_cells((cells, size) in grids()) {
        for shared in [SharedVertices::Dropped, SharedVertices::Kept] {
            let outlines = trace(&cells, size, shared, usize::MAX).unwrap();
            check(&cells, size, &outlines, shared);
        }
    }

    #[test]
    fn outlines_share_whole_sides_where_vertices_are_kept((cells, size) in grids()) {
        let outlines = trace(&cells, size, SharedVertices::Kept, usize::MAX).unwrap();
        // Of two polygons that touch along a cut, each side is one of the other's, too.
        let sides: std::collections::HashSet<_> = outlines
            .iter()
            .flat_map(|outline| outline.iter().zip(outline.iter().cycle().skip(1)))
            .collect();
        for ([ax, ay], [bx, by]) in sides.iter().copied() {
            let filled = |x: u32, y: u32| match (x.checked_sub(1), y.checked_sub(1)) {
                (Some(x), Some(y)) => (y as usize) < size[1] && cells.contains(x as usize, y as usize),
                _ => false,
            };
            // The cell to the right of the side's first step.
            let right = match (ax.cmp(bx), ay.cmp(by)) {
                (std::cmp::Ordering::Less, _) => filled(ax + 1, *ay),
                (std::cmp::Ordering::Greater, _) => filled(*ax, ay + 1),
                (_, std::cmp::Ordering::Less) => filled(ax + 1, ay + 1),
                _ => filled(*ax, *ay),
            };
            let is_cut = sides.contains(&(&[*bx, *by], &[*ax, *ay]));
            prop_assert_eq!(right, is_cut, "{:?} to {:?}", [ax, ay], [bx, by]);
        }
    }
}
