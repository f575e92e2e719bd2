from collections.abc import Iterable, Iterator, Mapping
from os import PathLike
from types import TracebackType
from typing import Any, Self, TypeAlias

import numpy
import numpy.typing

__version__: str

#: What stands for a scene: a mapping, a dataclass, a JSON text, or a prepared scene.
AnyScene: TypeAlias = Mapping[str, Any] | str | Scene | Any
Point: TypeAlias = tuple[float, ...]
Samples: TypeAlias = numpy.typing.NDArray[numpy.void]

class Client:
    def __init__(
        self, domain: str | None = None, *, wait: str = "hybrid", connect_timeout: float | None = 0.0
    ) -> None: ...
    @property
    def domain(self) -> str: ...
    def plan(self, scene: AnyScene, timeout: float | None = 10.0) -> Reply:
        """Plans a scene. If no reply comes within `timeout` seconds (None: no limit), the request is
        cancelled and PlanTimeoutError raised; RefusedError if it is refused."""
    def plan_many(
        self, scenes: Iterable[AnyScene], timeout: float | None = 10.0
    ) -> list[Reply | RefusedError]: ...
    async def plan_async(self, scene: AnyScene, timeout: float | None = 10.0) -> Reply: ...
    def start(self, scene: AnyScene) -> Pending:
        """Sends a scene without waiting."""
    def reserve(self, count: int) -> None:
        """Connects in advance, so that so many requests can be open at a time."""
    def is_ready(self) -> bool:
        """Whether a connection is free, so that `start` need not connect."""
    def close(self) -> None:
        """Leaves the planner's domain once the requests and arrays of this client are gone."""
    def __enter__(self) -> Self: ...
    def __exit__(
        self,
        kind: type[BaseException] | None,
        exception: BaseException | None,
        traceback: TracebackType | None,
    ) -> None: ...

class Pending:
    def poll(self) -> Reply | None: ...
    def wait(self, timeout: float | None = 10.0) -> Reply: ...
    def cancel(self) -> None: ...
    def fileno(self) -> int: ...

class Scene:
    def __init__(self, scene: AnyScene) -> None: ...
    def with_name(self) -> Scene: ...
    def to_json(self) -> str: ...

class Reply:
    @property
    def id(self) -> int | None: ...
    @property
    def is_shared(self) -> bool: ...
    @property
    def answers(self) -> tuple[Trajectory | RefusedError, ...]: ...
    @property
    def trajectories(self) -> tuple[Trajectory, ...]: ...
    def to_json(self) -> str: ...

class Trajectory:
    """Metres, radians and seconds."""

    @property
    def length(self) -> float: ...
    @property
    def duration(self) -> float: ...
    @property
    def clearance(self) -> Clearance: ...
    @property
    def free_clearance(self) -> float | None: ...
    @property
    def bound(self) -> float | None: ...
    @property
    def complete(self) -> bool: ...
    @property
    def exceeds(self) -> Exceeds | None:
        """The limit that the motion does not obey. None where there is no such limit, and where the
        request neither has `corners` nor asks for a full report."""
    @property
    def stops(self) -> int | None:
        """At how many joints of legs the body stops because no smooth corner fits, with `corners:
        "smooth"`; otherwise None."""
    @property
    def exit(self) -> str | None: ...
    @property
    def dimension(self) -> int: ...
    @property
    def gap(self) -> tuple[float, ...] | tuple[Point, ...]: ...
    @property
    def route(self) -> tuple[int, ...]: ...
    @property
    def channels(self) -> tuple[tuple[Point, Point], ...]: ...
    @property
    def legs(self) -> list[Leg]: ...
    @property
    def blocks(self) -> tuple[Samples, ...]:
        """The samples, part by part, where the planner wrote them: `t` (s), `position` (m),
        `heading` (rad), `velocity` (m/s), `yaw_rate` (rad/s)."""
    @property
    def samples(self) -> Samples:
        """All samples: without a copy where there is one block."""

class Clearance:
    value: float
    at: float
    wall: Point

class Exceeds:
    """A limit that a motion does not obey: the yaw rate jumps at so many `joints` of legs, by at most
    `jump` (rad/s), because the curvature does."""

    limit: str
    joints: int
    jump: float

class Leg:
    kind: str
    from_: Point | None
    to: Point | None
    heading: float | None
    turned: float | None
    center: Point | None
    radius: float | None
    start_angle: float | None
    sweep: float | None
    position: Point | None
    from_heading: float | None
    to_heading: float | None
    start_curvature: float | None
    end_curvature: float | None
    length: float
    clearance: float
    junction: int | None
    rule: str | None
    rung: str | None
    reverse: bool

class Recording(Iterator[RecordedRequest | RecordedReply]):
    def __init__(self, path: str | PathLike[str]) -> None: ...
    @property
    def lost(self) -> int: ...
    @property
    def unfinished(self) -> int: ...
    def __next__(self) -> RecordedRequest | RecordedReply: ...

class RecordedRequest:
    key: tuple[int, int]
    sent_ns: int
    scene: Scene | None

class RecordedReply:
    key: tuple[int, int]
    sent_ns: int
    reply: Reply | None
    refusal: RefusedError | None

def read_recording(path: str | PathLike[str]) -> Recording: ...
def free_space_of_grid(
    cells: numpy.typing.ArrayLike,
    resolution: float,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    *,
    free_most: int = 25,
    unknown: str = "occupied",
) -> dict[str, Any]: ...
def plot(reply: Reply | Trajectory, scene: AnyScene | None = None, *, ax: Any = None) -> Any:
    """Draws the paths of a reply with matplotlib, over its scene if that is given."""

class ClearwayError(Exception): ...
class ConnectError(ClearwayError): ...
class NoPlannerError(ConnectError): ...
class CallError(ClearwayError): ...
class PlannerLostError(CallError): ...
class PlanTimeoutError(CallError, TimeoutError): ...
class ForkedError(CallError): ...
class RecordingError(ClearwayError): ...

class RefusedError(ClearwayError):
    code: str
    message: str
    field: str | None
    junction: int | None
    axis: str | None
    needs: float | None
    has: float | None
    least: float | None
    most: float | None
    heading: float | None
    setting: str | None

class InvalidScene(RefusedError): ...
class UnsupportedVersion(RefusedError): ...
class BodyOutsideFreeSpace(RefusedError): ...
class GoalOutsideFreeSpace(RefusedError): ...
class NoRoute(RefusedError): ...
class JunctionTooSmall(RefusedError): ...
class GapOutOfRange(RefusedError): ...
class CornersTooClose(RefusedError): ...
class TurnBlocked(RefusedError): ...
class WallInTheWay(RefusedError): ...
class TooManySamples(RefusedError): ...
class DeadlineExceeded(RefusedError): ...
class Overloaded(RefusedError): ...
class Internal(RefusedError): ...
class TooCostly(RefusedError): ...
class UnknownFreeSpace(RefusedError): ...
