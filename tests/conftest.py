"""A made-up Result with everything in it: smooth fields on a small half finger, and spikes."""

import dataclasses
import gc
import importlib
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import recomputed
from _pytest.assertion import rewrite
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from fefinger.fem.linalg import multifrontal_indefinite
from fefinger.mechanics.press import elastic_press, finite_strain, load_steps, small_strain
from fefinger.neural.drives import Reference
from fefinger.neural.trains import SpikeTrains
from fefinger.result import Result
from fefinger.results.records import Fields, Pad, Refusal, Response, Rung, Sites
from fefinger.results.result_record import Plan, trust
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.motions import RampHold
from fefinger.scene.scene import Scene
from fefinger.support import machine, registry
from fefinger.support.arrays import Array, Integers
from fefinger.support.tolerances import EQUILIBRIUM


recomputed.install(rewrite)

TYPES = ("SAI", "SAII", "FAI", "FAII")
DEPTHS = (0.8, 1.8, 0.6, 3.0)
AXIS = np.array([-0.5, 0.0, np.sqrt(0.75)])  # travel of a plate at 30 degrees
DEPTH = 1.5  # mm


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Keep the tests of a file in one process: what they share is then made and compiled once."""
    from xdist.scheduler import LoadFileScheduling

    return LoadFileScheduling(config, log)


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session: pytest.Session) -> None:
    """Share the work of compiling the test modules."""
    recomputed.compile_share(rewrite, session.config)


def pytest_collection_finish() -> None:
    """Keep what is there for good, some million objects, out of every collection of garbage."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def one_thread() -> Iterator[None]:
    """Keep BLAS to one thread: the tests run side by side, and threads that spin slow them down."""
    with threadpool_limits(1, user_api="blas"):
        yield


@pytest.fixture(scope="session", autouse=True)
def empty_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Keep the user's cache out: the planner prefers an operator that is in it."""
    with pytest.MonkeyPatch.context() as patched:
        folder = tmp_path_factory.mktemp("empty")
        patched.setenv("XDG_CACHE_HOME", str(folder))
        yield folder


@pytest.fixture(autouse=True)
def _leaves_no_operator(empty_cache: Path) -> Iterator[None]:
    """Keep what a test builds from later ones: it has to ask for the fixture `operators`."""
    yield
    left = empty_cache / "fefinger" / "operators"
    if left.exists():
        shutil.rmtree(left)
        pytest.fail("this test built an operator without the fixture `operators`")


@pytest.fixture(scope="session", autouse=True)
def _machine_of_the_reports() -> Iterator[None]:
    """Expect the times of the reports: what `ask.seconds` allows must not hang on this machine."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(machine, "measure", lambda: machine.REPORTED)
        yield


@pytest.fixture(scope="session")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a cache for the tests that build operators."""
    return tmp_path_factory.mktemp("kept")


@pytest.fixture
def operators(kept: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of the operators that those tests share."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(kept))
    return kept / "fefinger" / "operators"


@pytest.fixture(scope="module")
def module_operators(kept: Path) -> Iterator[None]:
    """Keep to those operators in all fixtures and tests of a module."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("XDG_CACHE_HOME", str(kept))
        yield


@pytest.fixture
def own_registry(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forget what a test registers."""
    for each in registry.REGISTRIES:
        monkeypatch.setattr(each, "_things", dict(each._things))


@pytest.fixture(scope="session")
def stride_far() -> Callable[[pytest.MonkeyPatch], None]:
    """Return a patch with which `solid` takes six steps to a peak instead of 24."""

    def patch(patched: pytest.MonkeyPatch) -> None:
        patched.setattr(load_steps, "BY_DISTANCE", 2)
        patched.setattr(load_steps, "BY_TIME", 4)
        patched.setattr(load_steps, "SPRING_ERROR", 0.1)

    return patch


@pytest.fixture
def few_steps(
    stride_far: Callable[[pytest.MonkeyPatch], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Take few steps through time, where time is not the question."""
    stride_far(monkeypatch)


@pytest.fixture
def few_depths(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Tabulate presses for `pressed` at seven depths instead of 19, in a cache of the test."""
    monkeypatch.setattr(elastic_press, "STEPS", 8)
    monkeypatch.setattr(elastic_press, "FEWEST", 4)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


@pytest.fixture
def iterated_far(monkeypatch: pytest.MonkeyPatch) -> None:
    """Iterate presses of `solid` as far as any body, where answers are compared to many digits."""
    monkeypatch.setattr(finite_strain, "PRESS_EQUILIBRIUM", EQUILIBRIUM)


@pytest.fixture(scope="session")
def synthetic() -> Result:
    """Return a Result with pressure, strain, spikes and fields of half a finger."""
    return make_synthetic()


@pytest.fixture
def answered(monkeypatch: pytest.MonkeyPatch, synthetic: Result) -> list:
    """Answer every scene with the synthetic result; return the calls that were made."""
    calls = []

    def run(scene, **options):
        calls.append((scene, options))
        return synthetic

    monkeypatch.setattr(importlib.import_module("fefinger.pipeline"), "run", run)
    return calls


@pytest.fixture
def plain_report(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write an empty page for the report, which has its own tests."""
    write = "fefinger.pages.report.write"
    monkeypatch.setattr(write, lambda result, path: Path(path).write_text("report"))


def make_synthetic() -> Result:
    """Return a Result of smooth made-up fields on half a finger of 6 tetrahedra per box."""
    ask = Ask(spikes=TYPES)
    motion = RampHold(speed=60, depth=DEPTH, hold=5)
    scene = Scene(
        name="synthetic",
        finger=Finger.subject("a.h.", tissue="maeno1998"),
        indenter=Flat(30.0),
        motion=motion,
        ask=ask,
    )
    time = np.unique(np.concatenate([np.linspace(0, 0.05, 30), np.geomspace(0.05, 5, 60)]))
    depth = motion.value(time)
    points, tetrahedra, region = half_finger()
    frames = np.linspace(0.02, 5.0, 3)
    fields = make_fields(points, tetrahedra, region, frames, motion.value(frames))
    pad = make_pad(points, tetrahedra)
    radius = np.sqrt(7 * depth)
    shape = np.exp(-0.2 * time)
    sites = Sites(np.outer(DEPTHS, AXIS), np.tile(-AXIS, (4, 1)), np.array(DEPTHS), TYPES)
    strain = np.stack([strain_of(sites.points, d) for d in depth])
    response = Response(
        mechanics="linear",
        time=time,
        depth=depth,
        force=0.8 * depth**1.5 * shape,
        contact_area=np.pi * radius**2,
        centroid=np.where(depth[:, None] > 0, np.outer(depth, [0.3, 0.0]), np.nan),
        pad=pad,
        pressure=np.stack([pressure_of(pad.points, d) for d in depth]) * shape[:, None],
        sites=sites,
        strain=strain,
        reference=Reference(0.5, TYPES, sites.normals, strain_of(sites.points, 0.5)),
        fields=fields,
        status="converged: every contact step in at most 5 iterations",
        seconds={"mesh": 0.41, "factor": 1.7, "contact": 8.2, "fields": 0.9},
        notes=("Small strain: geometry of the undeformed finger.", "No inertia."),
        numbers={"unknowns": 34567.0},
    )
    refusal = Refusal("linear", "accuracy", "depth / half thickness = 0.3 > 0.2")
    rungs = (
        Rung(
            "hertz",
            0.01,
            0.8,
            "reports/finger.json",
            (Refusal("hertz", "accuracy", "contact radius / tissue thickness = 0.9 > 0.1"),),
        ),
        Rung("linear", 12.0, 0.04, "reports/held-out.json", (refusal,), errors={"area": 0.03}),
    )
    chosen = "linear: the cheapest that does not refuse."
    return Result(
        scene=scene,
        plan=Plan("linear", rungs, chosen, (refusal,), trust=trust(rungs[1], scene.ask)),
        response=response,
        spikes=make_spikes(time, depth, sites.points),
        status="done",
        seconds={"plan": 0.01, "mechanics": 11.2, "neural": 1.3},
        provenance={"versions": {"fefinger": "0.1.0", "numpy": "2"}, "list": [1, (2.5, None)]},
    )


def half_finger() -> tuple[Array, Integers, NDArray[np.int8]]:
    """Return points, tetrahedra and regions of half a round-tipped rod, first touch at 0."""
    nx, ny, nz = 12, 4, 8
    grid = np.meshgrid(
        np.linspace(-14, 8, nx + 1),
        np.linspace(0, 1, ny + 1),
        np.linspace(-1, 1, nz + 1),
        indexing="ij",
    )
    x, v, w = (axis.ravel() for axis in grid)
    size = np.sqrt(np.clip(1 - (np.clip(x, 0, None) / 8.5) ** 2, 0.02, None))
    y = 7 * size * v * np.sqrt(1 - w**2 / 2)
    z = 5 * size * w * np.sqrt(1 - v**2 / 2)
    points = np.column_stack([x, y, z])
    index = np.arange(len(points)).reshape(nx + 1, ny + 1, nz + 1)
    corner = [
        index[i : nx + i, j : ny + j, k : nz + k].ravel()
        for i in (0, 1)
        for j in (0, 1)
        for k in (0, 1)
    ]
    ring = (1, 3, 2, 6, 4, 5)  # of edges around the diagonal from 0 to 7
    split = [(0, b, a, 7) for a, b in zip(ring, np.roll(ring, -1), strict=True)]
    tetrahedra = np.concatenate([np.column_stack([corner[c] for c in row]) for row in split])
    outer = np.maximum(v, np.abs(w))[tetrahedra].mean(axis=1)
    region = np.where(outer > 0.78, 1, 2).astype(np.int8)
    medial = np.flatnonzero(points[:, 1] == 0)
    points -= points[medial[np.argmin(points[medial] @ AXIS)]]
    return points, tetrahedra, region


def displacement_of(points: Array, depth: float) -> Array:
    """Return a smooth displacement along the plate's travel that decays over 5 mm."""
    return depth * np.exp(-np.sum(points**2, axis=1) / 25)[:, None] * AXIS


def strain_of(points: Array, depth: float) -> Array:
    """Return the exact small strain (n, 3, 3) of `displacement_of`."""
    u = displacement_of(points, depth)
    gradient = -2 * u[:, :, None] * points[:, None, :] / 25
    return (gradient + gradient.transpose(0, 2, 1)) / 2


def pressure_of(points: Array, depth: float) -> Array:
    """Return a Hertz-like pressure in kPa on a disc about the origin."""
    radius = np.sqrt(7 * max(depth, 1e-9))
    return 12 * radius * np.sqrt(np.clip(1 - np.sum(points**2, axis=1) / radius**2, 0, None))


def make_fields(
    points: Array,
    tetrahedra: Integers,
    region: NDArray[np.int8],
    times: Array,
    depths: Array,
) -> Fields:
    """Return the fields at `times`, with pressure on the palmar surface only."""
    pad = np.unique(surface_of(points, tetrahedra))
    pressure = np.zeros((len(times), len(points)))
    pressure[:, pad] = [pressure_of(points[pad], d) for d in depths]
    strain = np.stack([strain_of(points, d) for d in depths])
    six = strain[:, :, [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    displacement = np.stack([displacement_of(points, d) for d in depths])
    return Fields(points, tetrahedra, region, times, displacement, six, pressure)


def surface_of(points: Array, tetrahedra: Integers) -> Integers:
    """Return the outer triangles (k, 3) off the medial plane and the proximal end, pad side."""
    faces = tetrahedra[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3)
    _, first, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = faces[first[count == 1]]
    medial = (points[outer][:, :, 1] == 0).all(axis=1)
    proximal = (points[outer][:, :, 0] == points[:, 0].min()).all(axis=1)
    palmar = points[outer][:, :, 2].mean(axis=1) < 4
    return outer[~medial & ~proximal & palmar]


def make_pad(points: Array, tetrahedra: Integers) -> Pad:
    """Return the pad of the whole finger: the half surface and its mirror image."""
    triangles = surface_of(points, tetrahedra)
    used, local = np.unique(triangles, return_inverse=True)
    local = local.reshape(-1, 3)
    half = points[used]
    both = np.concatenate([half, half * [1, -1, 1]])
    both_triangles = np.concatenate([local, local + len(half)])
    a, b, c = both[both_triangles].transpose(1, 0, 2)
    size = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6
    areas = np.bincount(both_triangles.ravel(), np.repeat(size, 3), minlength=len(both))
    center = np.array([0.0, 0.0, 5.0])
    normals = (both - center) / np.linalg.norm(both - center, axis=1, keepdims=True)
    return Pad(both, areas, normals, both_triangles)


def make_spikes(time: Array, depth: Array, positions: Array) -> SpikeTrains:
    """Return four units: regular, slower, onset only, and silent."""
    trains = (
        np.concatenate([np.linspace(0.01, 0.05, 9), np.arange(0.1, 5, 0.05)]),
        np.concatenate([np.linspace(0.012, 0.05, 6), np.arange(0.12, 5, 0.11)]),
        np.linspace(0.008, 0.04, 5),
        np.empty(0),
    )
    x_in = np.outer(depth, [1.0, 0.7, 1.2, 0.4])
    return SpikeTrains(
        types=TYPES,
        names=tuple(f"{kind}-1" for kind in TYPES),
        times=trains,
        t_start=0.0,
        t_stop=float(time[-1]),
        time=time,
        x_in=x_in,
        current=20 * x_in / (1 + x_in),
        peak_mV=np.array([100.0, 98.0, 97.0, 12.0]),
        block_seconds=np.zeros(4),
        stimulus_driven=np.array([0, 0, 1, 0]),
        positions=positions,
        notes=("SAI-1: made up.",),
    )


@pytest.fixture
def saved(synthetic: Result, monkeypatch: pytest.MonkeyPatch) -> Result:
    """Let `fefinger view` find the synthetic result in every folder."""
    monkeypatch.setattr("fefinger.result.load", lambda folder: synthetic)
    return synthetic


@pytest.fixture
def without_fields(synthetic: Result) -> Result:
    """Return the synthetic result without fields on the mesh."""
    response = dataclasses.replace(synthetic.response, fields=None)
    return dataclasses.replace(synthetic, response=response)


@pytest.fixture
def unsound(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Return a patch with which LAPACK's inverse of a block is nan in some precisions."""

    def fail(*precisions: type) -> None:
        sound = multifrontal_indefinite.get_lapack_funcs

        def functions(names: tuple[str, ...], blocks: tuple[np.ndarray]) -> list[object]:
            *others, invert = sound(names, blocks)
            if blocks[0].dtype.type not in precisions:
                return [*others, invert]
            return [*others, lambda *given, **how: (np.nan * invert(*given, **how)[0], 0)]

        monkeypatch.setattr(multifrontal_indefinite, "get_lapack_funcs", functions)
        monkeypatch.setattr(small_strain, "_kept", {})  # with factors that did not fail

    return fail
