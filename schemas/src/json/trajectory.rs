//! Trajectories in JSON.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};
use std::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeSeq;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::values::{List, Numbers, Point, Word};
use crate::message::{
    AxisBox, Clearance, Direction, ExceededLimit, Exceeds, Leg, Sample, Trajectory, Vector,
};

/// A planned motion of the body.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema), schemars(rename = "trajectory"))]
#[serde(deny_unknown_fields)]
pub(super) struct TrajectoryJson<'a> {
    /// The gap used at each junction, in travel order: for assembly tasks a number per axis, for
    /// `drive` one number; metres.
    gap: GapsJson<'a>,
    /// Indices of the channels travelled, in travel order.
    route: Cow<'a, [u64]>,
    /// The channels that `route` counts, where the planner made them.
    #[serde(skip_serializing_if = "Option::is_none")]
    channels: Option<List<'a, AxisBox>>,
    /// The direction taken out of the part, where the request gave several.
    #[serde(skip_serializing_if = "Option::is_none")]
    exit: Option<Word<Direction>>,
    /// Arc length, metres.
    length: f64,
    /// Length of the shortest curve of the reference point that keeps the same free clearance,
    /// metres: no drive that keeps it is shorter.
    #[serde(skip_serializing_if = "Option::is_none")]
    bound: Option<f64>,
    /// Present, and false, where the budget was spent before the search ended: a shorter
    /// trajectory may exist.
    #[serde(skip_serializing_if = "Option::is_none")]
    complete: Option<bool>,
    /// Seconds.
    duration: f64,
    /// How close the body comes to the walls.
    clearance: ClearanceJson,
    /// Distance that the body keeps from the walls, apart from those that it is closer to at the
    /// start or the goal, metres.
    #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "json-schema", schemars(with = "Distance"))]
    free_clearance: Option<Distance>,
    /// The pieces of the path, in travel order.
    legs: List<'a, Leg>,
    /// The limit that the motion does not obey, where the request has `corners`, or `"report"` is
    /// `"full"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    exceeds: Option<ExceedsJson>,
    /// Where `corners` is `"smooth"`: at how many joints of legs the body stops because no smooth
    /// corner fits, other than at turns in place and changes of gear.
    #[serde(skip_serializing_if = "Option::is_none")]
    stops: Option<u64>,
    /// States of the motion; their times strictly increase.
    samples: SamplesJson<'a>,
}

/// A limit that a motion does not obey.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema), schemars(rename = "exceeds"))]
#[serde(deny_unknown_fields)]
struct ExceedsJson {
    /// The limit.
    limit: Word<ExceededLimit>,
    /// At how many joints of legs.
    joints: u64,
    /// The greatest jump there of the yaw rate, rad/s.
    jump: f64,
}

impl From<Exceeds> for ExceedsJson {
    fn from(Exceeds { limit, joints, jump }: Exceeds) -> Self {
        Self { limit: Word(limit), joints, jump }
    }
}

impl From<ExceedsJson> for Exceeds {
    fn from(ExceedsJson { limit: Word(limit), joints, jump }: ExceedsJson) -> Self {
        Self { limit, joints, jump }
    }
}

impl<'a> From<&'a Trajectory> for TrajectoryJson<'a> {
    fn from(trajectory: &'a Trajectory) -> Self {
        let Trajectory {
            dimension,
            gaps_per_junction,
            exit,
            length,
            bound,
            complete,
            duration,
            clearance,
            free_clearance,
            gaps,
            route,
            channels,
            legs,
            samples,
            exceeds,
            stops,
        } = trajectory;
        Self {
            gap: GapsJson { gaps: gaps.into(), each: *gaps_per_junction as usize },
            route: route.into(),
            channels: (!channels.is_empty()).then(|| channels.as_slice().into()),
            exit: exit.map(Word),
            length: *length,
            bound: *bound,
            complete: (!complete).then_some(false),
            duration: *duration,
            clearance: (*clearance).into(),
            free_clearance: free_clearance.map(Distance),
            legs: legs.as_slice().into(),
            exceeds: exceeds.map(ExceedsJson::from),
            stops: *stops,
            samples: SamplesJson {
                samples: samples.into(),
                dimension: (*dimension as usize).min(Vector::MOST),
            },
        }
    }
}

impl TrajectoryJson<'_> {
    pub(super) fn into_message<E: Error>(self) -> Result<Trajectory, E> {
        let Self {
            gap,
            route,
            channels,
            exit,
            length,
            bound,
            complete,
            duration,
            clearance,
            free_clearance,
            legs,
            exceeds,
            stops,
            samples,
        } = self;
        let clearance = Clearance::from(clearance);
        let dimension = clearance.wall.dimension();
        let SamplesJson { samples, dimension: of_samples } = samples;
        if !samples.is_empty() && of_samples != dimension {
            return Err(E::custom(format_args!(
                "has positions of {of_samples} numbers in `samples`, but of {dimension} in \
                 `clearance.wall`"
            )));
        }
        Ok(Trajectory {
            dimension: dimension as u32,
            gaps_per_junction: gap.each as u32,
            exit: exit.map(|Word(exit)| exit),
            length,
            bound,
            complete: complete.unwrap_or(true),
            duration,
            clearance,
            free_clearance: free_clearance.map(|Distance(distance)| distance),
            gaps: gap.gaps.into_owned(),
            route: route.into_owned(),
            channels: channels.map_or_else(Vec::new, Vec::from),
            legs: legs.into(),
            samples: samples.into_owned(),
            exceeds: exceeds.map(Exceeds::from),
            stops,
        })
    }
}

/// How close the body comes to the walls, and where.
#[derive(Serialize, Deserialize)]
#[cfg_attr(
    feature = "json-schema",
    derive(schemars::JsonSchema),
    schemars(rename = "nearest_wall")
)]
#[serde(deny_unknown_fields)]
struct ClearanceJson {
    /// Exact least distance between the body and the walls over the whole motion, metres.
    value: Distance,
    /// Arc length at which it is met, metres.
    at: f64,
    /// The point of the wall that is this close, metres.
    wall: Point,
}

impl From<Clearance> for ClearanceJson {
    fn from(Clearance { value, at, wall }: Clearance) -> Self {
        Self { value: Distance(value), at, wall: Numbers(wall) }
    }
}

impl From<ClearanceJson> for Clearance {
    fn from(ClearanceJson { value, at, wall }: ClearanceJson) -> Self {
        Self { value: value.0, at, wall: wall.0 }
    }
}

/// A field that is there, whatever its value: `null` is a distance.
fn present<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Distance>, D::Error> {
    Distance::deserialize(deserializer).map(Some)
}

/// A distance to the walls, `null` where there are none: JSON has no infinity.
#[derive(Serialize, Clone, Copy)]
#[serde(transparent)]
pub(super) struct Distance(pub(super) f64);

impl<'de> Deserialize<'de> for Distance {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct DistanceVisitor;

        impl Visitor<'_> for DistanceVisitor {
            type Value = f64;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number or null")
            }

            fn visit_unit<E>(self) -> Result<f64, E> {
                Ok(f64::INFINITY)
            }

            fn visit_f64<E>(self, distance: f64) -> Result<f64, E> {
                Ok(distance)
            }

            fn visit_u64<E>(self, distance: u64) -> Result<f64, E> {
                Ok(distance as f64)
            }

            fn visit_i64<E>(self, distance: i64) -> Result<f64, E> {
                Ok(distance as f64)
            }
        }

        deserializer.deserialize_any(DistanceVisitor).map(Self)
    }
}

/// For each junction a list with a number per axis, or, if there is one number per junction, that
/// number.
struct GapsJson<'a> {
    gaps: Cow<'a, [f64]>,
    each: usize,
}

impl Serialize for GapsJson<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.each <= 1 {
            return self.gaps.serialize(serializer);
        }
        serializer.collect_seq(self.gaps.chunks(self.each))
    }
}

impl<'de> Deserialize<'de> for GapsJson<'_> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct GapsVisitor;

        impl<'de> Visitor<'de> for GapsVisitor {
            type Value = GapsJson<'static>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a list of numbers, or of lists of 2 or 3 numbers, all of one kind")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
                let (mut gaps, mut each) = (Vec::new(), None);
                while let Some(gap) = list.next_element()? {
                    let gap = match &gap {
                        JunctionGap::Driving(gap) => std::slice::from_ref(gap),
                        JunctionGap::Assembly(gap) => gap.0.as_slice(),
                    };
                    if *each.get_or_insert(gap.len()) != gap.len() {
                        return Err(A::Error::invalid_length(gap.len(), &self));
                    }
                    gaps.extend_from_slice(gap);
                }
                Ok(GapsJson { gaps: Cow::Owned(gaps), each: each.unwrap_or(1) })
            }
        }

        deserializer.deserialize_any(GapsVisitor)
    }
}

/// The gap at one junction.
enum JunctionGap {
    Driving(f64),
    Assembly(Point),
}

impl<'de> Deserialize<'de> for JunctionGap {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct JunctionGapVisitor;

        impl<'de> Visitor<'de> for JunctionGapVisitor {
            type Value = JunctionGap;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number or a list of 2 or 3 numbers")
            }

            fn visit_f64<E>(self, gap: f64) -> Result<JunctionGap, E> {
                Ok(JunctionGap::Driving(gap))
            }

            fn visit_u64<E>(self, gap: u64) -> Result<JunctionGap, E> {
                Ok(JunctionGap::Driving(gap as f64))
            }

            fn visit_i64<E>(self, gap: i64) -> Result<JunctionGap, E> {
                Ok(JunctionGap::Driving(gap as f64))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, gap: A) -> Result<JunctionGap, A::Error> {
                let gap = serde::de::value::SeqAccessDeserializer::new(gap);
                Point::deserialize(gap).map(JunctionGap::Assembly)
            }
        }

        deserializer.deserialize_any(JunctionGapVisitor)
    }
}

/// The states of a motion, whose positions have so many coordinates.
struct SamplesJson<'a> {
    samples: Cow<'a, [Sample]>,
    dimension: usize,
}

/// A state of the motion. Position and heading are the rigid transform of the body as the
/// request gave it: for assembly tasks the displacement from the assembled state, for `drive`
/// the pose of the footprint's reference point.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema), schemars(rename = "sample"))]
#[serde(deny_unknown_fields)]
struct SampleJson<P = Point> {
    /// Seconds from the start.
    t: f64,
    /// Metres.
    position: P,
    /// Radians counter-clockwise from +x, in (-π, π].
    heading: f64,
    /// m/s.
    velocity: P,
    /// rad/s.
    yaw_rate: f64,
}

impl Serialize for SamplesJson<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.samples.len()))?;
        for Sample { t, position, heading, velocity, yaw_rate } in self.samples.iter() {
            list.serialize_element(&SampleJson {
                t: *t,
                position: &position[..self.dimension],
                heading: *heading,
                velocity: &velocity[..self.dimension],
                yaw_rate: *yaw_rate,
            })?;
        }
        list.end()
    }
}

impl<'de> Deserialize<'de> for SamplesJson<'_> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct SamplesVisitor;

        impl<'de> Visitor<'de> for SamplesVisitor {
            type Value = SamplesJson<'static>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a list of samples, all in 2 or all in 3 dimensions")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
                let mut samples = Vec::with_capacity(list.size_hint().unwrap_or(0));
                let mut dimension = None;
                while let Some(sample) = list.next_element()? {
                    let SampleJson::<Point> { t, position, heading, velocity, yaw_rate } = sample;
                    for point in [position, velocity] {
                        let found = point.0.dimension();
                        if *dimension.get_or_insert(found) != found {
                            return Err(A::Error::invalid_length(found, &self));
                        }
                    }
                    let [position, velocity] = [position, velocity].map(|point| point.0.padded());
                    samples.push(Sample { t, position, heading, velocity, yaw_rate });
                }
                let dimension = dimension.unwrap_or(0);
                Ok(SamplesJson { samples: Cow::Owned(samples), dimension })
            }
        }

        deserializer.deserialize_seq(SamplesVisitor)
    }
}

/// A signed angle turned in place from one heading to another: JSON does not say which
/// way, so the shorter.
pub(super) fn shorter_turn(from: f64, to: f64) -> f64 {
    let turned = (to - from) % TAU;
    if turned > PI {
        turned - TAU
    } else if turned <= -PI {
        turned + TAU
    } else {
        turned
    }
}

#[cfg(feature = "json-schema")]
mod schema {
    use std::borrow::Cow;

    use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

    use super::{Distance, GapsJson, SampleJson, SamplesJson};

    impl JsonSchema for Distance {
        fn schema_name() -> Cow<'static, str> {
            "distance".into()
        }

        fn json_schema(_: &mut SchemaGenerator) -> Schema {
            json_schema!({
                "type": ["number", "null"],
                "description": "A distance to the walls, metres; null where there are no walls.",
            })
        }
    }

    impl JsonSchema for GapsJson<'_> {
        fn inline_schema() -> bool {
            true
        }

        fn schema_name() -> Cow<'static, str> {
            "gaps_used".into()
        }

        fn json_schema(_: &mut SchemaGenerator) -> Schema {
            let numbers = |count| {
                let list = json_schema!({
                    "type": "array",
                    "items": { "type": "number" },
                    "minItems": count,
                    "maxItems": count,
                });
                json_schema!({ "type": "array", "items": list })
            };
            json_schema!({ "anyOf": [
                { "type": "array", "items": { "type": "number" } },
                numbers(2),
                numbers(3),
            ] })
        }
    }

    impl JsonSchema for SamplesJson<'_> {
        fn inline_schema() -> bool {
            true
        }

        fn schema_name() -> Cow<'static, str> {
            "samples".into()
        }

        fn json_schema(generator: &mut SchemaGenerator) -> Schema {
            Vec::<SampleJson>::json_schema(generator)
        }
    }
}
