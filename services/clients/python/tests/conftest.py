"""Real planners, each in a domain of its own, of which nothing may be left in the end."""

import gc
import itertools
import json
import os
import pathlib
import signal
import subprocess
import tempfile
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[4]
SCENES = ROOT / "recordings" / "scenes"
COUNT = itertools.count()


def lines():
    """Every scene of the repository that needs no map, as JSON."""
    for path in sorted(SCENES.iterdir()):
        if path.suffix == ".json" and path.name != "drive-office.json":
            yield json.dumps(json.loads(path.read_text()))
        elif path.suffix == ".jsonl":
            yield from path.read_text().splitlines()


def program(name):
    """Built by cargo; CLEARWAY_PROGRAMS says where if not in target/debug or target/release."""
    folders = [ROOT / "target" / profile for profile in ("debug", "release")]
    if chosen := os.environ.get("CLEARWAY_PROGRAMS"):
        folders = [pathlib.Path(chosen)]
    found = [folder / name for folder in folders if (folder / name).exists()]
    assert found, f"no {name} in {folders}: run `cargo build -p clearway-{name}`"
    return max(found, key=lambda path: path.stat().st_mtime)


class Domain:
    def __init__(self, root):
        self.name = f"py-{os.getpid()}-{next(COUNT)}"
        self.root = root
        self.planners = []
        self.liars = []

    def start_planner(self, *arguments):
        log = self.root.parent / f"{self.name}-planner-{len(self.planners)}"
        with open(log, "wb") as stderr:
            planner = subprocess.Popen(
                [program("planner"), "--domain", self.name, *arguments], stderr=stderr
            )
        self.planners.append(planner)
        until = time.monotonic() + 60
        while "ready" not in log.read_text():
            assert planner.poll() is None and time.monotonic() < until, log.read_text()
            time.sleep(0.005)
        return planner

    def start_raw_planner(self, lie):
        """A planner that lies, and leaves what it has made to others."""
        command = [program("raw-planner"), self.name, lie]
        liar = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.liars.append(liar)
        assert liar.stdout.readline() == "ready\n"

    def plan_local(self, *arguments, stdin=None):
        command = [program("plan"), "--local", "--format", "json", *arguments]
        return subprocess.run(command, input=stdin, capture_output=True, text=True, timeout=300)

    def close(self):
        for planner in self.planners:
            if planner.poll() is None:
                planner.send_signal(signal.SIGTERM)
                assert planner.wait(60) == 0
        for liar in self.liars:
            liar.kill()
            liar.wait()
            key = f"{liar.pid % 100_000:05}".translate(str.maketrans("0123456789", "abcdefghij"))
            for path in pathlib.Path("/dev/shm").glob(f"cw_raw{key}_*"):
                path.unlink()
            (self.root / f"{self.name}.toml").unlink(missing_ok=True)
        # What killed programs leave is removed by the next that comes; nobody else leaves anything.
        gc.collect()
        left = [path.name for path in self.root.glob("*.toml")] if self.root.exists() else []
        assert left == [], "somebody is still in the domain"


@pytest.fixture
def domain(monkeypatch):
    # There are sockets below it, so its path is short.
    with tempfile.TemporaryDirectory(prefix="cw-") as folder:
        root = pathlib.Path(folder) / "root"
        monkeypatch.setenv("CLEARWAY_ROOT", str(root))
        domain = Domain(root)
        yield domain
        domain.close()


@pytest.fixture
def planner(domain):
    return domain.start_planner()


@pytest.fixture
def client(domain, planner):
    import clearway

    with clearway.Client(domain.name) as client:
        yield client


@pytest.fixture
def scene():
    """Section 4 of the paper, with 100 samples."""
    return {
        "task": "disassemble",
        "free_space": {
            "channels": [
                {"min": [4, 1], "max": [7, 6]},
                {"min": [1, 2], "max": [7, 6]},
                {"min": [1, 2], "max": [5, 7]},
            ],
            "in_order": True,
        },
        "body": {"polygon": [[4.5, 1.01], [4.5, 4], [6.99, 4], [6.99, 1.01]]},
        "clearance": {"gap": 0.2},
        "sampling": {"count": 100},
    }


@pytest.fixture
def endless():
    """Takes the planner minutes."""
    solids = [
        {"box": {"min": [3 * x + 1.5, 3 * y + 1.5], "max": [3 * x + 2.5, 3 * y + 2.5]}}
        for x in range(50)
        for y in range(50)
    ]
    return {
        "task": "drive",
        "free_space": {"solids": solids, "bounds": {"min": [0, 0], "max": [151, 151]}},
        "body": {"footprint": {"width": 0.4, "length": 0.6}},
        "start": {"position": [0.75, 0.75], "heading": 0.0},
        "goal": {"position": [150.25, 150.25]},
        "clearance": {"each": [0.1 + 1e-6 * index for index in range(9_999)]},
    }
