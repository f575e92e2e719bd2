"""Why there is no reply, or no trajectory."""


class ClearwayError(Exception):
    """Any of these."""


class ConnectError(ClearwayError):
    """There is no connection to a planner."""


class NoPlannerError(ConnectError):
    """No planner runs in the domain."""


class CallError(ClearwayError):
    """A request was sent, and no reply came."""


class PlannerLostError(CallError):
    """The planner ended before it replied."""


class PlanTimeoutError(CallError, TimeoutError):
    """No reply came in time."""


class ForkedError(CallError):
    """The client was connected before this process was forked; connect another."""


class RecordingError(ClearwayError):
    """A recording can't be read."""


class RefusedError(ClearwayError):
    """The planner refuses, and says what would have to change. What does not apply is None.

    code: what kind of refusal, such as "junction_too_small".
    message: for people, with the numbers.
    field: the field of the scene that is at fault, as a path.
    junction: the junction concerned, counted in travel order.
    axis: the axis concerned: "x", "y" or "z".
    needs, has: what would be needed, and what there is.
    least, most: the bounds, the lower one excluded.
    heading: the heading that would be free, radians.
    setting: the setting of the planner whose limit was met.
    """

    def __init__(
        self,
        code,
        message,
        *,
        field=None,
        junction=None,
        axis=None,
        needs=None,
        has=None,
        least=None,
        most=None,
        heading=None,
        setting=None,
    ):
        super().__init__(code, message)
        self.code = code
        self.message = message
        self.field = field
        self.junction = junction
        self.axis = axis
        self.needs = needs
        self.has = has
        self.least = least
        self.most = most
        self.heading = heading
        self.setting = setting

    def __str__(self):
        return f"{self.code}: {self.message}"

    def __reduce__(self):
        numbers = {name: value for name, value in vars(self).items() if value is not None}
        return _again, (type(self), numbers)


def _again(kind, numbers):
    return kind(**numbers)


class InvalidScene(RefusedError):
    """The request does not describe a scene that can be planned; ``field`` says where."""


class UnsupportedVersion(RefusedError):
    """The planner does not know the version of the request's layout."""


class BodyOutsideFreeSpace(RefusedError):
    """At the start the body is not inside the free space."""


class GoalOutsideFreeSpace(RefusedError):
    """At the goal the body would not be inside the free space."""


class NoRoute(RefusedError):
    """The channels do not connect start and end."""


class JunctionTooSmall(RefusedError):
    """The body does not fit through the ``junction``."""


class GapOutOfRange(RefusedError):
    """A clearance gap is not between ``least`` and ``most``."""


class CornersTooClose(RefusedError):
    """There is no tangent between two guiding circles."""


class TurnBlocked(RefusedError):
    """The robot has no room to turn in place."""


class WallInTheWay(RefusedError):
    """The body would touch a wall."""


class TooManySamples(RefusedError):
    """The trajectory would have more samples than the planner allows."""


class DeadlineExceeded(RefusedError):
    """The scene's deadline passed before the answer was ready."""


class Overloaded(RefusedError):
    """Too many requests are waiting, or the planner is ending."""


class Internal(RefusedError):
    """The planner failed; this is a bug."""


class TooCostly(RefusedError):
    """Answering would take more time or memory than ``setting`` allows."""


class UnknownFreeSpace(RefusedError):
    """The planner knows no free space of this name."""


_KINDS = {
    "invalid_scene": InvalidScene,
    "unsupported_version": UnsupportedVersion,
    "body_outside_free_space": BodyOutsideFreeSpace,
    "goal_outside_free_space": GoalOutsideFreeSpace,
    "no_route": NoRoute,
    "junction_too_small": JunctionTooSmall,
    "gap_out_of_range": GapOutOfRange,
    "corners_too_close": CornersTooClose,
    "turn_blocked": TurnBlocked,
    "wall_in_the_way": WallInTheWay,
    "too_many_samples": TooManySamples,
    "deadline_exceeded": DeadlineExceeded,
    "overloaded": Overloaded,
    "internal": Internal,
    "too_costly": TooCostly,
    "unknown_free_space": UnknownFreeSpace,
}


def refused(code, message, **numbers):
    """The exception for a refusal; one of a code that is not known here is a RefusedError."""
    return _KINDS.get(code, RefusedError)(code, message, **numbers)


__all__ = [
    "CallError",
    "ClearwayError",
    "ConnectError",
    "ForkedError",
    "NoPlannerError",
    "PlanTimeoutError",
    "PlannerLostError",
    "RecordingError",
    "RefusedError",
    *sorted(kind.__name__ for kind in _KINDS.values()),
]
