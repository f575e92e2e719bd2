"""Plans for a robot on a floor plan, and all that may be wrong about a request, a map or a planner."""

import json
import re
import subprocess
import sys

import clearway
import numpy
import pytest
from conftest import NODE, grid, office, planners, pose
from geometry_msgs.msg import PoseWithCovarianceStamped
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import DescribeParameters, ListParameters, SetParameters

START, GOAL = pose(1.3, 0.0, numpy.pi / 2), pose(16.6, 10.0)


def planned(domain, **more):
    """What the Python client gets for the same."""
    scene = {
        "task": "drive",
        "free_space": clearway.free_space_of_grid(office(), 0.1, (-1.0, -2.0, 0.0)),
        "body": {"footprint": {"width": 0.6, "front": 0.45, "rear": 0.45}},
        "start": {"position": [1.3, 0.0], "heading": numpy.pi / 2},
        "goal": {"position": [16.6, 10.0], "heading": 0.0},
        "clearance": {"gap": 0.05},
        "sampling": {"spacing": 0.05},
    }
    with clearway.Client(domain.name) as client:
        return client.plan(scene | more, timeout=60).trajectories[0]


def test_a_path_is_what_the_planner_answers(robot, domain, planner):
    robot.start_node()
    robot.use_map(grid(office()))
    robot.status("map", lambda message, _: message == "there")
    path = robot.plan(START, GOAL)
    samples = planned(domain).samples
    assert len(path.poses) == len(samples) > 100
    found = [[stamped.pose.position.x, stamped.pose.position.y] for stamped in path.poses]
    assert found == samples["position"][:, :2].tolist()
    headings = [
        2 * numpy.arctan2(stamped.pose.orientation.z, stamped.pose.orientation.w)
        for stamped in path.poses
    ]
    assert numpy.allclose(headings, samples["heading"], atol=1e-12)
    assert path.header.frame_id == "map" and path.poses[0].header == path.header
    assert robot.until(lambda: robot.paths, "the path")[-1] == path

    markers = robot.until(lambda: robot.markers, "markers")[-1].markers
    kinds = {marker.ns: marker for marker in markers[1:]}
    assert set(kinds) == {"path", "footprint", "clearance", "turns"}
    assert markers[0].action == markers[0].DELETEALL
    way = kinds["path"].points
    assert (way[0].x, way[0].y) == (1.3, 0.0) and (way[-1].x, way[-1].y) == (16.6, 10.0)
    assert len(kinds["footprint"].points) % 8 == 0
    assert kinds["clearance"].text == f"{planned(domain).clearance.value:.3f} m"
    _, facts, level = robot.status("last plan", lambda message, _: message == "planned")
    assert facts["length"] == f"{planned(domain).length:.3f} m" and level == b"\0"
    exceeds = planned(domain, corners="arc").exceeds
    assert facts["exceeds"].startswith(f"yaw_acceleration at {exceeds.joints} joints, jumps of up to ")
    assert "stops" not in facts


def test_corners_can_be_smooth(robot, domain, planner):
    robot.start_node(corners="smooth")
    robot.use_map(grid(office()))
    robot.status("map", lambda message, _: message == "there")
    path = robot.plan(START, GOAL)
    smooth = planned(domain, corners="smooth")
    found = [[stamped.pose.position.x, stamped.pose.position.y] for stamped in path.poses]
    assert found == smooth.samples["position"][:, :2].tolist()
    _, facts, _ = robot.status("last plan", lambda message, _: message == "planned")
    assert "exceeds" not in facts and facts["stops"] == str(smooth.stops)


def test_a_map_is_sent_once(robot, domain, planner, tmp_path):
    file = tmp_path / "run.mcap"
    recorder = subprocess.Popen(
        [planners.program("recorder"), "--domain", domain.name, "-o", file], stderr=subprocess.PIPE
    )
    robot.start_node()
    robot.use_map(grid(office()))
    robot.status("map", lambda message, _: message == "there")
    lengths = {len(robot.plan(START, GOAL).poses) for _ in range(20)}
    assert len(lengths) == 1 and lengths.pop() > 100
    recorder.terminate()
    assert recorder.wait(60) == 0, recorder.stderr.read()
    requests = [
        json.loads(message.scene.to_json())["free_space"]
        for message in clearway.read_recording(file)
        if isinstance(message, clearway.RecordedRequest)
    ]
    # The name is tried first.
    assert sum("solids" in space for space in requests) == 1 and len(requests) <= 22


def test_a_frame_other_than_the_maps_is_refused_by_name(robot, planner):
    robot.start_node()
    robot.use_map(grid(office()))
    robot.status("map", lambda message, _: message == "there")
    message, facts = robot.refusal(pose(1.3, 0.0, frame="odom"), GOAL)
    assert facts["code"] == "bad_pose"
    assert "start.header.frame_id is 'odom', must be 'map'" in message
    message, _ = robot.refusal(START, pose(16.6, 10.0, frame=""))
    assert "goal.header.frame_id is '', must be 'map'" in message
    tilted = pose(16.6, 10.0)
    tilted.pose.orientation.x, tilted.pose.orientation.w = 0.6, 0.8
    assert "goal.pose.orientation is tilted: x is 0.6" in robot.refusal(START, tilted)[0]
    nowhere = pose(16.6, float("nan"))
    assert "goal.pose.position is (16.6, nan)" in robot.refusal(START, nowhere)[0]
    nothing = pose(16.6, 10.0)
    nothing.pose.orientation.w = 0.0
    assert "no unit quaternion: its norm is 0" in robot.refusal(START, nothing)[0]
    # None of it has done any harm.
    assert robot.plan(START, GOAL).poses


def test_without_a_map_there_is_no_plan(robot, planner):
    robot.start_node()
    message, facts = robot.refusal(START, GOAL)
    assert (facts["code"], message) == ("no_map", "no_map: there is no map yet")


def test_planners_come_and_go(robot, domain):
    robot.start_node()
    robot.use_map(grid(office()))
    robot.status("map", lambda message, _: message == "there")
    message, facts = robot.refusal(START, GOAL)
    assert facts["code"] == "no_planner" and domain.name in message
    assert robot.status("planner", lambda *_: True)[2] == b"\2"
    first = domain.start_planner("--unsupervised")
    path = robot.plan(START, GOAL)
    assert path.poses
    first.kill()
    first.wait()
    message, facts = robot.refusal(START, GOAL)
    assert facts["code"] in ("no_planner", "planner_lost")
    domain.start_planner()
    robot.told.clear()
    robot.status("planner", lambda message, _: message == "connected")
    assert [each.pose for each in robot.plan(START, GOAL).poses] == [each.pose for each in path.poses]


def test_a_blocked_route_is_refused_with_numbers(robot, planner):
    robot.start_node()
    cells = numpy.zeros((40, 60), numpy.int8)
    cells[:, 30] = 100
    cells[18:22, 30] = 0
    robot.use_map(grid(cells, origin=(0, 0)))
    robot.status("map", lambda message, _: message == "there")
    message, facts = robot.refusal(pose(1, 2), pose(5, 2))
    assert facts["code"] == "no_route"
    assert float(facts["needs"]) > float(facts["has"]) and "0.4" in message
    assert robot.until(lambda: robot.paths, "a path")[-1].poses == []
    text = robot.until(lambda: robot.markers, "markers")[-1].markers[-1]
    assert text.ns == "refusal" and text.text in message


def unturned(message, w):
    message.info.origin.orientation.x, message.info.origin.orientation.w = 0.6, w
    return message


def test_a_bad_map_is_refused_and_the_old_one_forgotten(robot, planner):
    robot.start_node(frame_id="map")
    short = grid(office())
    short.data = short.data[:-1]
    bad = [
        (grid(office(), frame="odom"), "header.frame_id is 'odom', must be 'map'"),
        (grid(numpy.full((4, 4), 100)), "none of the map's 16 cells is free"),
        (grid(office(), resolution=0.0), "resolution is 0"),
        (short, "data has 27999 cells, but 200 x 140 = 28000 are needed"),
        (unturned(grid(office()), 0.8), "info.origin.orientation is tilted"),
    ]
    for message, said in bad:
        robot.use_map(grid(office()))
        robot.status("map", lambda message, _: message == "there")
        assert robot.plan(START, GOAL).poses
        robot.use_map(message)
        robot.status("map", lambda message, _: said in message)
        message, facts = robot.refusal(START, GOAL)
        assert facts["code"] == "bad_map" and said in message


def test_the_map_comes_from_a_map_server_too(robot, planner, map_server):
    robot.start_node(map_source="service")
    robot.until(map_server, "the node asks")
    robot.status("map", lambda message, _: message == "there")
    assert robot.plan(START, GOAL).poses


def test_clicks_are_planned(robot, planner):
    robot.start_node(click_to_plan=True, goal_heading=False)
    robot.use_map(grid(office()))
    robot.status("map", lambda message, _: message == "there")
    robot.until(lambda: robot.start.get_subscription_count(), "the node listens")
    start = PoseWithCovarianceStamped(header=START.header)
    start.pose.pose = START.pose
    robot.start.publish(start)
    # The two come over different topics.
    robot.until(lambda: robot.goal.publish(GOAL) or robot.paths, "a path")
    assert robot.paths[-1].poses[0].pose.position.x == 1.3


def test_several_ask_at_a_time(robot, domain, planner):
    robot.start_node()
    robot.use_map(grid(office()))
    robot.status("map", lambda message, _: message == "there")
    asked = [robot.ask(START, GOAL) for _ in range(12)]
    paths = [[each.pose for each in robot.done(one).plan.poses] for one in asked]
    assert len(paths[0]) == len(planned(domain).samples)
    assert all(path == paths[0] for path in paths)


def call(robot, kind, name, request):
    client = robot.node.create_client(kind, f"/clearway/{name}")
    assert client.wait_for_service(30)
    return robot.done(client.call_async(request))


def test_parameters_are_described_and_checked(robot, planner):
    robot.start_node()
    robot.use_map(grid(office()))
    robot.status("map", lambda message, _: message == "there")
    names = call(robot, ListParameters, "list_parameters", ListParameters.Request()).result.names
    ours = [name for name in names if not name.startswith(("use_sim_time", "start_type", "qos"))]
    described = call(
        robot, DescribeParameters, "describe_parameters", DescribeParameters.Request(names=ours)
    )
    assert len(ours) > 20 and all(each.description for each in described.descriptors)

    def put(name, **value):
        parameter = Parameter(name=name, value=ParameterValue(**value))
        request = SetParameters.Request(parameters=[parameter])
        return call(robot, SetParameters, "set_parameters", request).results[0]

    refused = put("unknown_cells", type=4, string_value="maybe")
    assert not refused.successful
    assert refused.reason == "unknown_cells is 'maybe', must be one of: occupied, free"
    assert not put("limits.speed", type=3, double_value=-1.0).successful
    assert not put("domain", type=4, string_value="other").successful
    before = robot.plan(START, GOAL)
    assert put("clearance.kind", type=4, string_value="safest").successful
    safest = robot.plan(START, GOAL)
    assert safest.poses and len(safest.poses) != len(before.poses)
    # What is unknown in the office is behind walls.
    assert put("free_most", type=2, integer_value=0).successful
    assert robot.plan(START, GOAL).poses
    assert put("footprint.width", type=3, double_value=3.0).successful
    message, facts = robot.refusal(START, GOAL)
    assert facts["code"] == "goal_outside_free_space" and "touch the wall" in message


def test_a_robot_has_a_size(domain):
    command = [NODE, "--ros-args", "-p", "footprint.width:=0.5"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert ended.returncode == 2
    assert "not set: footprint.front, footprint.rear" in ended.stderr


def test_rviz_shows_what_the_node_publishes(robot, planner):
    robot.start_node(click_to_plan=True)
    shown = (planners.ROOT / "services/clients/ros/rviz/clearway.rviz").read_text()
    wanted = set(re.findall(r"Value: (/\w+(?:/\w+)*)$", shown, re.MULTILINE))
    there = lambda: {name for name, _ in robot.node.get_topic_names_and_types()}
    robot.until(lambda: wanted - {"/map_updates"} <= there(), "all topics")


def test_the_package_depends_on_what_it_imports():
    package = planners.ROOT / "services/clients/ros"
    sources = "".join(path.read_text() for path in (package / "clearway_ros").glob("*.py"))
    imported = set(re.findall(r"^(?:from|import) (\w+)", sources, re.MULTILINE))
    depends = set(re.findall(r"<exec_depend>(?:python3-)?(\w+)<", (package / "package.xml").read_text()))
    standard = {name for name in imported if name in sys.stdlib_module_names}
    assert imported - standard - {"clearway"} == depends
