"""The table of the study of the contact angle is of this code and has every scene."""

from pathlib import Path

import pandas as pd
import pytest
from fefinger.validation import contact_angle

from fefinger.studies.tasks import StudyRequest, answer


CASE = "a.h. to 1 mm"


@pytest.fixture(scope="module")
def table():
    """Return the table of the report."""
    return pd.read_csv(Path(__file__).parents[2] / "reports" / "contact-angle.csv")


def test_the_table_is_of_this_code(table):
    scene, changes, mechanics, _ = contact_angle.STUDIES[CASE]
    over = {"indenter.angle": (30.0,)}
    asked = StudyRequest(scene, over, changes, mechanics, contact_angle.AT)
    ((_, task),) = asked.tasks()[0].items()
    again = {row["at"]: row for row in answer(task)["rows"]}
    kept = table[(table["case"] == CASE) & (table["indenter.angle_deg"] == 30)]
    assert len(kept) == 2 + len(contact_angle.AT)
    for row in kept.to_dict("records"):
        for name in ("force_N", "depth_mm", "contact_area_mm2", "asymmetry", "ellipticity"):
            assert again[row["at"]][name] == pytest.approx(row[name], rel=1e-4), name


def test_every_scene_is_there_or_says_why_not(table):
    for case, (_, _, _, angles) in contact_angle.STUDIES.items():
        assert set(table[table["case"] == case]["indenter.angle_deg"]) == set(angles), case
    failed = table[table["status"].str.startswith("failed")]["status"]
    assert failed.str.contains("proximal cut").all()
