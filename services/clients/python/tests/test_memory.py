"""Samples lie in shared memory, for as long as somebody looks at them."""

import ctypes
import gc
import os

import numpy
import pytest

import clearway


def mapping_of(array):
    """The file that an array's memory is mapped from."""
    address = array.__array_interface__["data"][0]
    for line in open("/proc/self/maps"):
        begin, end = (int(part, 16) for part in line.split()[0].split("-"))
        if begin <= address < end:
            return line.split()[5]
    raise AssertionError("the address is not mapped")


def test_blocks_are_shared_memory_and_read_only(client, scene):
    reply = client.plan(scene | {"sampling": {"count": 1_000}})
    assert reply.is_shared
    trajectory = reply.trajectories[0]
    assert len(trajectory.blocks) >= 3
    for block in trajectory.blocks:
        assert mapping_of(block).startswith("/dev/shm/cw_")
        assert not block.flags.writeable
        with pytest.raises(ValueError):
            block["t"][0] = 1.0
        with pytest.raises(ValueError):
            block.flags.writeable = True
    assert trajectory.blocks[0].dtype.names == ("t", "position", "heading", "velocity", "yaw_rate")
    joined = trajectory.samples
    assert joined.tobytes() == b"".join(block.tobytes() for block in trajectory.blocks)
    assert not joined.flags.writeable


def test_samples_of_one_part_are_not_copied(client, scene):
    trajectory = client.plan(scene).trajectories[0]
    (block,) = trajectory.blocks
    assert numpy.shares_memory(trajectory.samples, block)
    assert mapping_of(trajectory.samples).startswith("/dev/shm/cw_")


def test_memory_outlives_reply_client_and_planner(domain, scene):
    planner = domain.start_planner()
    client = clearway.Client(domain.name)
    block = client.plan(scene).trajectories[0].blocks[0]
    part = block["position"][3:7]
    before = part.copy()
    client.close()
    del client, block
    gc.collect()
    planner.terminate()
    assert planner.wait(60) == 0
    assert (part == before).all()
    assert mapping_of(part).startswith("/dev/shm/cw_")
    del part
    gc.collect()
    assert not os.path.exists(domain.root) or not os.listdir(domain.root)


def test_a_list_of_replies_never_starves_the_client(client, scene):
    scene = clearway.Scene(scene)
    replies = [client.plan(scene) for _ in range(50)]
    shared = [reply.is_shared for reply in replies]
    assert 0 < sum(shared) < 50 and shared == sorted(shared, reverse=True)
    expected = replies[0].trajectories[0].samples.tobytes()
    assert all(reply.trajectories[0].samples.tobytes() == expected for reply in replies)
    copied = replies[-1].trajectories[0].samples
    assert not copied.flags.writeable
    del replies, copied
    gc.collect()
    assert client.plan(scene).is_shared


def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


def open_files():
    return len(os.listdir("/proc/self/fd"))


def test_memory_is_flat_over_10_000_calls(client, scene):
    prepared = clearway.Scene(scene)

    def ask(count):
        for _ in range(count):
            trajectory = client.plan(prepared).trajectories[0]
            assert len(trajectory.samples) >= 100 and trajectory.legs

    ask(1_000)
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    before, files = resident(), open_files()
    ask(10_000)
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    grown = resident() - before
    assert grown < 2 << 20, f"{grown} bytes more after 10,000 calls"
    assert open_files() == files
