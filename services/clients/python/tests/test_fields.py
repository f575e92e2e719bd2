"""Every field of a reply is there in Python, under its name and with its value."""

import ast
import json
import math

import pytest
from conftest import ROOT, SCENES, lines

import clearway

STUBS = ROOT / "services" / "clients" / "python" / "python" / "clearway" / "__init__.pyi"

#: Fields that have another name here: `from` is a keyword.
RENAMED = {"from": "from_"}

#: What stands for a field that a reply leaves out, if not None.
LEFT_OUT = {"reverse": False, "complete": True, ("line", "turned"): 0.0, "channels": ()}


def schema():
    return json.loads((ROOT / "schemas" / "json" / "reply.schema.json").read_text())


def fields(definition):
    """The names of the fields that an object of the schema can have."""
    forms = [definition, *definition.get("oneOf", ())]
    return {name for form in forms for name in form.get("properties", ())}


KINDS = {
    "trajectory": clearway.Trajectory,
    "leg": clearway.Leg,
    "exceeds": clearway.Exceeds,
    "nearest_wall": clearway.Clearance,
    "error": clearway.RefusedError("internal", ""),
}


@pytest.mark.parametrize("kind", KINDS)
def test_objects_have_the_fields_of_the_schema(kind):
    names = fields(schema()["$defs"][kind])
    assert names, "the schema has such an object"
    missing = [name for name in names if not hasattr(KINDS[kind], RENAMED.get(name, name))]
    assert missing == [], f"fields of {kind} that Python does not have"


def test_the_schema_has_no_objects_beside_these():
    # Boxes and half-spaces are those of scenes; samples are below.
    objects = {name for name, definition in schema()["$defs"].items() if fields(definition)}
    assert objects == {*KINDS, "answer", "box", "half_space", "sample"}
    assert fields(schema()) == {"id", "trajectories", "error"}


def test_samples_have_the_fields_of_the_schema(client, scene):
    samples = client.plan(scene).trajectories[0].samples
    assert set(samples.dtype.names) == fields(schema()["$defs"]["sample"])


def shown(kind, value, said):
    """Compares an object with what the JSON of the reply says of it."""
    for name in fields(schema()["$defs"][kind]):
        found = getattr(value, RENAMED.get(name, name))
        if (said.get("kind"), name) == ("turn", "sweep"):
            continue  # A turn in place has it here, and the JSON says both headings.
        if name not in said:
            assert found == LEFT_OUT.get((said.get("kind"), name), LEFT_OUT.get(name)), name
            continue
        expected = said[name]
        if name == "legs":
            assert len(found) == len(expected)
            for leg, line in zip(found, expected):
                shown("leg", leg, line)
        elif name == "exceeds":
            shown("exceeds", found, expected)
        elif name == "clearance" and kind == "trajectory":
            shown("nearest_wall", found, expected)
        elif name == "samples":
            for field in found.dtype.names:
                values = found[field]
                values = values[:, : value.dimension] if values.ndim == 2 else values
                assert values.tolist() == [sample[field] for sample in expected], field
        elif name == "channels":
            assert [(tuple(box["min"]), tuple(box["max"])) for box in expected] == list(found)
        elif expected is None:
            assert found == math.inf, name
        else:
            assert json.loads(json.dumps(found)) == expected, name


def test_every_field_of_every_reply_has_its_value(client):
    scenes = [json.loads(line) for line in lines()]
    scenes += [scene | {"report": "full"} for scene in scenes if scene["task"] == "drive"]
    met = set()
    for scene in scenes:
        try:
            reply = client.plan(scene, timeout=60)
        except clearway.RefusedError:
            continue
        said = json.loads(reply.to_json())
        assert reply.id == said.get("id")
        for answer, line in zip(reply.answers, said["trajectories"], strict=True):
            if isinstance(answer, clearway.RefusedError):
                shown("error", answer, line["error"])
            else:
                met |= line.keys()
                shown("trajectory", answer, line)
    assert met >= fields(schema()["$defs"]["trajectory"]) - {"complete"}


def test_a_robot_says_what_it_exceeds(client):
    scene = json.loads((SCENES / "drive-a.json").read_text()) | {"corners": "arc"}
    for trajectory in client.plan(scene).trajectories:
        exceeds = trajectory.exceeds
        assert (exceeds.limit, type(exceeds.joints)) == ("yaw_acceleration", int)
        assert exceeds.joints > 0 and exceeds.jump > 0
        assert trajectory.stops is None
    for trajectory in client.plan(scene | {"corners": "smooth"}).trajectories:
        assert trajectory.exceeds is None
        assert trajectory.stops is not None


def names_in_stub(node):
    names = set()
    for entry in node.body:
        if isinstance(entry, (ast.FunctionDef, ast.AsyncFunctionDef)):
            names.add(entry.name)
        elif isinstance(entry, ast.AnnAssign):
            names.add(entry.target.id)
    return {name for name in names if not name.startswith("_")}


def test_stubs_name_what_there_is():
    tree = ast.parse(STUBS.read_text())
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    for name, node in classes.items():
        kind = getattr(clearway, name)
        if issubclass(kind, Exception):
            continue
        there = {found for found in dir(kind) if not found.startswith("_")}
        assert names_in_stub(node) == there, name
    refused = vars(clearway.RefusedError("internal", ""))
    assert names_in_stub(classes["RefusedError"]) == set(refused)
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    assert classes.keys() | functions == set(clearway.__all__)
