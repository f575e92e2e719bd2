//! What is moved, and how.

use planning::clearance::translating::Body;
use planning::disassembly;
use planning::free_space::End;
use planning::geometry::{AxisBox, Direction};
use planning::route::{BodyMover, Mover, RouteError};
use planning::trajectory::{CornerShape, Stops};
use schemas::message::{Corners, Refusal};

use super::body::narrower_boxes;
use super::frames::Ends;
use super::slide::Slide;
use crate::answers::{Pace, Resources};
use crate::check;
use crate::free_space::{Explain, FreeSpace, Source, closed_to_union};
use crate::refuse::{Axes, Refused};
use crate::scene::Scene;
use crate::wish::Wishes;

/// What is moved, and how.
#[derive(Debug, Clone, Copy)]
pub(super) struct Terms<'a, const D: usize> {
    pub(super) scene: Scene<'a>,
    pub(super) axes: Axes,
    pub(super) body: Body<'a, D>,
    /// What finds a way without channels, if anything does.
    pub(super) slide: Option<&'a dyn Slide<D>>,
    pub(super) ends: &'a Ends<D>,
    pub(super) pace: Pace,
}

impl<'a, const D: usize> Terms<'a, D> {
    pub(super) fn new(
        scene: Scene<'a>,
        axes: Axes,
        (body, slide, ends): (Body<'a, D>, Option<&'a dyn Slide<D>>, &'a Ends<D>),
        wishes: &Wishes<'_>,
    ) -> Result<Self, Refusal> {
        let stops = match scene.corners {
            Some(Corners::Arc | Corners::Smooth) if D == 2 => Stops::AtKinks,
            Some(Corners::Arc | Corners::Smooth) => {
                let message = "corners: arcs and smooth corners are for two dimensions; in three, \
                               parts stop at every way-point";
                return Err(Refusal::invalid("corners", message));
            }
            Some(Corners::Sharp) | None => Stops::EveryLeg,
        };
        Ok(Self { scene, axes, body, slide, ends, pace: Pace::of(scene, wishes, stops)? })
    }

    /// What corners are rounded with, if they are.
    pub(super) fn corner_shape(&self) -> Option<CornerShape> {
        match self.scene.corners {
            Some(Corners::Arc) => Some(CornerShape::Arc),
            Some(Corners::Smooth) => Some(CornerShape::Clothoids),
            Some(Corners::Sharp) | None => None,
        }
    }

    /// The free space for a way out, for a body of these bounds. Whatever is refused, no gap would
    /// help.
    pub(super) fn open(
        &self,
        (exit, bounds): (Direction, &AxisBox<D>),
        source: &mut Source<'a, D>,
        explain: Explain,
        resources: &mut Resources<'_>,
    ) -> Result<FreeSpace<'a, D>, Refused> {
        let axes = &self.axes;
        let is_union = self.body.is_union();
        let space = source.open(|cut| {
            if is_union {
                let boxes = narrower_boxes(&self.body, bounds);
                return cut.make_for_union((&boxes, *bounds), exit, axes, resources);
            }
            let cavity = cut.cavity(bounds, exit).ok_or_else(|| {
                let message = "free_space.solids enclose no cavity";
                Refusal::invalid("free_space.solids", message)
            })?;
            cut.make(cavity, bounds.size(), resources)
        });
        let space = space.map_err(Refused::whole)?;
        let (Source::Solids(cut), FreeSpace::Made(made)) = (source, &space) else {
            return Ok(space);
        };
        if let Err(refusal) = check::mouth(axes, space.channels(), made.bounds(), exit) {
            if is_union {
                return Err(closed_to_union(axes, String::new(), RouteError::NoChannels));
            }
            let mover = BodyMover::new(bounds, disassembly::Gap::Safest, End::Exit(exit));
            return Err(match mover {
                Ok(mover) if explain == Explain::Fully => {
                    cut.refuse_mouth(made, axes, refusal, mover.traveller(), resources)
                }
                _ => Refused::Request(refusal),
            });
        }
        Ok(space)
    }
}
