//! Frames, corners, path and limits on jerk of a scene request.

use super::cells::Malformed;
use super::codes;
use crate::message::{Corners, Frames, PathChoice, Pose, SampleFrame, SceneRequest, Vector};
use crate::wire::{RequestHeader, given};

/// Writes them into the header.
pub(super) fn write(scene: &SceneRequest, header: &mut RequestHeader) {
    if let Some(Frames { fixed, fixed_at_end, moving, samples }) = scene.frames {
        let frames = [
            (Some(fixed), given::FRAMES),
            (fixed_at_end, given::FIXED_AT_END),
            (moving, given::MOVING),
        ];
        for (cells, (pose, bit)) in header.frames.chunks_exact_mut(4).zip(frames) {
            let Some(Pose { position, heading }) = pose else { continue };
            header.given |= bit;
            cells[..3].copy_from_slice(&position.padded());
            cells[3] = heading;
        }
        if let Some(frame) = samples {
            header.given |= given::SAMPLE_FRAME;
            header.sample_frame = codes::code(SampleFrame::ALL, frame);
        }
    }
    if let Some(corners) = scene.corners {
        header.given |= given::CORNERS;
        header.corners = codes::code(Corners::ALL, corners);
    }
    if let Some(path) = scene.path {
        header.given |= given::PATH;
        header.path = codes::code(PathChoice::ALL, path);
    }
    for (index, (limit, bit)) in
        [(scene.limits.jerk, given::JERK), (scene.limits.yaw_jerk, given::YAW_JERK)]
            .into_iter()
            .enumerate()
    {
        if let Some(limit) = limit {
            header.given |= bit;
            header.jerks[index] = limit;
        }
    }
}

/// Reads them from the header.
pub(super) fn read(
    header: &RequestHeader,
    dimension: usize,
    scene: &mut SceneRequest,
) -> Result<(), Malformed> {
    let has = |bit: u64| header.given & bit != 0;
    let frame = |index: usize| {
        let cells = &header.frames[4 * index..4 * index + 4];
        Pose { position: Vector::new(&cells[..dimension]).unwrap_or_default(), heading: cells[3] }
    };
    scene.frames = match has(given::FRAMES) {
        true => Some(Frames {
            fixed: frame(0),
            fixed_at_end: has(given::FIXED_AT_END).then(|| frame(1)),
            moving: has(given::MOVING).then(|| frame(2)),
            samples: match has(given::SAMPLE_FRAME) {
                true => Some(codes::value(
                    "sample_frame",
                    SampleFrame::ALL,
                    header.sample_frame.into(),
                )?),
                false => None,
            },
        }),
        false => None,
    };
    scene.corners = match has(given::CORNERS) {
        true => Some(codes::value("corners", Corners::ALL, header.corners.into())?),
        false => None,
    };
    scene.path = match has(given::PATH) {
        true => Some(codes::value("path", PathChoice::ALL, header.path.into())?),
        false => None,
    };
    Ok(())
}
