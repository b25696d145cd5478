"""The published parameters, against sums and means that the thesis prints beside them."""

import numpy as np
import pytest
from refusals import refused

from fefinger.scene import ask, library
from fefinger.scene.finger import Finger
from fefinger.support.vocabulary import TYPES


def columns(rows):
    """Return the rows of the subjects, and the row of means, as arrays."""
    subjects = np.array([row for name, row in rows.items() if name != "means"], float)
    return subjects, np.array(rows["means"], float)


def test_means_of_the_lumped_table_are_the_means_of_its_columns():
    rows = {
        name: (row.width, row.thickness, row.m, row.b, *row.prony.c, *row.prony.v)
        for name, row in library.lumped().items()
    }
    subjects, means = columns(rows)
    printed = [0.5, 0.5, 0.05, 0.005, *[0.0051] * 4, 0.5, 0.5, 0.0051]  # half of the last digit
    assert np.all(np.abs(subjects.mean(axis=0) - means) <= printed)


def test_means_of_the_relaxation_table_are_the_means_of_its_columns():
    rows = {name: (*prony.c, *prony.v) for name, prony in library.relaxation().items()}
    subjects, means = columns(rows)
    printed = [*[0.0051] * 4, 0.5, 0.05, 0.005]
    assert np.all(np.abs(subjects.mean(axis=0) - means) <= printed)


def test_means_of_the_quasistatic_table_are_the_means_of_its_columns():
    rows = {name: (row.radius, row.m, row.b) for name, row in library.quasistatic().items()}
    subjects, means = columns(rows)
    assert np.all(np.abs(subjects.mean(axis=0) - means) <= [1e-12, 0.05, 0.05])


def test_relaxation_of_both_chapters_belongs_to_the_same_subjects():
    sums = {name: sum(prony.c) for name, prony in library.relaxation().items()}
    assert sums["d.p."] == pytest.approx(1.0)
    assert [sums[name] for name in sums if name != "d.p."] == pytest.approx([0.99] * 5)
    assert sum(library.lumped()["d.s."].prony.c) == pytest.approx(1.01)


@pytest.mark.parametrize("name", [name for name in library.subjects() if name != "f.c."])
def test_a_subject_has_size_and_relaxation_and_radius_of_the_three_tables(name):
    finger = Finger.subject(name, tissue="maeno1998")
    row = library.lumped()[name]
    assert (finger.width, finger.thickness) == (row.width, row.thickness)
    assert finger.prony == library.relaxation()[name]
    assert finger.pad_radius == library.quasistatic()[name].radius


def test_the_subject_without_a_size_works_once_it_is_given():
    finger = Finger.subject("f.c.", width=15, thickness=11, tissue="maeno1998")
    assert (finger.width, finger.pad_radius) == (15, 15)
    with refused("finger.thickness"):
        Finger.subject("f.c.", width=15, tissue="maeno1998")


def test_a_finger_of_nobody_has_the_mean_relaxation_and_radius():
    finger = Finger(14, 11, tissue="maeno1998")
    assert finger.prony == library.relaxation()["means"]
    assert finger.pad_radius == 14.6
    assert finger.subject_name is None


def test_the_skin_of_maeno_is_as_stiff_against_stretching_as_its_two_layers():
    skin = library.maeno1998().skin
    assert skin.modulus * skin.thickness == pytest.approx(136 * 0.4 + 80 * 0.6)
    assert 80 < skin.modulus < 136
    assert skin.thickness == 1.0


@pytest.mark.parametrize("name", library.TISSUE_SETS)
def test_every_tissue_set_makes_a_finger_and_names_its_source_and_confidence(name):
    tissues = library.tissue_set(name)
    finger = Finger.subject("a.h.", tissue=name)
    # exact: handed on
    assert (finger.skin, finger.subcutaneous) == (tissues.skin, tissues.subcutaneous)
    assert tissues.confidence in ("high", "medium", "low")
    assert any(year in tissues.source for year in ("1997", "1998", "2003", "2017"))
    make = library.TISSUE_SETS[name]
    assert f"confidence {tissues.confidence}" in getattr(make, "func", make).__doc__


def test_end_organs_lie_inside_their_published_range_in_every_subject():
    rows = ask.innervation()
    assert tuple(rows) == TYPES
    for row, (low, high) in zip(
        rows.values(), ((0.7, 1), (1, 1.5), (0.5, 0.5), (2, 3)), strict=True
    ):
        assert low <= row.depth <= high
        assert row.depth < min(row.thickness for row in library.lumped().values()) / 2
