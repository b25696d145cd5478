"""The page to turn and play holds everything, and needs no other file and no network."""

import base64
import dataclasses
import json
import re
import zlib

import numpy as np
import pytest

from fefinger.pages import viewer
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.textured import Grating
from fefinger.view import frames, quantities, surfaces


def page(results, folder, **options):
    """Return the page, its record and its unpacked arrays."""
    viewer.write(results, folder / "a.html", **options)
    html = (folder / "a.html").read_text(encoding="utf-8")
    (record,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', html)
    (blob,) = re.findall(r'<script type="text/plain" id="blob">(.*?)</script>', html)
    return html, json.loads(record), zlib.decompress(base64.b64decode(blob))


def read(blob, place):
    """Return an array of the page."""
    kind = {"f4": "<f4", "u4": "<u4", "u2": "<u2"}[place["kind"]]
    return np.frombuffer(blob, kind, place["count"], place["at"])


def test_the_page_stands_alone(synthetic, tmp_path):
    html, _, _ = page(synthetic, tmp_path)
    assert not re.findall(r'(?:src|href)="|url\(|@import|import\(|fetch\(|https?://', html)
    assert html.count("<script") == 3
    assert [path.name for path in tmp_path.iterdir()] == ["a.html"]
    for field in quantities.FIELDS:
        assert f'<option value="{field}"' in html


def test_the_page_holds_points_and_values_of_every_field_and_time(synthetic, tmp_path):
    _, record, blob = page(synthetic, tmp_path)
    (scene,) = record["scenes"]
    whole = frames.whole_result(synthetic)
    fields = whole.fields
    back = surfaces.cut_open(fields)
    count = sum(len(piece.edges) for piece in back)
    points = read(blob, scene["points"]).reshape(len(fields.times), -1, 3)
    assert points.shape[1] == scene["vertices"] > count
    for frame in range(len(fields.times)):
        moved = fields.points + fields.displacement[frame]
        expected = np.concatenate([piece.at(moved) for piece in back])
        np.testing.assert_allclose(points[frame, :count], expected, atol=1e-5)
        for field in quantities.FIELDS:
            place = scene["values"][field]
            levels = read(blob, place).reshape(len(fields.times), -1)[frame, :count]
            nodal = quantities.values(whole, field, frame)
            expected = np.concatenate([piece.at(nodal) for piece in back])
            assert np.abs(place["low"] + place["step"] * levels - expected).max() <= place["step"]
    triangles = read(blob, scene["triangles"])
    assert triangles.max() < scene["vertices"]
    assert 3 * scene["pieces"][-1]["to"] == len(triangles)
    # The other half is the mirror image, so together they look alike from both sides.
    assert points[..., 1].min() == pytest.approx(-points[..., 1].max(), rel=1e-5)
    assert {each["name"] for each in scene["pieces"]} == {
        "skin", "pad", "subcutaneous tissue", surfaces.FRONT
    }  # fmt: skip


def test_compared_results_have_one_scale_and_limits_are_kept(synthetic, tmp_path):
    fields = dataclasses.replace(synthetic.fields, strain=3 * synthetic.fields.strain)
    response = dataclasses.replace(synthetic.response, fields=fields)
    strong = dataclasses.replace(synthetic, response=response)
    _, alone, _ = page(synthetic, tmp_path)
    _, both, _ = page([synthetic, strong], tmp_path, field="strain zz", limits=(-4.0, 6.0),
                         folders=("one", "two"))  # fmt: skip
    assert len(both["scenes"]) == 2
    assert both["fields"]["tensile strain"]["high"] > 2 * alone["fields"]["tensile strain"]["high"]
    chosen = both["fields"]["strain zz"]
    assert (chosen["low"], chosen["high"], chosen["unit"]) == (-4.0, 6.0, "%")
    assert both["field"] == "strain zz"
    # Zero keeps the middle color: of the map, the page holds the part from -4 to 6 of -6 to 6.
    colors = np.array(both["maps"][chosen["colors"]]).reshape(-1, 3)
    symmetric = np.array(both["maps"]["coolwarm"]).reshape(-1, 3)
    assert np.abs(colors[round(0.4 * 255)] - symmetric[127]).max() <= 3
    assert np.abs(colors[-1] - symmetric[-1]).max() == 0
    assert [scene["title"].split(":")[0] for scene in both["scenes"]] == ["one", "two"]


def test_rates_end_organs_and_other_indenters_are_in_it(synthetic, tmp_path):
    grating = Grating(ridge=1.0, period=2.5, depth=0.8)
    scene = dataclasses.replace(synthetic.scene, indenter=grating)
    _, record, blob = page(dataclasses.replace(synthetic, scene=scene), tmp_path, time=2.5)
    (shown,) = record["scenes"]
    rates = read(blob, shown["organs"]["rates"]).reshape(len(shown["times"]), -1)
    expected = [synthetic.spikes.rate(unit, shown["times"]) for unit in range(4)]
    np.testing.assert_allclose(rates.T, expected, rtol=1e-6)
    assert record["rate"] >= rates.max()
    assert record["time"] == 2.5
    front = read(blob, shown["indenter"]["points"]).reshape(-1, 3)
    pose = frames.pose(dataclasses.replace(synthetic, scene=scene), 0.0)
    assert np.ptp(front @ pose.axis) == pytest.approx(0.8, rel=0.05)


def test_a_ball_is_drawn_round_and_a_plate_with_its_rim(synthetic, tmp_path, recwarn):
    for indenter, rim in ((Sphere(3.0), 8 * (viewer.GRID - 1)), (Flat(30.0), 8)):
        scene = dataclasses.replace(synthetic.scene, indenter=indenter)
        _, record, blob = page(dataclasses.replace(synthetic, scene=scene), tmp_path)
        shown = record["scenes"][0]["indenter"]
        assert shown["rim"]["count"] == rim
        if isinstance(indenter, Sphere):
            points = read(blob, shown["points"]).reshape(-1, 3)
            center = np.array([0.0, 0.0, 0.0]) - 3.0 * np.array(shown["axis"])
            away = np.linalg.norm(points - center, axis=1)
            np.testing.assert_allclose(away, 3.0, rtol=1e-5)
            assert shown["triangles"]["count"] == 3 * 2 * (viewer.GRID - 1) ** 2
    assert not recwarn.list
