"""Units that are stepped, against the same units solved at once."""

import numpy as np
import pytest
from fefinger.validation.neural.connor_stevens import ConnorStevens
from refusals import refused

from fefinger.neural.drives import Reference, equivalent_displacements
from fefinger.neural.endorgans import GAINS, transduce
from fefinger.neural.membranes import HodgkinHuxley, IntegrateAndFire
from fefinger.neural.stepped import ROOM
from fefinger.neural.streaming import Afferents
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import TYPES


TIME = np.arange(801) * 1e-3
NORMALS = np.array([[0.0, 0.6, -0.8], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.6, 0.8, 0.0]])
SQUEEZE = np.array([[0.10, 0.02, 0.01], [0.02, 0.08, -0.03], [0.01, -0.03, -0.17]])
REFERENCE = Reference(0.5, TYPES, np.tile([0.0, 0.0, -1.0], (4, 1)), np.tile(SQUEEZE, (4, 1, 1)))


def strain() -> np.ndarray:
    """Return tensors (n_t, 4, 3, 3) of a press that begins with a jump, shakes and turns."""
    rng = np.random.default_rng(1)
    other = rng.normal(scale=0.05, size=(3, 3))
    press = np.minimum(0.2 + TIME / 0.05, 1.0) + 0.3 * np.sin(2 * np.pi * 20 * TIME) * (TIME > 0.4)
    turn = np.sin(5 * TIME)[:, None, None] * (other + other.T)
    return np.repeat((press[:, None, None] * SQUEEZE + turn)[:, None], 4, axis=1)


def voigt(tensors: np.ndarray) -> np.ndarray:
    return tensors[..., [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]


def streamed(units: Afferents, rows: np.ndarray) -> list[np.ndarray]:
    """Return the spike times of every unit."""
    fired: list[list[float]] = [[] for _ in units.types]
    for k, row in enumerate(rows):
        count = units.step(row, 1e-3 if k else 0.0)
        assert count == len(units.fired())
        for unit, time in units.fired():
            fired[unit].append(time)
    return [np.array(each) for each in fired]


def solved(tensors: np.ndarray, membrane: object, substeps: int, **how: object) -> tuple:
    """Return the spike times of the same units, their currents sampled likewise, in one go."""
    x_in = equivalent_displacements(tensors, NORMALS, TYPES, REFERENCE)
    fine = np.linspace(0, TIME[-1], substeps * (len(TIME) - 1) + 1)
    currents = [
        transduce(kind, TIME, x_in[:, i], gain=GAINS[kind], at=fine) for i, kind in enumerate(TYPES)
    ]
    return membrane.fire(fine, np.transpose(currents), stimulus_driven=False, **how).times


@pytest.mark.parametrize(
    ("substeps", "precision", "close"),
    [(20, np.float64, 1e-9), (4, np.float64, 1e-4), (20, np.float32, 1e-5)],
)
def test_units_fire_as_those_that_are_solved_at_once(
    substeps: int, precision: type, close: float
) -> None:
    tensors = strain()
    expected = solved(tensors, IntegrateAndFire(), 20)
    units = Afferents.of(TYPES, NORMALS, REFERENCE, substeps=substeps)
    trains = streamed(units, voigt(tensors).astype(precision))
    assert sum(map(len, trains)) > 20
    for a, b in zip(trains, expected, strict=True):
        assert a == pytest.approx(b, abs=close)
    units.reset()
    again = streamed(units, voigt(tensors).astype(precision))
    # exact: one code on one state, reset
    assert all(np.array_equal(a, b) for a, b in zip(trains, again, strict=True))


@pytest.mark.parametrize("method", ["splitting", "runge-kutta"])
@pytest.mark.parametrize("copies", [1, 2, 5])
def test_hodgkin_huxley_units_fire_as_those_that_are_solved_at_once(
    method: str, copies: int
) -> None:
    tensors, membrane = strain(), HodgkinHuxley(2.0)
    expected = solved(tensors, membrane, 4, method=method, dt=2.5e-5) * copies
    types, normals = TYPES * copies, np.tile(NORMALS, (copies, 1))
    how = {"membrane": membrane, "method": method, "dt": 2.5e-5}
    units = Afferents.of(types, normals, REFERENCE, substeps=4, **how)
    rows = np.tile(voigt(tensors), (1, copies, 1))
    trains = streamed(units, rows)
    assert sum(map(len, trains)) > 20 * copies
    for a, b in zip(trains, expected, strict=True):
        assert a == pytest.approx(b, abs=1e-9)
    units.reset()
    again = streamed(units, rows)
    # exact: one code on one state, reset
    assert all(np.array_equal(a, b) for a, b in zip(trains, again, strict=True))


def test_equal_principal_strains_are_no_trouble() -> None:
    units = Afferents(("SAI",), [[0.0, 0.0, 1.0]], {"SAI": 1.0})
    units.step(np.array([[-0.2, -0.2, -0.2, 0.0, 0.0, 0.0]]), 1e-3)
    assert units.state.x[0] == pytest.approx(0.2)
    units.step(np.zeros((1, 6)), 1e-3)
    assert units.state.x[0] == 0.0


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"drives": {"SAI": "energy"}}, "drives.SAI"),
        ({"types": ("SAX",)}, "types"),
        ({"normals": np.zeros((2, 3))}, "normals"),
        ({"membrane": ConnorStevens()}, "membrane"),
        ({"membrane": HodgkinHuxley(), "method": "adaptive"}, "method"),
        ({"membrane": HodgkinHuxley(), "dt": 1.0}, "dt"),
    ],
)
def test_what_cannot_be_streamed_gets_a_sentence(options: dict, field: str) -> None:
    given = {"types": ("SAI",), "normals": [[0.0, 0.0, 1.0]], "lengths": {"SAI": 1.0}} | options
    with refused(field):
        Afferents(**given)


@pytest.mark.parametrize("membrane", [IntegrateAndFire(), HodgkinHuxley(1.0)])
def test_a_long_step_loses_no_spikes(membrane: IntegrateAndFire | HodgkinHuxley) -> None:
    """Of a constant strain, a step of 2 s fires what a thousand short ones fire."""
    squeezed = np.array([[0.0, 0.0, -0.5, 0.0, 0.0, 0.0]])
    units = Afferents(("SAI",), [[0.0, 0.0, 1.0]], {"SAI": 5.0}, membrane=membrane)
    units.step(squeezed, 0.0)
    short = []
    for _ in range(1000):
        units.step(squeezed, 2e-3)
        short += units.fired()
    units.reset()
    assert units.fired() == []
    units.step(squeezed, 0.0)
    assert units.step(squeezed, 2.0) == len(units.fired()) == len(short) > ROOM
    long = [time for _, time in units.fired()]
    assert np.abs(np.array(long) - [time for _, time in short]).max() < 2e-3
    assert units.state.clock[0] == pytest.approx(2000.0)


@pytest.mark.parametrize(
    ("strain", "dt", "field"),
    [
        (np.zeros((1, 6)), 1e-3, "strain"),
        (np.zeros((2, 3, 3)), 1e-3, "strain"),
        ([[0.0] * 6] * 2, 1e-3, "strain"),
        (np.full((2, 6), np.nan), 1e-3, "strain"),
        (np.full((2, 6), -np.inf, np.float32), 1e-3, "strain"),
        (np.diag(np.full(6, 1e200))[:2], 1e-3, "strain"),
        (np.zeros((2, 6)), -1e-3, "dt"),
        (np.zeros((2, 6)), np.nan, "dt"),
    ],
)
@pytest.mark.parametrize("membrane", [IntegrateAndFire(), HodgkinHuxley()])
def test_a_step_that_cannot_be_taken_gets_a_sentence_and_is_not_taken(
    membrane: IntegrateAndFire | HodgkinHuxley, strain: np.ndarray, dt: float, field: str
) -> None:
    units = Afferents(("SAI", "FAI"), NORMALS[:2], {"SAI": 5.0, "FAI": 5.0}, membrane=membrane)
    units.step(np.full((2, 6), 0.05), 0.0)
    before = [np.copy(each) for each in (*units.state, units.membranes.units)]
    with refused(field):
        units.step(strain, dt)
    for then, now in zip(before, (*units.state, units.membranes.units), strict=True):
        assert np.array_equal(then, now)  # exact: left as it was


def test_a_step_without_end_is_refused() -> None:
    units = Afferents(("SAI",), [[0.0, 0.0, 1.0]], {"SAI": 5.0})
    squeezed = np.array([[0.0, 0.0, -0.5, 0.0, 0.0, 0.0]])
    units.step(squeezed, 0.0)
    with refused("dt"):
        units.step(squeezed, 1e300)


def test_a_type_without_a_reference_gets_the_sentence_that_there_is() -> None:
    three = Reference(0.5, TYPES[:3], REFERENCE.normals[:3], REFERENCE.strain[:3])
    with pytest.raises(InputError, match=f"expected every type in use, {TYPES[3]} is"):
        Afferents.of(TYPES, NORMALS, three)
    with refused("types"):
        Afferents.of(("SAX",), NORMALS[:1], REFERENCE)
    with refused("drives.SAI"):
        Afferents.of(TYPES, NORMALS, REFERENCE, drives={"SAI": "none"})


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"normals": 2 * NORMALS}, "normals"),
        ({"normals": 0 * NORMALS}, "normals"),
        (
            {"lengths": {"SAI": 1.0}},
            "lengths",
        ),
        ({"lengths": dict.fromkeys(TYPES, -1.0)}, "lengths.SAI"),
        ({"substeps": 0}, "substeps"),
        ({"types": (), "normals": np.empty((0, 3))}, "types"),
    ],
)
def test_units_that_cannot_be_stepped_are_refused_at_once(given: dict, field: str) -> None:
    expected = {"types": TYPES, "normals": NORMALS, "lengths": dict.fromkeys(TYPES, 1.0)}
    with refused(field):
        Afferents(**{**expected, **given})
