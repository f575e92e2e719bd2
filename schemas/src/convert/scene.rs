//! Scene requests.

use super::cells::{CellReader, Malformed, demand};
use super::codes;
use super::dimension;
use super::manner;
use crate::message::{
    AxisBox, Body, Choice, ClearanceWish, Digest, Direction, Footprint, Gap, Goal, Limits, Pose,
    Refusal, Report, RequestKey, Sampling, SceneRequest, Solid, StartTurn, Task, Vector,
};
use crate::wire::{RequestHeader, VERSION, given, switch};

/// Writes a scene as memory: the header is returned, the payload appended to `cells`.
pub fn write_scene(
    scene: &SceneRequest,
    key: RequestKey,
    sent_ns: u64,
    cells: &mut Vec<u64>,
) -> Result<RequestHeader, Refusal> {
    let dimension = dimension(scene, &scene.free_space)?;
    let mut header = RequestHeader {
        version: VERSION,
        dimension,
        client: key.client,
        sequence: key.sequence,
        sent_ns,
        task: codes::code(Task::ALL, scene.task),
        exits: scene.exit.len() as u32,
        ..RequestHeader::default()
    };
    write_options(scene, &mut header);
    cells.extend(scene.exit.iter().map(|exit| u64::from(codes::code(Direction::ALL, *exit))));
    write_wish(&scene.clearance, &mut header, cells);
    write_body(&scene.body, &mut header, cells);
    if let Some(channels) = &scene.free_space.channels {
        header.given |= given::CHANNELS;
        header.channels = channels.len() as u64;
        channels.iter().for_each(|channel| push_box(cells, channel));
    }
    if let Some(solids) = &scene.free_space.solids {
        header.given |= given::SOLIDS;
        header.solids = solids.len() as u64;
        for solid in solids {
            match solid {
                Solid::Polygon(vertices) => {
                    cells.extend([0, vertices.len() as u64]);
                    vertices.iter().for_each(|vertex| push_point(cells, vertex));
                }
                Solid::Box(sides) => {
                    cells.push(1);
                    push_box(cells, sides);
                }
                Solid::Boxes(boxes) => {
                    cells.extend([2, boxes.len() as u64]);
                    boxes.iter().for_each(|sides| push_box(cells, sides));
                }
            }
        }
    }
    Ok(header)
}

fn write_options(scene: &SceneRequest, header: &mut RequestHeader) {
    if let Some(id) = scene.id {
        header.given |= given::ID;
        header.id = id;
    }
    if scene.free_space.in_order {
        header.given |= given::IN_ORDER;
    }
    if let Some(bounds) = &scene.free_space.bounds {
        header.given |= given::BOUNDS;
        let coordinates = bounds.min.as_slice().iter().chain(bounds.max.as_slice());
        header.bounds.iter_mut().zip(coordinates).for_each(|(cell, value)| *cell = *value);
    }
    if let Some(Pose { position, heading }) = scene.start {
        header.given |= given::START;
        header.start = place(&position, heading);
    }
    if let Some(Goal { position, heading }) = scene.goal {
        header.given |= given::GOAL;
        header.goal = place(&position, heading.unwrap_or(0.0));
        header.given |= heading.map_or(0, |_| given::GOAL_HEADING);
    }
    if let Some(start_turn) = scene.start_turn {
        header.given |= given::START_TURN;
        header.start_turn = codes::code(StartTurn::ALL, start_turn);
    }
    write_robot(scene, header);
    manner::write(scene, header);
    if let Some(sampling) = scene.sampling {
        header.given |= given::SAMPLING;
        (header.sampling_kind, header.sampling) = match sampling {
            Sampling::Period(period) => (0, period.to_bits()),
            Sampling::Spacing(spacing) => (1, spacing.to_bits()),
            Sampling::Count(count) => (2, count),
        };
    }
    if let Some(deadline) = scene.deadline {
        header.given |= given::DEADLINE;
        header.deadline = deadline;
    }
    let limits = &scene.limits;
    let limits = [
        limits.speed,
        limits.acceleration,
        limits.yaw_rate,
        limits.yaw_acceleration,
        limits.lateral_acceleration,
    ];
    for (index, limit) in limits.into_iter().enumerate() {
        if let Some(limit) = limit {
            header.given |= given::LIMITS << index;
            header.limits[index] = limit;
        }
    }
}

fn write_robot(scene: &SceneRequest, header: &mut RequestHeader) {
    for (value, bit, switch) in [
        (scene.reverse, given::REVERSE, switch::REVERSE),
        (scene.turn_in_place, given::TURN_IN_PLACE, switch::TURN_IN_PLACE),
        (scene.stop_at_joints, given::STOP_AT_JOINTS, switch::STOP_AT_JOINTS),
    ] {
        header.given |= value.map_or(0, |_| bit);
        header.switches |= if value == Some(true) { switch } else { 0 };
    }
    for (value, bit, place) in [
        (scene.min_turn_radius, given::MIN_TURN_RADIUS, &mut header.min_turn_radius),
        (scene.turn_cost, given::TURN_COST, &mut header.turn_cost),
        (scene.stop_cost, given::STOP_COST, &mut header.stop_cost),
    ] {
        header.given |= value.map_or(0, |_| bit);
        *place = value.unwrap_or(0.0);
    }
    if let Some(report) = scene.report {
        header.given |= given::REPORT;
        header.report = codes::code(Report::ALL, report);
    }
    if let Some(Digest(bytes)) = scene.free_space.named {
        header.given |= given::NAMED;
        header.named = bytes;
    }
}

/// A position in the plane and the heading there; in space, where parts do not turn, the position.
fn place(position: &Vector, heading: f64) -> [f64; 3] {
    match position.padded() {
        [x, y, _] if position.dimension() < 3 => [x, y, heading],
        spatial => spatial,
    }
}

fn write_wish(wish: &ClearanceWish, header: &mut RequestHeader, cells: &mut Vec<u64>) {
    (header.wish_kind, header.choices) = match wish {
        ClearanceWish::Each(choices) => (1, choices.len() as u64),
        ClearanceWish::Curve(points) => {
            header.curve = *points;
            (2, 0)
        }
        _ => (0, 1),
    };
    match wish {
        ClearanceWish::Gap(gap) => push_gap_choice(cells, gap),
        ClearanceWish::Gaps(gaps) => push_gaps_choice(cells, gaps),
        ClearanceWish::Safest => cells.push(2),
        ClearanceWish::AtLeast(clearance) => cells.extend([3, clearance.to_bits()]),
        ClearanceWish::Each(choices) => {
            for choice in choices {
                match choice {
                    Choice::Gap(gap) => push_gap_choice(cells, gap),
                    Choice::Gaps(gaps) => push_gaps_choice(cells, gaps),
                    Choice::Safest => cells.push(2),
                    Choice::AtLeast(clearance) => cells.extend([3, clearance.to_bits()]),
                }
            }
        }
        ClearanceWish::Curve(_) => {}
    }
}

fn push_gap_choice(cells: &mut Vec<u64>, gap: &Gap) {
    cells.push(0);
    push_gap(cells, gap);
}

fn push_gaps_choice(cells: &mut Vec<u64>, gaps: &[Gap]) {
    cells.extend([1, gaps.len() as u64]);
    gaps.iter().for_each(|gap| push_gap(cells, gap));
}

fn push_gap(cells: &mut Vec<u64>, gap: &Gap) {
    match gap {
        Gap::Uniform(gap) => cells.extend([0, gap.to_bits()]),
        Gap::PerAxis(gaps) => {
            cells.push(gaps.dimension() as u64);
            push_point(cells, gaps);
        }
    }
}

fn write_body(body: &Body, header: &mut RequestHeader, cells: &mut Vec<u64>) {
    (header.body_kind, header.body_points) = match body {
        Body::Polygon(vertices) => {
            vertices.iter().for_each(|vertex| push_point(cells, vertex));
            (0, vertices.len() as u64)
        }
        Body::Box(sides) => {
            push_box(cells, sides);
            (1, 2)
        }
        Body::Footprint(Footprint::Centered { width, length }) => {
            cells.extend([width.to_bits(), length.to_bits()]);
            (2, 1)
        }
        Body::Footprint(Footprint::Offset { width, front, rear }) => {
            header.given |= given::REAR;
            header.rear = *rear;
            cells.extend([width.to_bits(), front.to_bits()]);
            (2, 1)
        }
        Body::Boxes(boxes) => {
            boxes.iter().for_each(|sides| push_box(cells, sides));
            (3, 2 * boxes.len() as u64)
        }
    };
}

fn push_point(cells: &mut Vec<u64>, point: &Vector) {
    cells.extend(point.as_slice().iter().map(|value| value.to_bits()));
}

fn push_box(cells: &mut Vec<u64>, sides: &AxisBox) {
    push_point(cells, &sides.min);
    push_point(cells, &sides.max);
}

/// Reads a scene from memory into `scene`, reusing the memory it holds. On failure the
/// content of `scene` is unspecified.
pub fn read_scene(
    header: &RequestHeader,
    cells: &[u64],
    scene: &mut SceneRequest,
) -> Result<(), Malformed> {
    if !(2..=3).contains(&header.dimension) {
        let code = u64::from(header.dimension);
        return Err(Malformed::UnknownCode { what: "dimension", code, greatest: 3 });
    }
    if header.given & !given::ALL != 0 {
        let code = header.given;
        return Err(Malformed::UnknownCode { what: "given", code, greatest: given::ALL });
    }
    if header.switches & !switch::ALL != 0 {
        let (code, greatest) = (header.switches.into(), switch::ALL.into());
        return Err(Malformed::UnknownCode { what: "switches", code, greatest });
    }
    let has = |bit: u64| header.given & bit != 0;
    let dimension = header.dimension as usize;
    let mut cells = CellReader::new(cells);
    read_options(header, dimension, scene)?;
    scene.exit.clear();
    for code in cells.take("exits", u64::from(header.exits), 1)? {
        scene.exit.push(codes::value("exit", Direction::ALL, *code)?);
    }
    read_wish(header, &mut cells, &mut scene.clearance)?;
    read_body(header, dimension, &mut cells, &mut scene.body)?;

    let taken = cells.take("channels", header.channels, 2 * dimension)?;
    if has(given::CHANNELS) {
        let channels = scene.free_space.channels.get_or_insert_default();
        fill_boxes(channels, taken, dimension);
    } else {
        demand("channels", header.channels, 0, "if none are given")?;
        scene.free_space.channels = None;
    }

    if has(given::SOLIDS) {
        cells.expect("solids", header.solids)?;
        let solids = scene.free_space.solids.get_or_insert_default();
        solids.truncate(header.solids as usize);
        for index in 0..header.solids as usize {
            if index == solids.len() {
                solids.push(Solid::Box(AxisBox::default()));
            }
            read_solid(dimension, &mut cells, &mut solids[index])?;
        }
    } else {
        demand("solids", header.solids, 0, "if none are given")?;
        scene.free_space.solids = None;
    }
    cells.end()
}

fn read_options(
    header: &RequestHeader,
    dimension: usize,
    scene: &mut SceneRequest,
) -> Result<(), Malformed> {
    let has = |bit: u64| header.given & bit != 0;
    scene.id = has(given::ID).then_some(header.id);
    scene.task = codes::value("task", Task::ALL, header.task.into())?;
    scene.free_space.in_order = has(given::IN_ORDER);
    scene.free_space.bounds = has(given::BOUNDS).then(|| AxisBox {
        min: numbers(&header.bounds[..dimension]),
        max: numbers(&header.bounds[dimension..2 * dimension]),
    });
    // In space there is no heading.
    let heading = |place: [f64; 3]| if dimension == 2 { place[2] } else { 0.0 };
    scene.start = has(given::START).then(|| Pose {
        position: numbers(&header.start[..dimension]),
        heading: heading(header.start),
    });
    scene.goal = has(given::GOAL).then(|| Goal {
        position: numbers(&header.goal[..dimension]),
        heading: has(given::GOAL_HEADING).then_some(heading(header.goal)),
    });
    scene.start_turn = match has(given::START_TURN) {
        true => Some(codes::value("start_turn", StartTurn::ALL, header.start_turn.into())?),
        false => None,
    };
    let switch = |bit, switch: u32| has(bit).then_some(header.switches & switch != 0);
    scene.reverse = switch(given::REVERSE, switch::REVERSE);
    scene.turn_in_place = switch(given::TURN_IN_PLACE, switch::TURN_IN_PLACE);
    scene.stop_at_joints = switch(given::STOP_AT_JOINTS, switch::STOP_AT_JOINTS);
    scene.min_turn_radius = has(given::MIN_TURN_RADIUS).then_some(header.min_turn_radius);
    scene.turn_cost = has(given::TURN_COST).then_some(header.turn_cost);
    scene.stop_cost = has(given::STOP_COST).then_some(header.stop_cost);
    scene.report = match has(given::REPORT) {
        true => Some(codes::value("report", Report::ALL, header.report.into())?),
        false => None,
    };
    scene.free_space.named = has(given::NAMED).then_some(Digest(header.named));
    scene.sampling = match (has(given::SAMPLING), header.sampling_kind) {
        (false, _) => None,
        (true, 0) => Some(Sampling::Period(f64::from_bits(header.sampling))),
        (true, 1) => Some(Sampling::Spacing(f64::from_bits(header.sampling))),
        (true, 2) => Some(Sampling::Count(header.sampling)),
        (true, code) => {
            let code = code.into();
            return Err(Malformed::UnknownCode { what: "sampling_kind", code, greatest: 2 });
        }
    };
    scene.deadline = has(given::DEADLINE).then_some(header.deadline);
    let limit = |index: usize| has(given::LIMITS << index).then_some(header.limits[index]);
    scene.limits = Limits {
        speed: limit(0),
        acceleration: limit(1),
        yaw_rate: limit(2),
        yaw_acceleration: limit(3),
        lateral_acceleration: limit(4),
        jerk: has(given::JERK).then_some(header.jerks[0]),
        yaw_jerk: has(given::YAW_JERK).then_some(header.jerks[1]),
    };
    manner::read(header, dimension, scene)
}

fn read_wish(
    header: &RequestHeader,
    cells: &mut CellReader,
    wish: &mut ClearanceWish,
) -> Result<(), Malformed> {
    match header.wish_kind {
        0 => {
            demand("choices", header.choices, 1, "for a single clearance")?;
            let mut choice = match std::mem::replace(wish, ClearanceWish::Safest) {
                ClearanceWish::Gaps(gaps) => Choice::Gaps(gaps),
                _ => Choice::Safest,
            };
            read_choice(cells, &mut choice)?;
            *wish = match choice {
                Choice::Gap(gap) => ClearanceWish::Gap(gap),
                Choice::Gaps(gaps) => ClearanceWish::Gaps(gaps),
                Choice::Safest => ClearanceWish::Safest,
                Choice::AtLeast(clearance) => ClearanceWish::AtLeast(clearance),
            };
        }
        1 => {
            cells.expect("choices", header.choices)?;
            if !matches!(wish, ClearanceWish::Each(_)) {
                *wish = ClearanceWish::Each(Vec::new());
            }
            if let ClearanceWish::Each(choices) = wish {
                choices.truncate(header.choices as usize);
                for index in 0..header.choices as usize {
                    if index == choices.len() {
                        choices.push(Choice::Safest);
                    }
                    read_choice(cells, &mut choices[index])?;
                }
            }
        }
        2 => {
            demand("choices", header.choices, 0, "for a curve")?;
            *wish = ClearanceWish::Curve(header.curve);
        }
        code => {
            let code = code.into();
            return Err(Malformed::UnknownCode { what: "wish_kind", code, greatest: 2 });
        }
    }
    Ok(())
}

fn read_choice(cells: &mut CellReader, choice: &mut Choice) -> Result<(), Malformed> {
    match cells.next("choice")? {
        0 => *choice = Choice::Gap(read_gap(cells)?),
        1 => {
            let count = cells.count("gaps")?;
            if !matches!(choice, Choice::Gaps(_)) {
                *choice = Choice::Gaps(Vec::new());
            }
            if let Choice::Gaps(gaps) = choice {
                gaps.clear();
                for _ in 0..count {
                    gaps.push(read_gap(cells)?);
                }
            }
        }
        2 => *choice = Choice::Safest,
        3 => *choice = Choice::AtLeast(f64::from_bits(cells.next("choice")?)),
        code => return Err(Malformed::UnknownCode { what: "choice", code, greatest: 3 }),
    }
    Ok(())
}

fn read_gap(cells: &mut CellReader) -> Result<Gap, Malformed> {
    match cells.next("gap")? {
        0 => Ok(Gap::Uniform(f64::from_bits(cells.next("gap")?))),
        count @ 1..=3 => Ok(Gap::PerAxis(point(cells.take("gap", count, 1)?))),
        code => Err(Malformed::UnknownCode { what: "gap", code, greatest: 3 }),
    }
}

fn read_body(
    header: &RequestHeader,
    dimension: usize,
    cells: &mut CellReader,
    body: &mut Body,
) -> Result<(), Malformed> {
    let taken = cells.take("body", header.body_points, dimension)?;
    match header.body_kind {
        0 => {
            if !matches!(body, Body::Polygon(_)) {
                *body = Body::Polygon(Vec::new());
            }
            if let Body::Polygon(vertices) = body {
                fill_points(vertices, taken, dimension);
            }
        }
        1 => {
            demand("body_points", header.body_points, 2, "for a box")?;
            *body = Body::Box(axis_box(taken, dimension));
        }
        2 => {
            demand("dimension", header.dimension, 2, "for a footprint")?;
            demand("body_points", header.body_points, 1, "for a footprint")?;
            let (width, along) = (f64::from_bits(taken[0]), f64::from_bits(taken[1]));
            *body = Body::Footprint(match header.given & given::REAR {
                0 => Footprint::Centered { width, length: along },
                _ => Footprint::Offset { width, front: along, rear: header.rear },
            });
        }
        3 => {
            let boxes = header.body_points / 2;
            demand("body_points", header.body_points, 2 * boxes, "for boxes")?;
            if !matches!(body, Body::Boxes(_)) {
                *body = Body::Boxes(Vec::new());
            }
            if let Body::Boxes(boxes) = body {
                fill_boxes(boxes, taken, dimension);
            }
        }
        code => {
            let code = code.into();
            return Err(Malformed::UnknownCode { what: "body_kind", code, greatest: 3 });
        }
    }
    Ok(())
}

fn read_solid(
    dimension: usize,
    cells: &mut CellReader,
    solid: &mut Solid,
) -> Result<(), Malformed> {
    match cells.next("solid")? {
        0 => {
            let count = cells.next("solid")?;
            let taken = cells.take("solid", count, dimension)?;
            if !matches!(solid, Solid::Polygon(_)) {
                *solid = Solid::Polygon(Vec::new());
            }
            if let Solid::Polygon(vertices) = solid {
                fill_points(vertices, taken, dimension);
            }
        }
        1 => *solid = Solid::Box(axis_box(cells.take("solid", 2, dimension)?, dimension)),
        2 => {
            let count = cells.next("solid")?;
            let taken = cells.take("solid", count, 2 * dimension)?;
            if !matches!(solid, Solid::Boxes(_)) {
                *solid = Solid::Boxes(Vec::new());
            }
            if let Solid::Boxes(boxes) = solid {
                fill_boxes(boxes, taken, dimension);
            }
        }
        code => return Err(Malformed::UnknownCode { what: "solid", code, greatest: 2 }),
    }
    Ok(())
}

fn fill_points(points: &mut Vec<Vector>, cells: &[u64], dimension: usize) {
    points.clear();
    points.extend(cells.chunks_exact(dimension).map(point));
}

fn fill_boxes(boxes: &mut Vec<AxisBox>, cells: &[u64], dimension: usize) {
    boxes.clear();
    boxes.extend(cells.chunks_exact(2 * dimension).map(|cells| axis_box(cells, dimension)));
}

fn axis_box(cells: &[u64], dimension: usize) -> AxisBox {
    AxisBox { min: point(&cells[..dimension]), max: point(&cells[dimension..]) }
}

fn point(cells: &[u64]) -> Vector {
    let number = f64::from_bits;
    match *cells {
        [x, y] => [number(x), number(y)].into(),
        [x, y, z] => [number(x), number(y), number(z)].into(),
        _ => numbers(bytemuck::cast_slice(cells)),
    }
}

fn numbers(values: &[f64]) -> Vector {
    Vector::new(values).expect("callers pass one to three numbers")
}
