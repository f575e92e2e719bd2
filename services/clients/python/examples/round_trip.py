"""Times round trips with the running planner: round_trip.py SCENE.json DOMAIN CALLS FORM, where FORM
is `prepared` or `dict`. Prints the median and the 99th percentile, microseconds; see
services/clients/round_trip.sh."""

import json
import sys
import time

import clearway

_, path, domain, calls, form = sys.argv
scene = json.load(open(path))
if form == "prepared":
    scene = clearway.Scene(scene)
times = []
with clearway.Client(domain) as client:
    for _ in range(int(calls)):
        begin = time.perf_counter()
        for trajectory in client.plan(scene).trajectories:
            for block in trajectory.blocks:
                block["t"][0]
        times.append(time.perf_counter() - begin)
times.sort()
print(f"{times[len(times) // 2] * 1e6:.1f} {times[len(times) * 99 // 100] * 1e6:.1f}")
