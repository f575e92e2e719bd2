"""The node: ``ros2 run clearway_ros clearway_ros --ros-args -p footprint.width:=0.6 ...``."""

import sys
import threading
import time
from dataclasses import dataclass

import clearway
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Path
from nav_msgs.srv import GetMap, GetPlan
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from visualization_msgs.msg import MarkerArray

from . import messages, parameters

# Plans at a time, and one thread for the rest.
_THREADS = 5

_LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)

# Requests that wait; DDS drops the oldest of more, and whoever sent it waits for ever.
_WAITING = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)


class Refusal(Exception):
    """Why there is no plan: a code, a message, and numbers."""

    def __init__(self, code, message, **numbers):
        super().__init__(f"{code}: {message}")
        self.code = code
        self.message = message
        self.numbers = numbers


@dataclass(frozen=True)
class Map:
    """A map as planners have it."""

    frame: str
    z: float
    space: dict
    cells: tuple[int, int]
    resolution: float

    @property
    def name(self):
        return {"named": self.space["named"]}


class ClearwayNode(Node):
    def __init__(self, **options):
        super().__init__("clearway", **options)
        try:
            self._settings = parameters.declare(self)
        except BaseException:
            self.destroy_node()
            raise
        self.add_post_set_parameters_callback(self._take_parameters)
        self._lock = threading.Lock()
        self._client = None
        self._planner = (DiagnosticStatus.WARN, "not connected yet")
        self._message = None
        self._map = None
        self._map_problem = Refusal("no_map", "there is no map yet")
        self._uploads = 0
        self._plans = 0
        self._refused = 0
        self._last = None

        plans, rest = ReentrantCallbackGroup(), MutuallyExclusiveCallbackGroup()
        self._path = self.create_publisher(Path, "~/path", _LATCHED)
        self._markers = self.create_publisher(MarkerArray, "~/markers", _LATCHED)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.create_service(
            GetPlan, "~/get_plan", self._get_plan, qos_profile=_WAITING, callback_group=plans
        )
        if self._settings["map_source"] == "topic":
            self.create_subscription(
                OccupancyGrid, "map", self._take_map, _LATCHED, callback_group=rest
            )
        else:
            self._map_server = self.create_client(GetMap, "map_server/map", callback_group=rest)
            self._asked = None
        if self._settings["click_to_plan"]:
            self._start = None
            self.create_subscription(
                PoseWithCovarianceStamped, "initialpose", self._take_start, 10, callback_group=rest
            )
            self.create_subscription(
                PoseStamped, "goal_pose", self._take_goal, 10, callback_group=plans
            )
        self.create_timer(1.0, self._tick, callback_group=rest)
        self._tick()

    # The map.

    def _take_parameters(self, _):
        before, self._settings = self._settings, parameters.read(self)
        of_map = ("frame_id", "free_most", "unknown_cells")
        changed = any(before[name] != self._settings[name] for name in of_map)
        if changed and self._message is not None:
            self._take_map(self._message)

    def _take_map(self, message):
        self._message = message
        settings = self._settings
        frame = message.header.frame_id
        try:
            if settings["frame_id"] not in ("", frame):
                raise messages.BadMessage(
                    f"header.frame_id is {frame!r}, must be {settings['frame_id']!r} (frame_id)"
                )
            cells, resolution, origin = messages.grid_of(message)
            space = clearway.free_space_of_grid(
                cells,
                resolution,
                origin,
                free_most=settings["free_most"],
                unknown=settings["unknown_cells"],
            )
        except (messages.BadMessage, ValueError) as error:
            # Planning on the map before it would be quietly wrong.
            self._map, self._map_problem = None, Refusal("bad_map", str(error))
            self.get_logger().error(f"the map is refused: {error}")
        else:
            height, width = cells.shape
            z = message.info.origin.position.z
            self._map = Map(frame, z, space, (width, height), resolution)
            self.get_logger().info(
                f"map of {width} x {height} cells of {resolution} m in frame {frame!r}, "
                f"{len(space['solids'])} solids"
            )
        self._diagnose()

    def _ask_for_map(self):
        if self._asked is None and self._map_server.service_is_ready():
            self._asked = self._map_server.call_async(GetMap.Request())
            self._asked.add_done_callback(self._take_answer)

    def _take_answer(self, answer):
        self._take_map(answer.result().map)

    # Plans.

    def _get_plan(self, request, response):
        response.plan = self._answer(request.start, request.goal)
        return response

    def _take_start(self, message):
        self._start = PoseStamped(header=message.header, pose=message.pose.pose)

    def _take_goal(self, goal):
        if self._start is None:
            self.get_logger().warning("goal_pose without initialpose: where does the robot start?")
        else:
            self._answer(self._start, goal)

    def _answer(self, start, goal):
        """The path, which is empty if there is none; it is published in any case."""
        begin = time.monotonic()
        chart = self._map
        frame = chart.frame if chart else self._settings["frame_id"]
        header = messages.header_of(frame, self.get_clock().now().to_msg())
        z = chart.z if chart else 0.0
        try:
            if chart is None:
                raise self._map_problem
            trajectory = self._plan(chart, start, goal)
        except Refusal as refusal:
            path = Path(header=header)
            position = goal.pose.position
            markers = messages.refusal_markers(
                refusal.message, (position.x, position.y), header, z
            )
            self.get_logger().error(f"no plan: {refusal}")
            self._note(refusal, begin)
        else:
            samples = trajectory.samples
            path = messages.path_of(samples, header, z)
            markers = None
            if self._markers.get_subscription_count():
                footprint = self._settings.scene["body"]["footprint"]
                markers = messages.markers_of(trajectory, samples, footprint, header, z)
            self._note(trajectory, begin)
        self._path.publish(path)
        if markers is not None:
            self._markers.publish(markers)
        return path

    def _plan(self, chart, start, goal):
        settings = self._settings
        try:
            start = messages.pose_of(start, chart.frame, "start")
            goal = messages.pose_of(goal, chart.frame, "goal")
        except messages.BadMessage as error:
            raise Refusal("bad_pose", str(error)) from None
        if not settings["goal_heading"]:
            del goal["heading"]
        scene = settings.scene | {"free_space": chart.name, "start": start, "goal": goal}
        until = time.monotonic() + settings["timeout"]
        try:
            client = self._connected()
            try:
                reply = client.plan(scene, timeout=settings["timeout"])
            except clearway.UnknownFreeSpace:
                self._uploads += 1
                left = max(0.0, until - time.monotonic())
                reply = client.plan(scene | {"free_space": chart.space}, timeout=left)
            return reply.trajectories[0]
        except clearway.RefusedError as error:
            numbers = {name: value for name, value in vars(error).items() if value is not None}
            raise Refusal(**numbers) from None
        except clearway.ClearwayError as error:
            code, message = self._lost(error)
            raise Refusal(code, message) from None

    # The planner.

    def _connected(self):
        with self._lock:
            if self._client is None:
                self._client = clearway.Client(self._settings["domain"])
                self._planner = (DiagnosticStatus.OK, "connected")
                self.get_logger().info(f"planner of domain {self._settings['domain']!r}")
            return self._client

    def _lost(self, error):
        """Takes note of a planner that does not answer; its code, and what to say."""
        codes = {
            clearway.NoPlannerError: "no_planner",
            clearway.PlannerLostError: "planner_lost",
            clearway.PlanTimeoutError: "timed_out",
        }
        code = codes.get(type(error), "no_connection")
        message = str(error).removeprefix(f"{code}: ")
        if code != "timed_out":
            with self._lock:
                self._client = None
                self._planner = (DiagnosticStatus.ERROR, message)
        return code, message

    # What is told about it.

    def _tick(self):
        if self._settings["map_source"] == "service" and self._message is None:
            self._ask_for_map()
        if self._client is None:
            try:
                self._connected()
            except clearway.ClearwayError as error:
                self._lost(error)
        self._diagnose()

    def _note(self, outcome, begin):
        took = time.monotonic() - begin
        with self._lock:
            self._plans += 1
            self._refused += isinstance(outcome, Refusal)
            if isinstance(outcome, Refusal):
                facts = {"code": outcome.code} | outcome.numbers
                level, message = DiagnosticStatus.WARN, str(outcome)
            else:
                facts = {
                    "length": f"{outcome.length:.3f} m",
                    "duration": f"{outcome.duration:.2f} s",
                    "clearance": f"{outcome.clearance.value:.3f} m",
                }
                if (exceeds := outcome.exceeds) is not None:
                    where = f"{exceeds.joints} joints, jumps of up to {exceeds.jump:.2f} rad/s"
                    facts["exceeds"] = f"{exceeds.limit} at {where}"
                if outcome.stops is not None:
                    facts["stops"] = outcome.stops
                level, message = DiagnosticStatus.OK, "planned"
            self._last = (level, message, facts | {"took": f"{took * 1e3:.1f} ms"})
        if level != DiagnosticStatus.OK:
            self._diagnose()

    def _diagnose(self):
        domain = self._settings["domain"]
        statuses = []

        def add(what, level, message, facts):
            values = [KeyValue(key=key, value=str(value)) for key, value in facts.items()]
            statuses.append(
                DiagnosticStatus(
                    level=level,
                    name=f"{self.get_name()}: {what}",
                    message=message,
                    hardware_id=domain,
                    values=values,
                )
            )

        with self._lock:
            level, message = self._planner
            add("planner", level, message, {"domain": domain})
            if (chart := self._map) is None:
                level = DiagnosticStatus.WARN
                if self._map_problem.code != "no_map":
                    level = DiagnosticStatus.ERROR
                add("map", level, self._map_problem.message, {})
            else:
                facts = {
                    "frame": chart.frame,
                    "cells": f"{chart.cells[0]} x {chart.cells[1]}",
                    "resolution": f"{chart.resolution} m",
                    "solids": len(chart.space["solids"]),
                    "name": chart.space["named"],
                    "sent to the planner": self._uploads,
                }
                add("map", DiagnosticStatus.OK, "there", facts)
            level, message, facts = self._last or (DiagnosticStatus.OK, "none yet", {})
            counts = {"plans": self._plans, "refused": self._refused}
            add("last plan", level, message, facts | counts)
        header = messages.header_of("", self.get_clock().now().to_msg())
        self._diagnostics.publish(DiagnosticArray(header=header, status=statuses))

    def destroy_node(self):
        client = getattr(self, "_client", None)
        if client is not None:
            client.close()
        super().destroy_node()


def main(arguments=None):
    """Runs the node until it is interrupted."""
    rclpy.init(args=arguments)
    try:
        node = ClearwayNode()
    except KeyboardInterrupt:
        rclpy.try_shutdown()
        return 0
    except Exception as error:
        print(f"clearway_ros: {error}", file=sys.stderr)
        rclpy.try_shutdown()
        return 2
    executor = MultiThreadedExecutor(num_threads=_THREADS)
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()
    return 0
