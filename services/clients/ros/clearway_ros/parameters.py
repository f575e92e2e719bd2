"""The node's parameters, and the scene that they make."""

from dataclasses import dataclass

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.parameter import Parameter


class NotSet(Exception):
    """A parameter without a default was not given."""


@dataclass(frozen=True)
class _Declared:
    description: str
    default: object
    least: float | None = None
    most: float | None = None
    words: tuple[str, ...] = ()
    fixed: bool = False

    def descriptor(self):
        made = ParameterDescriptor(description=self.description, read_only=self.fixed)
        if self.words:
            made.additional_constraints = "one of: " + ", ".join(self.words)
        if self.least is not None:
            if type(self.default) is int:
                made.integer_range = [IntegerRange(from_value=self.least, to_value=self.most)]
            else:
                made.floating_point_range = [
                    FloatingPointRange(from_value=self.least, to_value=self.most)
                ]
        return made


def _length(description, default, least=0.0):
    return _Declared(description, default, least, 1e6)


_NEEDED = Parameter.Type.DOUBLE

_ALL = {
    "domain": _Declared("Domain of the planner (planner --domain)", "default", fixed=True),
    "timeout": _Declared("Seconds to wait for the planner's reply", 1.0, 0.001, 3600.0),
    "frame_id": _Declared(
        "Frame of the map, in which start and goal must be; empty: that of the map that comes", ""
    ),
    "map_source": _Declared(
        "Where the map comes from: the latched topic `map`, or the service `map_server/map`",
        "topic",
        words=("topic", "service"),
        fixed=True,
    ),
    "free_most": _Declared("Cells from 0 to this occupancy are free, percent", 25, 0, 99),
    "unknown_cells": _Declared(
        "What cells of unknown occupancy count as", "occupied", words=("occupied", "free")
    ),
    "footprint.width": _length("Width of the robot, metres", _NEEDED, 0.001),
    "footprint.front": _length("From the reference point to the front end, metres", _NEEDED),
    "footprint.rear": _length("From the reference point to the rear end, metres", _NEEDED),
    "clearance.kind": _Declared(
        "What clearance.distance means: the gap at the corners of the path, or the least distance "
        "from all walls that start and goal leave open; safest: as far as possible",
        "gap",
        words=("gap", "at_least", "safest"),
    ),
    "clearance.distance": _length("Distance from walls, metres; see clearance.kind", 0.05),
    "limits.speed": _length("Greatest speed, m/s", 1.0, 0.001),
    "limits.acceleration": _length("Greatest acceleration, m/s^2", 0.5, 0.001),
    "limits.yaw_rate": _length("Greatest yaw rate, rad/s", 1.0, 0.001),
    "limits.yaw_acceleration": _length("Greatest yaw acceleration, rad/s^2", 1.0, 0.001),
    "limits.lateral_acceleration": _length("Greatest acceleration in curves, m/s^2", 0.5, 0.001),
    "reverse": _Declared("Whether the robot may drive backwards", False),
    "turn_in_place": _Declared("Whether the robot can turn in place", True),
    "min_turn_radius": _length("Least radius of arcs, metres; 0: any", 0.0),
    "start_turn": _Declared(
        "How the robot takes up its first heading", "in_place", words=("in_place", "while_moving")
    ),
    "corners": _Declared(
        "How the robot passes corners: along arcs, at whose ends the yaw rate jumps, or along smooth "
        "turns, whose curvature is continuous",
        "arc",
        words=("arc", "smooth"),
    ),
    "goal_heading": _Declared(
        "Whether the robot turns to the goal's orientation; else it keeps that of its arrival", True
    ),
    "spacing": _length("Distance of the poses of a path, metres", 0.05, 0.001),
    "click_to_plan": _Declared(
        "Whether to plan from the last `initialpose` to each `goal_pose`, as RViz publishes them",
        False,
        fixed=True,
    ),
}


@dataclass(frozen=True)
class Settings:
    """The parameters' values."""

    values: dict
    #: A scene without free space, start and goal.
    scene: dict

    def __getitem__(self, name):
        return self.values[name]


def declare(node):
    """Declares all parameters and returns their values. Raises ``NotSet``."""
    node.add_on_set_parameters_callback(_check)
    for name, declared in _ALL.items():
        node.declare_parameter(name, declared.default, declared.descriptor())
    missing = [
        name
        for name, declared in _ALL.items()
        if declared.default is _NEEDED
        and node.get_parameter_or(name).type_ == Parameter.Type.NOT_SET
    ]
    if missing:
        raise NotSet(f"not set: {', '.join(missing)}: the robot's size, metres")
    return read(node)


def read(node):
    """The parameters' values as they are now."""
    values = {name: node.get_parameter(name).value for name in _ALL}
    distance = values["clearance.distance"]
    scene = {
        "task": "drive",
        "body": {"footprint": _group(values, "footprint.")},
        "limits": _group(values, "limits."),
        "clearance": {
            "gap": {"gap": distance},
            "at_least": {"at_least": distance},
            "safest": "safest",
        }[values["clearance.kind"]],
        "sampling": {"spacing": values["spacing"]},
        "reverse": values["reverse"],
        "turn_in_place": values["turn_in_place"],
        "start_turn": values["start_turn"],
        "corners": values["corners"],
    }
    if values["min_turn_radius"] > 0:
        scene["min_turn_radius"] = values["min_turn_radius"]
    return Settings(values, scene)


def _group(values, prefix):
    return {
        name.removeprefix(prefix): value
        for name, value in values.items()
        if name.startswith(prefix)
    }


def _check(parameters):
    """Ranges and types are checked by their descriptors."""
    for parameter in parameters:
        declared = _ALL.get(parameter.name)
        if declared is not None and declared.words and parameter.value not in declared.words:
            words = ", ".join(declared.words)
            reason = f"{parameter.name} is {parameter.value!r}, must be one of: {words}"
            return SetParametersResult(successful=False, reason=reason)
    return SetParametersResult(successful=True)
