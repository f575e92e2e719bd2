#!/usr/bin/env python3
"""Plans random scenes with OMPL beside `plan`, and prints a table.

    pip install ompl==2.0.1 numpy
    cargo build --release -p peers --bin peers -p clearway-plan --bin plan
    target/release/peers scenes /tmp/scenes --scenes 20
    tests/peers/beside_ompl.py /tmp/scenes --plan target/release/plan --seconds 2

OMPL's robot is holonomic: it can drive in any direction whatever its heading, so its paths may be
shorter than any that a robot with a heading can drive. Planner: BIT*, then OMPL's own shortening.
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys
import time

import numpy as np
from ompl import base, geometric, util


class Walls:
    """All edges, against a rectangle, by separating axes."""

    def __init__(self, scene):
        edges = []
        for solid in scene["free_space"]["solids"]:
            corners = solid["polygon"]
            edges += zip(corners, corners[1:] + corners[:1])
        edges = np.array(edges)
        self.start, self.end = edges[:, 0], edges[:, 1]
        footprint = scene["body"]["footprint"]
        margin = scene["clearance"]["gap"]
        self.half = np.array([footprint["length"], footprint["width"]]) / 2 + margin

    def is_clear(self, x, y, yaw):
        cos, sin = math.cos(yaw), math.sin(yaw)
        turn = np.array([[cos, -sin], [sin, cos]])
        a, b = ((ends - (x, y)) @ turn for ends in (self.start, self.end))
        apart = (np.minimum(a, b) > self.half) | (np.maximum(a, b) < -self.half)
        normal = np.stack([a[:, 1] - b[:, 1], b[:, 0] - a[:, 0]], axis=1)
        offset = np.abs((normal * a).sum(axis=1))
        beside = offset > np.abs(normal) @ self.half
        return bool((apart.any(axis=1) | beside).all())


def plan_with_ompl(scene, seconds):
    walls = Walls(scene)
    space = base.SE2StateSpace()
    bounds = base.RealVectorBounds(2)
    for axis in range(2):
        bounds.setLow(axis, scene["free_space"]["bounds"]["min"][axis])
        bounds.setHigh(axis, scene["free_space"]["bounds"]["max"][axis])
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)

    def is_valid(state):
        return walls.is_clear(state.getX(), state.getY(), state.getYaw())

    setup.setStateValidityChecker(is_valid)
    setup.getSpaceInformation().setStateValidityCheckingResolution(0.004)
    start, goal = space.allocState(), space.allocState()
    for state, pose in ((start, scene["start"]), (goal, scene["goal"])):
        state.setX(pose["position"][0])
        state.setY(pose["position"][1])
        state.setYaw(pose.get("heading", 0.0))
    setup.setStartAndGoalStates(start, goal)
    setup.setPlanner(geometric.BITstar(setup.getSpaceInformation()))
    begin = time.perf_counter()
    setup.solve(seconds)
    if not setup.haveExactSolutionPath():
        return None, time.perf_counter() - begin
    setup.simplifySolution(0.5)
    took = time.perf_counter() - begin
    path = setup.getSolutionPath()
    points = [(state.getX(), state.getY()) for state in path.getStates()]
    return sum(math.dist(a, b) for a, b in zip(points, points[1:])), took


def plan_with_clearway(program, file):
    begin = time.perf_counter()
    run = subprocess.run(
        [program, "--local", "--format", "json", file], capture_output=True, text=True, check=False
    )
    took = time.perf_counter() - begin
    if run.returncode != 0:
        return None, took
    return json.loads(run.stdout)["trajectories"][0]["length"], took


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", type=pathlib.Path, help="a folder that `peers scenes` wrote")
    parser.add_argument("--plan", required=True, help="the program `plan`")
    parser.add_argument("--seconds", type=float, default=2.0, help="that OMPL may take for a scene")
    arguments = parser.parse_args()
    util.setLogLevel(util.LOG_NONE)
    util.RNG.setSeed(1)
    kinds = {}
    for file in sorted(arguments.scenes.glob("*.json")):
        scene = json.loads(file.read_text())
        # OMPL's goal is a pose.
        if "heading" in scene["goal"]:
            kinds.setdefault(file.stem.rsplit("-", 1)[0], []).append((file, scene))
    if not kinds:
        sys.exit(f"beside_ompl.py: no scenes in {arguments.scenes}")
    print("| kind | scenes | OMPL | clearway | length, median | OMPL, s | clearway, whole process, s |")
    print("|---|--:|--:|--:|--:|--:|--:|")
    for kind, scenes in kinds.items():
        theirs = [plan_with_ompl(scene, arguments.seconds) for _, scene in scenes]
        ours = [plan_with_clearway(arguments.plan, file) for file, _ in scenes]
        ratios = [
            100 * (one[0] / other[0] - 1)
            for one, other in zip(ours, theirs)
            if one[0] is not None and other[0] is not None
        ]
        length = f"{statistics.median(ratios):+.1f} %" if ratios else "-"
        print(
            f"| {kind} | {len(scenes)} | {sum(length is not None for length, _ in theirs)} "
            f"| {sum(length is not None for length, _ in ours)} | {length} "
            f"| {statistics.median(took for _, took in theirs):.2f} "
            f"| {statistics.median(took for _, took in ours):.3f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
