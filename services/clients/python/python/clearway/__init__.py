"""Plans collision-free motions with a Clearway planner over shared memory.

    import clearway

    with clearway.Client() as client:
        reply = client.plan(scene, timeout=1.0)
    for block in reply.trajectories[0].blocks:
        print(block["t"], block["position"])

Units are metres, radians and seconds. A scene is a mapping, a dataclass, a JSON text, or a
``Scene``, which is prepared once. Start a planner first (``planner``).
"""

from . import _errors
from ._clearway import (
    Clearance,
    Exceeds,
    Leg,
    Pending,
    RecordedReply,
    RecordedRequest,
    Recording,
    Reply,
    Scene,
    Trajectory,
    __version__,
)
from ._client import Client
from ._errors import *
from ._maps import free_space_of_grid
from ._plot import plot


def read_recording(path):
    """The requests and replies of a recording, in bus order: ``RecordedRequest`` and
    ``RecordedReply``. Raises ``RecordingError`` at the first damage; what came before is right."""
    return Recording(path)


__all__ = [
    "Clearance",
    "Client",
    "Exceeds",
    "Leg",
    "Pending",
    "RecordedReply",
    "RecordedRequest",
    "Recording",
    "Reply",
    "Scene",
    "Trajectory",
    "free_space_of_grid",
    "plot",
    "read_recording",
    *_errors.__all__,
]
