"""The columns of a study say the unit of a field, as its table in the scene decides it."""

import re
from dataclasses import fields

import pytest

from fefinger.scene.ask import LAYOUTS, Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import INDENTERS
from fefinger.scene.schema import column, split
from fefinger.scene.tissue import Hard, Tissue
from fefinger.scene.toml import MOTIONS
from fefinger.studies.grid import words
from fefinger.theory.relaxation import Prony


@pytest.mark.parametrize(
    ("field", "ending", "unit"),
    [
        ("ask.population.densities.SAI", "_per_cm2", "1/cm²"),
        ("ask.depths.SAI", "_mm", "mm"),
        ("ask.drives.SAI", "", ""),
        ("ask.force", "", ""),
        ("ask.seconds", "_s", "s"),
        ("ask.population.distance", "_mm", "mm"),
        ("ask.population.noise", "_uA_per_cm2", "µA/cm²"),
        ("indenter.shift", "_mm", "mm"),
        ("motion.force", "_N", "N"),
        ("finger.prony.v", "_per_s", "1/s"),
        ("finger.nail.modulus", "_kPa", "kPa"),
    ],
)
def test_the_table_of_a_field_decides_its_unit(field, ending, unit):
    assert column(field) == field + ending
    assert split(column(field)) == (field, unit)
    assert words(column(field)) == (f"{field} / {unit}" if unit else field)


def test_every_number_of_a_scene_has_a_unit_or_is_known_to_have_none():
    pure = {
        "poisson",
        "exponent",
        "share",
        "cycles",
        "rel_error",
        "spread",
        "seed",
        "trial",
        "count",
        "c",
    }
    pure |= {"friction", "friction_kinetic", "passes"}
    tables = {"finger": [Finger], "finger.skin": [Tissue], "finger.nail": [Hard], "ask": [Ask]}
    tables |= {"finger.prony": [Prony], "indenter": INDENTERS.values()}
    tables |= {"motion": MOTIONS.values(), "ask.population": LAYOUTS.values()}
    for table, kinds in tables.items():
        for field in (field for kind in kinds for field in fields(kind)):
            name, kind = f"{table}.{field.name}", str(field.type)
            if re.search("float|int", kind) and "Mapping" not in kind:
                assert (column(name) == name) == (field.name in pure), name
