#!/usr/bin/env python3
"""Round trips through zenoh between two processes of one machine, beside those of the Python client.

    pip install eclipse-zenoh==1.10.2
    tests/peers/beside_zenoh.py [--planner target/release/planner]

Requests and replies are as long as those of section 4, and neither side looks into them. A queryable
replies through loopback, then over shared memory. With --planner and the Python client installed, the
client plans section 4 in the same run, alternately.
"""

import argparse
import contextlib
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import zenoh
import zenoh.shm

KEY = "clearway/plan"
# Bytes of a request, and of replies of 2, 100 and 1,000 samples.
REQUEST, REPLIES = 440, {2: 800, 100: 7_900, 1_000: 73_000}
ROUNDS, CALLS = 5, 1_000


def session(listen, connect, shared):
    config = zenoh.Config()
    config.insert_json5("mode", '"peer"')
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("transport/shared_memory/enabled", "true" if shared else "false")
    config.insert_json5("listen/endpoints", f'["{listen}"]' if listen else "[]")
    config.insert_json5("connect/endpoints", f'["{connect}"]' if connect else "[]")
    return zenoh.open(config)


def serve(endpoint, shared):
    memory = zenoh.shm.ShmProvider.default_backend(64 << 20) if shared else None
    plain = {samples: bytes(size) for samples, size in REPLIES.items()}

    def reply(query):
        samples = int(query.parameters["samples"])
        if memory is None:
            payload = plain[samples]
        else:
            payload = memory.alloc(REPLIES[samples], policy=zenoh.shm.BlockOn(zenoh.shm.GarbageCollect()))
        query.reply(query.key_expr, payload)

    with session(endpoint, None, shared) as here:
        here.declare_queryable(KEY, reply)
        print("serving", flush=True)
        sys.stdin.read()


@contextlib.contextmanager
def through_zenoh(shared):
    """A call that returns the bytes of the reply."""
    endpoint = f"tcp/127.0.0.1:{20_000 + os.getpid() % 20_000 + shared}"
    command = [sys.executable, __file__, "--serve", endpoint] + ["--shared"] * shared
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as server:
        server.stdout.readline()
        with session(None, endpoint, shared) as here:
            querier = here.declare_querier(KEY)
            request = bytes(REQUEST)

            def call(samples):
                replies = querier.get(parameters=f"samples={samples}", payload=request)
                return len(next(iter(replies)).ok.payload)

            until = time.monotonic() + 10
            while True:
                with contextlib.suppress(StopIteration):
                    call(2)
                    break
                if time.monotonic() > until:
                    raise SystemExit("the queryable is not found")
                time.sleep(0.05)
            yield call
        server.stdin.close()


@contextlib.contextmanager
def through_the_client(planner):
    import clearway  # noqa: PLC0415

    scenes = pathlib.Path(__file__).parents[2] / "recordings/scenes"
    text = (scenes / "disassemble-channels.json").read_text()
    with tempfile.TemporaryDirectory(prefix="cw") as root:
        os.environ["CLEARWAY_ROOT"] = root
        process = subprocess.Popen([planner, "--domain", "zenoh"])
        try:
            with clearway.Client("zenoh", connect_timeout=10.0) as client:
                prepared = {}
                for samples in REPLIES:
                    scene = json.loads(text) | {"sampling": {"count": samples}}
                    prepared[samples] = clearway.Scene(scene)
                yield lambda samples: client.plan(prepared[samples])
        finally:
            process.terminate()
            process.wait()


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--planner", help="the program")
    arguments.add_argument("--serve", help=argparse.SUPPRESS)
    arguments.add_argument("--shared", action="store_true", help=argparse.SUPPRESS)
    arguments = arguments.parse_args()
    if arguments.serve:
        return serve(arguments.serve, arguments.shared)
    with contextlib.ExitStack() as stack:
        ways = {
            "zenoh, loopback": stack.enter_context(through_zenoh(False)),
            "zenoh, shared memory": stack.enter_context(through_zenoh(True)),
        }
        if arguments.planner:
            ways["the planner's client"] = stack.enter_context(through_the_client(arguments.planner))
        times = {(way, samples): [] for way in ways for samples in REPLIES}
        for call in ways.values():
            for samples, size in REPLIES.items():
                answer = call(samples)
                assert not isinstance(answer, int) or answer == size, (answer, size)
        for _ in range(ROUNDS):
            for samples in REPLIES:
                for way, call in ways.items():
                    for _ in range(CALLS):
                        begun = time.perf_counter_ns()
                        call(samples)
                        times[way, samples].append((time.perf_counter_ns() - begun) / 1e3)
    print("round trip, µs: samples, p50, p99")
    for (way, samples), each in times.items():
        each.sort()
        print(f"{way:<22} {samples:>6} {statistics.median(each):>8.0f} {each[len(each) * 99 // 100]:>8.0f}")


if __name__ == "__main__":
    main()
