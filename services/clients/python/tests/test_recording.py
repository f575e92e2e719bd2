"""Recordings and pictures."""

import json

import pytest
from conftest import ROOT, SCENES

import clearway


def test_recordings_yield_requests_and_their_replies():
    requests, replies = {}, {}
    recording = clearway.read_recording(ROOT / "recordings" / "driving.mcap")
    for message in recording:
        if isinstance(message, clearway.RecordedRequest):
            assert message.scene is not None and message.sent_ns > 0
            requests[message.key] = message.scene
        else:
            assert message.key in requests, "a request comes before its reply"
            assert (message.reply is None) != (message.refusal is None)
            replies[message.key] = message
    assert len(requests) == len(replies) > 3
    assert (recording.lost, recording.unfinished) == (0, 0)
    kept = [message.reply for message in replies.values() if message.reply]
    assert any(len(trajectory.samples) > 100 for reply in kept for trajectory in reply.trajectories)
    sampled = [reply for reply in kept if any(len(path.samples) for path in reply.trajectories)]
    assert sampled and not any(reply.is_shared for reply in sampled)


def test_recorded_scenes_are_answered_as_recorded(client):
    requests = {}
    for message in clearway.read_recording(ROOT / "recordings" / "disassembly.mcap"):
        if isinstance(message, clearway.RecordedRequest):
            requests[message.key] = message.scene
        elif message.reply is not None:
            assert client.plan(requests[message.key], 60).to_json() == message.reply.to_json()


def test_damage_is_an_error(tmp_path):
    with pytest.raises(clearway.RecordingError, match="none.mcap"):
        clearway.read_recording(tmp_path / "none.mcap")
    bytes_ = bytearray((ROOT / "recordings" / "driving.mcap").read_bytes())
    bytes_[len(bytes_) // 2] ^= 1
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(bytes_)
    with pytest.raises(clearway.RecordingError):
        list(clearway.read_recording(broken))


@pytest.mark.parametrize("name", ["drive-a.json", "disassemble-channels.json", "drive-office-boxes.json"])
def test_replies_are_drawn(client, tmp_path, name):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as pyplot

    text = (SCENES / name).read_text()
    reply = client.plan(text, 60)
    figure, axes = pyplot.subplots()
    assert clearway.plot(reply, text, ax=axes) is axes
    assert len(axes.lines) == len(json.loads(reply.to_json())["trajectories"])
    assert axes.patches
    figure.savefig(tmp_path / "picture.png")
    pyplot.close(figure)
