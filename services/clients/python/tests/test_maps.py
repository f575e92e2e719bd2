"""Maps of cells as free space."""

import json

import numpy
import pytest
from conftest import SCENES

import clearway


def office():
    """The picture of the floor plan as cells: rows from below, 100 where it is dark, -1 between."""
    header, size, most, shades = (SCENES / "office.pgm").read_bytes().split(b"\n", 3)
    assert (header, most) == (b"P5", b"255")
    width, height = (int(number) for number in size.split())
    shades = numpy.frombuffer(shades, numpy.uint8).reshape(height, width)[::-1]
    return numpy.where(shades > 250, 0, numpy.where(shades < 89, 100, -1)).astype(numpy.int8)


def test_a_grid_is_the_map_of_its_picture(domain, client):
    scene = json.loads((SCENES / "drive-office.json").read_text())
    local = domain.plan_local("--map", str(SCENES / "office.yaml"), str(SCENES / "drive-office.json"))
    space = clearway.free_space_of_grid(office(), *frame())
    first = client.plan(scene | {"free_space": space}, timeout=60)
    assert first.to_json() == local.stdout.strip()
    named = scene | {"free_space": {"named": space["named"]}}
    assert client.plan(named).to_json() == first.to_json()


def frame():
    lines = (line.split(":", 1) for line in (SCENES / "office.yaml").read_text().splitlines() if ":" in line)
    fields = {name.strip(): value for name, value in lines}
    return float(fields["resolution"]), tuple(json.loads(fields["origin"]))


def test_a_name_that_the_planner_does_not_know_is_refused(client):
    scene = json.loads((SCENES / "drive-office.json").read_text())
    with pytest.raises(clearway.UnknownFreeSpace):
        client.plan(scene | {"free_space": {"named": "0" * 64}})


def test_integers_of_any_size_are_cells(client):
    cells = numpy.array([[0, 25, 26], [-1, 101, 0]])
    small = clearway.free_space_of_grid(cells.astype(numpy.int8), 0.5)
    for kind in (numpy.int64, numpy.int16):
        assert clearway.free_space_of_grid(cells.astype(kind), 0.5) == small
    assert clearway.free_space_of_grid(numpy.where(cells < 0, 255, cells).astype(numpy.uint8), 0.5) == small
    assert clearway.free_space_of_grid(cells.tolist(), 0.5) == small
    assert small["bounds"] == {"min": [0.0, 0.0], "max": [1.5, 1.0]}
    assert clearway.free_space_of_grid(cells, 0.5, unknown="free") != small
    assert clearway.free_space_of_grid(cells, 0.5, free_most=99) != small


@pytest.mark.parametrize(
    ("cells", "options", "said"),
    [
        ([[100]], {}, "none of the map's 1 cells is free"),
        ([[]], {}, "two dimensions|0 x 1"),
        ([0, 0], {}, "two dimensions"),
        ([[0.5]], {}, "integers"),
        ([[0]], {"resolution": 0.0}, "resolution is 0"),
        ([[0]], {"origin": (0.0, float("nan"), 0.0)}, "origin is NaN"),
        ([[0]], {"free_most": 100}, "free_most is 100"),
        ([[0]], {"unknown": "red"}, "unknown is"),
    ],
)
def test_what_is_no_map_is_refused(cells, options, said):
    with pytest.raises(ValueError, match=said):
        clearway.free_space_of_grid(cells, **({"resolution": 0.5} | options))
