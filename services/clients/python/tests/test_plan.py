"""Planning: the same replies as without a bus, from every form of scene."""

import asyncio
import dataclasses
import json
import pickle

import numpy
import pytest
from conftest import SCENES, lines

import clearway


def reply_line(ask, scene_id):
    """The reply to one scene as `plan` prints it; of refusals what is not worded for people."""
    try:
        return ask().to_json()
    except clearway.RefusedError as refused:
        numbers = {name: value for name, value in vars(refused).items() if value is not None}
        reply = {} if scene_id is None else {"id": scene_id}
        return json.dumps(reply | {"error": numbers}, sort_keys=True)


def test_every_scene_is_answered_as_without_a_bus(domain, client):
    scenes = list(lines())
    local = domain.plan_local("-", stdin="\n".join(scenes))
    expected = local.stdout.splitlines()
    assert len(expected) == len(scenes) > 20
    for text, line in zip(scenes, expected):
        answer = json.loads(line)
        if "error" in answer:
            line = json.dumps(answer, sort_keys=True)
        assert reply_line(lambda: client.plan(text, timeout=60), answer.get("id")) == line
    many = client.plan_many(scenes, timeout=60)
    assert len(many) == len(scenes)
    for reply, line in zip(many, expected):
        if isinstance(reply, clearway.RefusedError):
            assert json.loads(line)["error"]["code"] == reply.code
        else:
            assert reply.to_json() == line


def test_samples_are_those_of_the_reply(client, scene):
    reply = client.plan(scene)
    (trajectory,) = reply.trajectories
    samples = trajectory.samples
    printed = json.loads(reply.to_json())["trajectories"][0]["samples"]
    assert samples["t"].tolist() == [sample["t"] for sample in printed]
    assert samples["position"][:, :2].tolist() == [sample["position"] for sample in printed]
    assert samples["heading"].tolist() == [sample["heading"] for sample in printed]
    assert samples["velocity"][:, :2].tolist() == [sample["velocity"] for sample in printed]
    assert samples["yaw_rate"].tolist() == [sample["yaw_rate"] for sample in printed]


def test_a_trajectory_says_what_the_reply_says(client, scene):
    reply = client.plan(scene | {"id": 7})
    printed = json.loads(reply.to_json())["trajectories"][0]
    (trajectory,) = reply.trajectories
    assert reply.id == 7
    assert trajectory.length == printed["length"]
    assert trajectory.duration == printed["duration"]
    assert trajectory.clearance.value == printed["clearance"]["value"]
    assert trajectory.clearance.wall == tuple(printed["clearance"]["wall"])
    assert trajectory.route == tuple(printed["route"])
    assert [list(gap) for gap in trajectory.gap] == printed["gap"]
    assert trajectory.bound is None and trajectory.complete
    assert len(trajectory.legs) == len(printed["legs"])
    for leg, line in zip(trajectory.legs, printed["legs"]):
        assert (leg.kind, list(leg.from_), list(leg.to)) == ("line", line["from"], line["to"])
        assert (leg.length, leg.clearance) == (line["length"], line["clearance"])
        assert leg.rule == line.get("rule")
        assert leg.center is None


def test_robots_have_bounds_and_arcs(client):
    scene = json.loads((SCENES / "drive-a.json").read_text()) | {"report": "full"}
    reply = client.plan(scene)
    printed = json.loads(reply.to_json())["trajectories"]
    for trajectory, said in zip(reply.trajectories, printed):
        assert trajectory.bound == said["bound"]
        assert trajectory.free_clearance == said["free_clearance"]
        assert {leg.kind for leg in trajectory.legs} == {leg["kind"] for leg in said["legs"]}
        arcs = [leg for leg in trajectory.legs if leg.kind == "arc"]
        assert all(leg.radius > 0 and len(leg.center) == 2 for leg in arcs)


@dataclasses.dataclass
class Space:
    channels: list
    in_order: bool = True


@dataclasses.dataclass
class Disassembly:
    free_space: Space
    body: dict
    clearance: dict
    task: str = "disassemble"
    id: int | None = None


def test_scenes_are_mappings_dataclasses_arrays_texts_or_prepared(client, scene):
    del scene["sampling"]
    expected = client.plan(scene).to_json()
    polygon = numpy.array(scene["body"]["polygon"])
    dataclass = Disassembly(
        Space(scene["free_space"]["channels"]), {"polygon": polygon}, {"gap": numpy.float64(0.2)}
    )
    prepared = clearway.Scene(scene)
    for form in (json.dumps(scene), dataclass, prepared, clearway.Scene(dataclass), prepared.with_name()):
        assert client.plan(form).to_json() == expected


def test_what_is_no_scene_is_refused_by_name(client, scene):
    with pytest.raises(clearway.InvalidScene) as refused:
        client.plan(scene | {"clearance": {"gap": "wide"}})
    assert refused.value.field == "clearance.gap"
    with pytest.raises(clearway.InvalidScene, match="JSON|expected"):
        client.plan("{")
    for wrong in (None, 7, [1], b"{}", {"task": object()}):
        with pytest.raises(TypeError, match="scene"):
            client.plan(wrong)
    for timeout in (-1.0, float("nan")):
        with pytest.raises(ValueError, match="timeout"):
            client.plan(scene, timeout=timeout)


def test_refusals_are_exceptions_of_their_own_with_numbers(client, scene):
    scene["free_space"]["channels"][2]["max"][0] = 2.5
    with pytest.raises(clearway.RefusedError) as caught:
        client.plan(scene)
    refused = caught.value
    assert type(refused) is not clearway.RefusedError
    assert refused.needs > refused.has
    assert str(refused).startswith(refused.code + ": ")
    again = pickle.loads(pickle.dumps(refused))
    assert (type(again), vars(again)) == (type(refused), vars(refused))


def test_every_code_has_an_exception():
    from clearway import _clearway, _errors

    assert sorted(_errors._KINDS) == sorted(_clearway.ERROR_CODES)


def test_of_several_answers_each_stands_for_itself(client, scene):
    reply = client.plan(scene | {"clearance": {"each": [0.2, 50.0, "safest"]}})
    kinds = [type(answer) for answer in reply.answers]
    assert kinds == [clearway.Trajectory, clearway.GapOutOfRange, clearway.Trajectory]
    assert reply.answers[1].most is not None
    with pytest.raises(clearway.GapOutOfRange):
        reply.trajectories


def test_requests_can_be_polled_and_cancelled(client, scene, endless):
    pending = client.start(scene)
    assert pending.fileno() >= 0
    reply = pending.wait()
    assert reply.to_json() == client.plan(scene).to_json()
    with pytest.raises(clearway.ClearwayError, match="done"):
        pending.poll()
    slow = client.start(endless)
    assert slow.poll() is None
    with pytest.raises(clearway.PlanTimeoutError):
        slow.wait(0.05)
    assert slow.poll() is None
    slow.cancel()
    assert client.plan(scene).id is None


def test_requests_are_awaited(client, scene, endless):
    expected = client.plan(scene).to_json()

    async def ask():
        replies = await asyncio.gather(*(client.plan_async(scene) for _ in range(100)))
        assert all(reply.to_json() == expected for reply in replies)
        with pytest.raises(clearway.InvalidScene):
            await client.plan_async({})
        with pytest.raises(TimeoutError):
            await client.plan_async(endless, timeout=0.05)
        task = asyncio.create_task(client.plan_async(endless, timeout=None))
        await asyncio.sleep(0.02)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        return await client.plan_async(scene)

    assert asyncio.run(ask()).to_json() == expected
    assert asyncio.run(client.plan_async(scene)).to_json() == expected
