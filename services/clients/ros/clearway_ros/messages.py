"""What ROS has in messages, as a planner has it, and back."""

import math

import numpy
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion, Vector3
from nav_msgs.msg import Path
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

# What quaternions may differ from rotations about z by.
_TOLERANCE = 1e-3

_WAY = ColorRGBA(r=0.04, g=0.41, b=0.85, a=1.0)
_BACKWARDS = ColorRGBA(r=0.51, g=0.31, b=0.87, a=1.0)
_TURN = ColorRGBA(r=0.95, g=0.55, b=0.05, a=1.0)
_BODY = ColorRGBA(r=0.34, g=0.38, b=0.42, a=0.6)
_WALL = ColorRGBA(r=0.81, g=0.13, b=0.18, a=1.0)


class BadMessage(Exception):
    """A message that can't be used, and why."""


def yaw_of(orientation, field):
    """The angle of a rotation about z, radians."""
    x, y, z, w = orientation.x, orientation.y, orientation.z, orientation.w
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not abs(norm - 1) <= _TOLERANCE:
        raise BadMessage(f"{field} is no unit quaternion: its norm is {norm:.4g}")
    if math.hypot(x, y) > _TOLERANCE:
        raise BadMessage(f"{field} is tilted: x is {x:.4g} and y is {y:.4g}, both must be 0")
    return 2 * math.atan2(z, w) if w >= 0 else 2 * math.atan2(-z, -w)


def pose_of(stamped, frame, name):
    """A pose in the plane as scenes have it."""
    if stamped.header.frame_id != frame:
        raise BadMessage(
            f"{name}.header.frame_id is {stamped.header.frame_id!r}, must be {frame!r}, "
            "the frame of the map"
        )
    position = stamped.pose.position
    if not (math.isfinite(position.x) and math.isfinite(position.y)):
        raise BadMessage(f"{name}.pose.position is ({position.x}, {position.y}), must be finite")
    heading = yaw_of(stamped.pose.orientation, f"{name}.pose.orientation")
    return {"position": [position.x, position.y], "heading": heading}


def grid_of(message):
    """The cells, resolution and origin of an OccupancyGrid."""
    info = message.info
    origin = info.origin.position
    yaw = yaw_of(info.origin.orientation, "info.origin.orientation")
    cells = numpy.frombuffer(message.data, numpy.int8)
    if len(cells) != info.width * info.height:
        raise BadMessage(
            f"data has {len(cells)} cells, but {info.width} x {info.height} = "
            f"{info.width * info.height} are needed"
        )
    # As it was written: 0.05 as a 32-bit number is not 0.05.
    resolution = float(str(numpy.float32(info.resolution)))
    return cells.reshape(info.height, info.width), resolution, (origin.x, origin.y, yaw)


def _pose(x, y, z, heading):
    return Pose(
        position=Point(x=x, y=y, z=z),
        orientation=Quaternion(z=math.sin(heading / 2), w=math.cos(heading / 2)),
    )


def path_of(samples, header, z):
    """A path with a pose for each sample."""
    positions = samples["position"].tolist()
    headings = samples["heading"].tolist()
    poses = [
        PoseStamped(header=header, pose=_pose(x, y, z, heading))
        for (x, y, _), heading in zip(positions, headings)
    ]
    return Path(header=header, poses=poses)


def _marker(header, namespace, index, kind, width, color):
    marker = Marker(header=header, ns=namespace, id=index, type=kind, action=Marker.ADD)
    marker.scale = Vector3(x=width, y=width, z=width)
    marker.color = color
    marker.pose.orientation.w = 1.0
    return marker


def clear():
    """Markers that remove all earlier ones."""
    return MarkerArray(markers=[Marker(action=Marker.DELETEALL)])


def markers_of(trajectory, samples, footprint, header, z):
    """The path by the kinds of its legs, the body on its way, and where it comes closest to a
    wall."""
    made = clear()
    width = max(0.02, footprint["width"] / 15)
    # The samples that belong to a leg, both ends included.
    lengths = _lengths(samples)
    way = _marker(header, "path", 0, Marker.LINE_LIST, width, _WAY)
    way.points, way.colors = [], []
    points = [Point(x=x, y=y, z=z) for x, y, _ in samples["position"].tolist()]
    ends = numpy.cumsum([leg.length for leg in trajectory.legs])
    backwards = [leg.reverse for leg in trajectory.legs]
    middles = (lengths[1:] + lengths[:-1]) / 2
    legs = numpy.minimum(numpy.searchsorted(ends, middles), len(ends) - 1).tolist()
    for index, leg in enumerate(legs):
        if lengths[index + 1] > lengths[index]:
            way.points += [points[index], points[index + 1]]
            way.colors += [_BACKWARDS if backwards[leg] else _WAY] * 2
    made.markers.append(way)

    body = _marker(header, "footprint", 0, Marker.LINE_LIST, width / 3, _BODY)
    for index in _spread(samples, lengths, footprint):
        (x, y, _), heading = samples["position"][index].tolist(), samples["heading"][index].item()
        corners = _corners(footprint, x, y, heading, z)
        for begin, end in zip(corners, corners[1:] + corners[:1]):
            body.points += [begin, end]
    made.markers.append(body)

    turns = [leg for leg in trajectory.legs if leg.kind == "turn"]
    for index, leg in enumerate(turns):
        arrow = _marker(header, "turns", index, Marker.ARROW, width, _TURN)
        arrow.scale.x = footprint["front"] or footprint["rear"]
        arrow.pose = _pose(leg.position[0], leg.position[1], z, leg.to_heading)
        made.markers.append(arrow)

    clearance = trajectory.clearance
    if math.isfinite(clearance.value):
        wall = _marker(header, "clearance", 0, Marker.SPHERE, 2 * width, _WALL)
        wall.pose.position = Point(x=clearance.wall[0], y=clearance.wall[1], z=z)
        text = _marker(header, "clearance", 1, Marker.TEXT_VIEW_FACING, 0.2, _WALL)
        text.pose.position = Point(x=clearance.wall[0], y=clearance.wall[1], z=z + 0.2)
        text.text = f"{clearance.value:.3f} m"
        made.markers += [wall, text]
    return made


def refusal_markers(message, goal, header, z):
    """The reason at the goal."""
    made = clear()
    if all(math.isfinite(coordinate) for coordinate in goal):
        text = _marker(header, "refusal", 0, Marker.TEXT_VIEW_FACING, 0.2, _WALL)
        text.pose.position = Point(x=goal[0], y=goal[1], z=z + 0.2)
        text.text = message
        made.markers.append(text)
    return made


def _lengths(samples):
    """The arc length at each sample, by its chords."""
    steps = numpy.diff(samples["position"][:, :2], axis=0)
    return numpy.concatenate([[0.0], numpy.cumsum(numpy.hypot(steps[:, 0], steps[:, 1]))])


def _spread(samples, lengths, footprint):
    """Samples about a robot's length apart, and the last."""
    step = max(footprint["front"] + footprint["rear"], 0.1)
    wanted = numpy.arange(0.0, lengths[-1], step)
    return sorted({*numpy.searchsorted(lengths, wanted).tolist(), len(samples) - 1})


def _corners(footprint, x, y, heading, z):
    cosine, sine = math.cos(heading), math.sin(heading)
    half = footprint["width"] / 2
    front, rear = footprint["front"], -footprint["rear"]
    return [
        Point(x=x + along * cosine - across * sine, y=y + along * sine + across * cosine, z=z)
        for along, across in ((rear, -half), (front, -half), (front, half), (rear, half))
    ]


def header_of(frame, stamp):
    return Header(frame_id=frame, stamp=stamp)
