"""Pictures, where matplotlib is there."""

import json

from ._clearway import Scene, Trajectory


def plot(reply, scene=None, *, ax=None):
    """Draws the paths of a reply or of one trajectory, over its scene if that is given, and
    returns matplotlib's axes. Needs matplotlib (``pip install clearway[plot]``)."""
    try:
        import matplotlib.pyplot as pyplot
    except ImportError as error:
        raise ImportError("clearway.plot needs matplotlib: pip install matplotlib") from error
    if isinstance(reply, Trajectory):
        trajectories = [reply]
    else:
        trajectories = [answer for answer in reply.answers if isinstance(answer, Trajectory)]
    if any(trajectory.dimension == 3 for trajectory in trajectories):
        raise ValueError("a motion in three dimensions can't be drawn in two")
    if ax is None:
        ax = pyplot.gca()
    # Parts move in (x, z); a sample has their z as its second coordinate.
    across, up = "x", "y"
    if scene is not None:
        scene = json.loads((scene if isinstance(scene, Scene) else Scene(scene)).to_json())
        up = "y" if scene["task"] == "drive" else "z"
        _draw_free_space(ax, scene["free_space"])
    begin = _reference(scene)
    for index, trajectory in enumerate(trajectories):
        positions = trajectory.samples["position"]
        clearance = trajectory.clearance
        label = f"{trajectory.length:.2f} m, {clearance.value:.3g} m from the walls"
        ax.plot(begin[0] + positions[:, 0], begin[1] + positions[:, 1], label=label, zorder=3 + index)
    ax.set_aspect("equal")
    ax.set_xlabel(f"{across} (m)")
    ax.set_ylabel(f"{up} (m)")
    if trajectories:
        ax.legend()
    return ax


def _reference(scene):
    """What positions count from: of parts they are displacements of the body."""
    if scene is None or scene["task"] == "drive":
        return 0.0, 0.0
    body = scene["body"]
    boxes = body.get("boxes") or ([body["box"]] if body.get("box") else [])
    points = body.get("polygon") or [box[end] for box in boxes for end in ("min", "max")]
    return tuple((min(values) + max(values)) / 2 for values in zip(*points))


def _draw_free_space(ax, free_space):
    from matplotlib.patches import Polygon

    for channel in free_space.get("channels") or ():
        corners = _corners(channel)
        ax.add_patch(Polygon(corners, facecolor="#eef3f8", edgecolor="#8c959f", zorder=1))
        ax.update_datalim(corners)
    for solid in free_space.get("solids") or ():
        boxes = solid.get("boxes") or ([solid["box"]] if solid.get("box") else [])
        for corners in [solid["polygon"]] if solid.get("polygon") else map(_corners, boxes):
            ax.add_patch(Polygon(corners, facecolor="#d9dde2", edgecolor="#57606a", zorder=2))
            ax.update_datalim(corners)
    ax.autoscale_view()


def _corners(box):
    (left, below), (right, above) = box["min"], box["max"]
    return [(left, below), (right, below), (right, above), (left, above)]
