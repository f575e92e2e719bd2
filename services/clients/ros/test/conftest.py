"""A planner, the node and a client of it, each a process of its own, over loopback only."""

import importlib.util
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).parent
NODE = pathlib.Path(sys.executable).parent / "clearway_ros"

LOGS = tempfile.TemporaryDirectory(prefix="clearway-ros-")

# Before anything of ROS is loaded; the node inherits it. SYSTEM_DEFAULT: the profile alone counts.
os.environ |= {
    "FASTDDS_DEFAULT_PROFILES_FILE": str(HERE / "loopback.xml"),
    "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
    "ROS_DOMAIN_ID": str(1 + os.getpid() % 100),
    "ROS_LOG_DIR": LOGS.name,
}
os.environ.pop("ROS_STATIC_PEERS", None)


def tracing_files():
    """What the tracing library of ROS makes in shared memory when it is loaded, and leaves there."""
    return set(pathlib.Path("/dev/shm").glob("lttng-ust-wait-*"))


# Those of other programs stay.
TRACING_FILES_OF_OTHERS = tracing_files()

import numpy
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Path
from nav_msgs.srv import GetMap, GetPlan
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from visualization_msgs.msg import MarkerArray

# Planners, as the tests of the Python client start them.
_spec = importlib.util.spec_from_file_location(
    "planners", HERE.parents[1] / "python/tests/conftest.py"
)
planners = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(planners)
domain, planner = planners.domain, planners.planner

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
FOOTPRINT = {"footprint.width": 0.6, "footprint.front": 0.45, "footprint.rear": 0.45}


def grid(cells, resolution=0.1, origin=(-1.0, -2.0), frame="map"):
    cells = numpy.asarray(cells, numpy.int8)
    message = OccupancyGrid()
    message.header.frame_id = frame
    message.info.height, message.info.width = cells.shape
    message.info.resolution = resolution
    message.info.origin.position.x, message.info.origin.position.y = map(float, origin)
    message.data.frombytes(cells.tobytes())
    return message


def office():
    """The floor plan of the scenes."""
    picture = (planners.SCENES / "office.pgm").read_bytes()
    shades = numpy.frombuffer(picture.split(b"\n", 3)[3], numpy.uint8).reshape(140, 200)[::-1]
    return numpy.where(shades > 250, 0, numpy.where(shades < 89, 100, -1))


def pose(x, y, heading=0.0, frame="map"):
    made = PoseStamped()
    made.header.frame_id = frame
    made.pose.position.x, made.pose.position.y = float(x), float(y)
    made.pose.orientation.z = float(numpy.sin(heading / 2))
    made.pose.orientation.w = float(numpy.cos(heading / 2))
    return made


class Robot:
    """What uses the node."""

    def __init__(self, domain, folder):
        self.domain, self.folder = domain, folder
        self.process = None
        self.paths, self.markers, self.told = [], [], []
        self.node = rclpy.create_node("robot")
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.node.create_subscription(Path, "/clearway/path", self.paths.append, LATCHED)
        self.node.create_subscription(MarkerArray, "/clearway/markers", self.markers.append, LATCHED)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self.told.append, 10)
        self.map = self.node.create_publisher(OccupancyGrid, "/map", LATCHED)
        self.start = self.node.create_publisher(PoseWithCovarianceStamped, "/initialpose", 10)
        self.goal = self.node.create_publisher(PoseStamped, "/goal_pose", 10)
        self.plans = self.node.create_client(GetPlan, "/clearway/get_plan")

    def start_node(self, **values):
        values = FOOTPRINT | {"timeout": 20.0} | values
        arguments = ["--ros-args", "-p", f"domain:={self.domain.name}"]
        for name, value in values.items():
            word = str(value).lower() if isinstance(value, bool) else value
            arguments += ["-p", f"{name.replace('__', '.')}:={word}"]
        self.log = self.folder / "node.log"
        with open(self.log, "wb") as log:
            self.process = subprocess.Popen(
                [NODE, *arguments], stdout=log, stderr=log
            )
        assert self.plans.wait_for_service(60), self.log.read_text()

    def until(self, happened, what, limit=30):
        end = time.monotonic() + limit
        while not (result := happened()):
            assert time.monotonic() < end, f"{what}: {self.log.read_text()}"
            self.executor.spin_once(timeout_sec=0.05)
        return result

    def done(self, future):
        self.until(future.done, "an answer", 60)
        return future.result()

    def ask(self, start, goal):
        return self.plans.call_async(GetPlan.Request(start=start, goal=goal))

    def plan(self, start, goal):
        return self.done(self.ask(start, goal)).plan

    def use_map(self, message):
        """Publishes it and waits until the node has it."""
        self.until(lambda: self.map.get_subscription_count(), "the node subscribes")
        self.told.clear()
        self.map.publish(message)

    def status(self, what, holds):
        """The first status about something for which this holds: its message and its facts."""

        def found():
            for told in self.told:
                for status in told.status:
                    facts = {value.key: value.value for value in status.values}
                    if status.name == f"clearway: {what}" and holds(status.message, facts):
                        return status.message, facts, status.level

        return self.until(found, f"status of {what}")

    def refusal(self, start, goal):
        """Asks for what is refused; the status' message and facts."""
        self.status("last plan", lambda *_: True)
        self.told.clear()
        assert self.plan(start, goal).poses == []
        message, facts, _ = self.status("last plan", lambda _, facts: "code" in facts)
        return message, facts

    def stop(self):
        if self.process is not None and self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            assert self.process.wait(60) == 0, self.log.read_text()

    def close(self):
        self.stop()
        self.executor.shutdown()
        self.node.destroy_node()


@pytest.fixture(scope="session", autouse=True)
def ros():
    rclpy.init()
    yield
    rclpy.shutdown()
    for path in tracing_files() - TRACING_FILES_OF_OTHERS:
        path.unlink(missing_ok=True)


@pytest.fixture
def robot(domain, tmp_path):
    robot = Robot(domain, tmp_path)
    yield robot
    robot.close()


@pytest.fixture
def map_server():
    """Answers to GetMap as Nav2's map server does."""
    node = rclpy.create_node("map_server")
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    asked = []

    def answer(_, response):
        asked.append(1)
        response.map = grid(office())
        return response

    node.create_service(GetMap, "/map_server/map", answer)
    yield lambda: executor.spin_once(timeout_sec=0) or asked
    executor.shutdown()
    node.destroy_node()
