"""Planners and clients that end, threads, processes and forks."""

import concurrent.futures
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

import clearway


def test_without_a_planner_there_is_a_clear_error(domain, scene):
    with pytest.raises(clearway.NoPlannerError, match=domain.name):
        clearway.Client(domain.name)
    with pytest.raises(ValueError, match="domain"):
        clearway.Client("not a name")
    with pytest.raises(ValueError, match="wait"):
        clearway.Client(domain.name, wait="never")


def test_a_client_waits_for_a_planner_that_starts(domain, scene):
    starting = threading.Timer(0.3, domain.start_planner)
    starting.start()
    with clearway.Client(domain.name, connect_timeout=60) as client:
        assert client.plan(scene).trajectories
    starting.join()


def test_a_closed_client_says_so(domain, planner, scene):
    with clearway.Client(domain.name) as client:
        assert client.domain == domain.name
    with pytest.raises(clearway.ClearwayError, match="closed"):
        client.plan(scene)


def test_a_killed_planner_is_an_error_and_the_next_call_works(domain, scene, endless):
    planner = domain.start_planner("--unsupervised")
    client = clearway.Client(domain.name)
    kept = client.plan(scene)
    pending = client.start(endless)
    planner.kill()
    planner.wait()
    with pytest.raises(clearway.PlannerLostError, match="planner_lost"):
        pending.wait(60)
    with pytest.raises(clearway.NoPlannerError):
        client.plan(scene)
    domain.start_planner()
    assert client.plan(scene).to_json() == kept.to_json()


def test_threads_share_a_client(client, scene):
    prepared = clearway.Scene(scene)
    expected = client.plan(prepared).to_json()

    def ask(_):
        return client.plan(prepared).to_json() == expected

    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        assert all(pool.map(ask, range(400)))


def test_other_threads_run_while_one_waits(client, endless):
    counted = 0
    done = threading.Event()

    def count():
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    with pytest.raises(clearway.PlanTimeoutError, match="limit"):
        client.plan(endless, timeout=0.5)
    done.set()
    thread.join()
    assert counted > 20


ASK = """
import sys, clearway
client = clearway.Client(sys.argv[1])
scene = clearway.Scene(sys.stdin.read())
print(all(client.plan(scene).is_shared for _ in range(200)))
"""


def test_processes_have_clients_of_their_own(domain, client, scene):
    text = clearway.Scene(scene).to_json()
    asking = [
        subprocess.Popen(
            [sys.executable, "-c", ASK, domain.name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    assert [process.communicate(text, timeout=120)[0].strip() for process in asking] == ["True"] * 2


def test_a_forked_client_is_refused_by_name(client, scene):
    reply = client.plan(scene)
    block = reply.trajectories[0].blocks[0]
    before = block.tobytes()
    child = os.fork()
    if child == 0:
        ended = 1
        try:
            client.plan(scene)
        except clearway.ForkedError as error:
            ended = 0 if "forked" in str(error) and block.tobytes() == before else 2
        except BaseException:
            ended = 3
        del block, reply, client
        os._exit(ended)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    # Nothing that the child dropped was given back to the planner.
    others = [client.plan(scene) for _ in range(20)]
    assert block.tobytes() == before
    assert all(other.to_json() == reply.to_json() for other in others)


def test_a_forked_child_connects_anew(domain, client, scene):
    expected = client.plan(scene).to_json()
    child = os.fork()
    if child == 0:
        ended = 1
        try:
            with clearway.Client(domain.name) as own:
                ended = 0 if own.plan(scene).to_json() == expected else 2
        finally:
            os._exit(ended)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    assert client.plan(scene).to_json() == expected


HANG = """
import sys, clearway
client = clearway.Client(sys.argv[1])
kept = client.plan(open(sys.argv[2]).read())
pending = client.start(open(sys.argv[3]).read())
print("asked", flush=True)
pending.wait(None)
"""


def hanging(domain, scene, endless, folder):
    paths = []
    for name, value in (("scene", scene), ("endless", endless)):
        paths.append(folder / name)
        paths[-1].write_text(clearway.Scene(value).to_json())
    process = subprocess.Popen(
        [sys.executable, "-c", HANG, domain.name, *paths],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline() == "asked\n"
    return process


def left_of(process):
    return [name for name in os.listdir("/dev/shm") if f"_{process.pid}_" in name]


def clients_of(domain):
    from conftest import program

    command = [program("plan"), "--list", "--format", "json"]
    listed = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    import json

    lines = [json.loads(line) for line in listed.stdout.splitlines()]
    return next(line["clients"] for line in lines if line["domain"] == domain.name)


def test_a_client_killed_mid_request_leaves_nothing(domain, planner, scene, endless, tmp_path):
    process = hanging(domain, scene, endless, tmp_path)
    process.kill()
    process.wait()
    with clearway.Client(domain.name) as client:
        assert client.plan(scene).trajectories
        until = time.monotonic() + 30
        while clients_of(domain) != 1:
            assert time.monotonic() < until, "the dead one is still there"
            time.sleep(0.05)


@pytest.mark.parametrize(
    ("number", "ended"), [(signal.SIGINT, "KeyboardInterrupt"), (signal.SIGTERM, "")]
)
def test_signals_are_pythons(domain, planner, scene, endless, tmp_path, number, ended):
    process = hanging(domain, scene, endless, tmp_path)
    process.send_signal(number)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == -number
    assert ended in stderr


@pytest.mark.parametrize(
    ("lie", "kind", "said"),
    [
        ("layout", clearway.ConnectError, "another layout of version 2"),
        ("version", clearway.CallError, "version is 99"),
        ("truncated", clearway.CallError, "samples needs 900 cells, 9 are left"),
        ("trailing", clearway.CallError, "9 cells follow"),
        ("elements", clearway.CallError, "claims 1099511627776 cells"),
    ],
)
def test_a_planner_that_lies_is_an_error(domain, scene, lie, kind, said):
    domain.start_raw_planner(lie)
    with pytest.raises(kind, match=said):
        clearway.Client(domain.name).plan(scene)
