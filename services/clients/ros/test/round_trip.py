"""What GetPlan costs between two processes of rclpy: round_trip.py POSES CALLS [SERVICE] prints the
median and the 99th percentile, microseconds; see services/clients/round_trip.sh. Without SERVICE it is
answered by a node that has its path ready; with it, by what offers it: `/clearway/get_plan`."""

import os
import pathlib
import subprocess
import sys
import time

os.environ |= {
    "FASTDDS_DEFAULT_PROFILES_FILE": str(pathlib.Path(__file__).parent / "loopback.xml"),
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
}

import rclpy
from geometry_msgs.msg import PoseStamped
from nav_msgs.srv import GetPlan

poses, calls, *given = sys.argv[1:]
rclpy.init()
if given == ["serve"]:
    node = rclpy.create_node("serves")
    ready = [PoseStamped() for _ in range(int(poses))]

    def answer(_, response):
        response.plan.poses = ready
        return response

    node.create_service(GetPlan, "/bare/get_plan", answer)
    try:
        rclpy.spin(node)
    except Exception:  # It is ended by a signal.
        sys.exit(0)

server = None if given else subprocess.Popen([sys.executable, __file__, poses, calls, "serve"])
node = rclpy.create_node("asks")
client = node.create_client(GetPlan, given[0] if given else "/bare/get_plan")
try:
    assert client.wait_for_service(60), "nobody offers it"
    start, goal = PoseStamped(), PoseStamped()
    for pose, x, y in ((start, 1.3, 0.0), (goal, 16.6, 10.0)):
        pose.header.frame_id = "map"
        pose.pose.position.x, pose.pose.position.y = x, y
    start.pose.orientation.z = start.pose.orientation.w = 0.5**0.5
    times, lengths = [], set()
    for _ in range(int(calls)):
        begin = time.perf_counter()
        future = client.call_async(GetPlan.Request(start=start, goal=goal))
        rclpy.spin_until_future_complete(node, future)
        lengths.add(len(future.result().plan.poses))
        times.append(time.perf_counter() - begin)
finally:
    if server is not None:
        server.terminate()
        server.wait()
times.sort()
print(
    f"{times[len(times) // 2] * 1e6:.0f} {times[len(times) * 99 // 100] * 1e6:.0f} ({lengths} poses)"
)
