"""The fingerprint of all answers: what its comparison sees, and what it lets pass."""

import numpy as np
import pytest
from fefinger.validation import fingerprint
from fefinger.validation.fingerprint import Fingerprint, differences


FORCE = "flat-press | linear | force"
SPIKES = "flat-press | linear | spikes of SAI-1"
ERROR = "flat-press | ladder | linear coarse error of force"
CASE = "suites | fem | a cube"
MESSAGE = "messages | command | rn"
SOLID = "sphere-press | solid | force"


def made(arrays=None, values=None, texts=None, quick=False, left_out=()):
    """Return a small fingerprint with changes."""
    parts = (
        {
            FORCE: np.array([0.0, np.nan, 1.5]),
            SPIKES: np.array([0.01, 0.02]),
            SOLID: np.array([2.0]),
        },
        {ERROR: np.nan, CASE: 3.0},
        {MESSAGE: "exit status 2\nNo such command 'rn'."},
    )
    changed = (
        part | (change or {}) for part, change in zip(parts, (arrays, values, texts), strict=True)
    )
    kept = ({k: v for k, v in part.items() if k not in left_out} for part in changed)
    return Fingerprint(quick, *kept)


def test_what_is_the_same_has_no_difference():
    assert list(differences(made(), made())) == []


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"arrays": {FORCE: np.array([0.0, np.nan, 1.5 + 3e-12])}},
            f"{FORCE}: 1.500000000003, was",
        ),
        ({"arrays": {FORCE: np.array([3e-12, np.nan, 1.5])}}, "at (0,), 2e-12 of the largest"),
        ({"arrays": {FORCE: np.array([0.0, 0.0, 1.5])}}, f"{FORCE}: 0.0, was nan at (1,)"),
        ({"arrays": {FORCE: np.array([0.0, np.nan])}}, f"{FORCE}: shape (2,), was (3,)"),
        ({"arrays": {SPIKES: np.array([0.01, 0.02 + 2e-9])}}, f"{SPIKES}: 0.020000002, was 0.02"),
        ({"arrays": {SPIKES: np.array([0.01])}}, f"{SPIKES}: shape (1,), was (2,)"),
        ({"values": {ERROR: 0.1}}, f"{ERROR}: 0.1, was nan"),
        ({"values": {CASE: 3.0 + 1e-11}}, f"{CASE}: 3.00000000001, was 3.0"),
        ({"texts": {MESSAGE: "exit status 1\nNo such command 'rn'."}}, "exit status 1"),
        ({"left_out": (FORCE,)}, f"{FORCE}: missing"),
        ({"left_out": (MESSAGE,)}, f"{MESSAGE}: missing"),
        ({"arrays": {"new | hertz | force": np.ones(1)}}, "new | hertz | force: not in the base"),
    ],
    ids=str,
)
def test_each_change_is_one_line(changes, line):
    (only,) = differences(made(), made(**changes))
    assert line in only
    assert "\n" not in only


@pytest.mark.parametrize(
    "arrays",
    [{FORCE: np.array([1e-12, np.nan, 1.5 - 1e-12])}, {SPIKES: np.array([0.01, 0.02 + 5e-10])}],
    ids=["rounding", "spikes"],
)
def test_rounding_is_no_difference(arrays):
    assert list(differences(made(), made(arrays))) == []


def test_a_file_gives_the_fingerprint_back(tmp_path):
    made().save(tmp_path / "base.npz")
    again = Fingerprint.load(tmp_path / "base.npz")
    assert again.labels == made().labels
    assert list(differences(made(), again)) == []


@pytest.mark.parametrize(
    ("changes", "status", "said"),
    [({}, 0, "no difference"), ({"left_out": (FORCE,)}, 1, f"{FORCE}: missing")],
)
@pytest.mark.parametrize("quick", [False, True])
def test_the_command_tells_the_present_code_from_the_base(
    monkeypatch, capsys, tmp_path, changes, status, said, quick
):
    made().save(tmp_path / "base.npz")
    slow = (SOLID, CASE) if quick else ()
    now = made(quick=quick, left_out=(*slow, *changes.get("left_out", ())))
    monkeypatch.setattr(fingerprint, "record", lambda *, quick: now)
    words = ["compare", str(tmp_path / "base.npz"), *(["--quick"] if quick else [])]
    assert fingerprint.main(words) == status
    assert capsys.readouterr().out == f"{said}\n"


def test_a_quick_base_is_no_whole_one(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(fingerprint, "record", lambda *, quick: pytest.fail("work began"))
    made(quick=True).save(tmp_path / "base.npz")
    with pytest.raises(SystemExit):
        fingerprint.main(["compare", str(tmp_path / "base.npz")])
    assert "compare with --quick" in capsys.readouterr().err
