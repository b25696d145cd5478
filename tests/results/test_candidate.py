"""Candidates: a mechanics on a mesh, as reports label them."""

import pytest

from fefinger import mechanics
from fefinger.results.candidate import MECHANICS, Candidate, meshed
from fefinger.results.records import Rung


@pytest.mark.parametrize("label", ["hertz", "lumped", "linear coarse", "solid fine"])
def test_a_label_of_a_report_is_read_and_written(label: str) -> None:
    candidate = Candidate.of(label)
    assert candidate.label == label
    rung = Rung(candidate.mechanics, 1.0, 0.1, "a report", resolution=candidate.resolution)
    assert rung.candidate == candidate


def test_the_fine_mesh_has_the_scatter_and_spikes_of_the_standard_one() -> None:
    assert Candidate("solid", "fine").measured == Candidate("solid", "standard")
    assert Candidate("solid", "coarse").measured == Candidate("solid", "coarse")
    assert Candidate("hertz").measured == Candidate("hertz")


def test_every_mechanics_has_its_traits() -> None:
    assert mechanics.names() == tuple(MECHANICS)
    assert [mechanics.get(name).name for name in MECHANICS] == list(MECHANICS)
    assert meshed() == ("condensed", "pressed", "modal", "linear", "solid")
    assert [name for name, traits in MECHANICS.items() if traits.finite] == ["pressed", "solid"]
