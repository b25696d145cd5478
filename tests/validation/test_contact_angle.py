"""The report on the contact angle is of this code, and its sentences are of its table."""

import html
import math
from pathlib import Path

import pandas as pd
import pytest
from fefinger.validation.contact_angle import page as contact_angle_page
from fefinger.validation.contact_angle import study

from fefinger.studies.tasks import StudyRequest, answer


REPORTS = Path(__file__).parents[2] / "reports"
CASE = "a.h. to 1 mm"


@pytest.fixture(scope="module")
def rows():
    """Return the rows of the table, None where it is empty."""
    table = pd.read_csv(REPORTS / "contact-angle.csv", keep_default_na=False, na_values=[""])
    plain = [dict(zip(table.columns, row, strict=True)) for row in table.itertuples(index=False)]
    return [
        {
            name: None if isinstance(value, float) and math.isnan(value) else value
            for name, value in row.items()
        }
        for row in plain
    ]


def test_the_table_is_of_this_code(rows):
    scene, changes, mechanics, _ = study.STUDIES[CASE]
    asked = StudyRequest(scene, {"indenter.angle": (30.0,)}, changes, mechanics, study.AT)
    ((_, task),) = asked.tasks()[0].items()
    again = {row["at"]: row for row in answer(task)["rows"]}
    kept = [row for row in rows if row["case"] == CASE and row["indenter.angle_deg"] == 30]
    assert len(kept) == 2 + len(study.AT)
    for row in kept:
        for name in ("force_N", "depth_mm", "contact_area_mm2", "asymmetry", "ellipticity"):
            assert again[row["at"]][name] == pytest.approx(row[name], rel=1e-4), name


def test_every_scene_is_there_or_says_why_not(rows):
    for case, (_, _, _, angles) in study.STUDIES.items():
        found = {row["indenter.angle_deg"] for row in rows if row["case"] == case}
        assert found == set(angles), case
    failed = [row for row in rows if row["status"].startswith("failed")]
    assert all("proximal cut" in row["status"] for row in failed)


def test_the_page_says_what_the_table_says(rows):
    page = html.unescape((REPORTS / "contact-angle.html").read_text(encoding="utf-8"))
    assert contact_angle_page.answer(rows) in page
    for sentence in contact_angle_page._predicted(rows):
        assert sentence in page
