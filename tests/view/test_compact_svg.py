"""The compact SVG shows what matplotlib's shows: the same marks at the same places."""

import re
from collections import Counter
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest

from fefinger.view import figures
from fefinger.view.compact_svg import SVG, compact, path


def matplotlib_svg():
    """Return a figure with lines, many markers, clipped scatter, labels and a turned axis label."""
    import io

    with figures.style():
        drawn = figures.figure(5, 3)
        left, right = drawn.subplots(1, 2)
        time = np.linspace(0, 1, 400)
        left.plot(time, np.sin(40 * time), label="a & b < c")
        left.plot(time[::40], time[::40], "o", color="red", markerfacecolor="none")
        for value in time[::20]:
            right.plot(value, value, "s", color="#0072B2")
        right.scatter(time[::8], time[::8] ** 2, c=time[::8])
        left.fill_between(time, time, alpha=0.2)
        left.set(xlabel="time / s", ylabel="it's $10^{-4}$")
        left.legend()
        buffer = io.StringIO()
        drawn.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


@pytest.fixture(scope="module")
def pair():
    """Return the tree that matplotlib writes, and the compact one of it."""
    text = matplotlib_svg()
    return fromstring(text), fromstring(compact(text))


def points(data):
    """Return (command, x, y) of path data with M, L, Q, C, Z of either case, letters implied."""
    tokens = re.findall(r"[A-Za-z]|-?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?", data)
    found, here, start, command, i = [], np.zeros(2), np.zeros(2), "", 0
    while i < len(tokens):
        if tokens[i].isalpha():
            command, i = tokens[i], i + 1
        if command in "zZ":
            here = start
            found.append(("Z", *here))
            continue
        count = {"M": 1, "L": 1, "Q": 2, "C": 3}[command.upper()]
        numbers = np.array(tokens[i : i + 2 * count], float).reshape(-1, 2)
        i += 2 * count
        places = numbers + here if command.islower() else numbers
        found += [(command.upper(), *place) for place in places]
        here = places[-1]
        if command in "mM":
            start, command = here, {"m": "l", "M": "L"}[command]
    return found


def local(element):
    return element.tag.rpartition("}")[2]


def test_paths_keep_their_points_to_a_hundredth_without_drift():
    steps = np.random.default_rng(1).uniform(0.01, 0.4, (3000, 2)).cumsum(axis=0)
    data = "M 1e-05 0.126 \n" + "".join(f"L {x:.6f} {y:.6f} \n" for x, y in steps)
    data += "z\nM 3 4 \nQ 5.111 6 7 8 \nC 1 2 3 4 5 6.789 \nL 5.5 5.5 \n"
    before, after = points(data), points(path(data))
    assert [row[0] for row in after] == [row[0] for row in before]
    places = [np.array([row[1:] for row in rows]) for rows in (before, after)]
    assert np.abs(places[1] - places[0]).max() < 0.0051
    assert len(path(data)) < 0.6 * len(data)


def test_lines_that_round_to_no_length_are_left_out_but_for_a_dot():
    assert path("M 0 0 \nL 1 2 \nL 1.001 2 \nL 2 2 \n") == "m0 0 1 2 1 0"
    assert path("M 1 2 \nL 1 2 \n") == "m1 2 0 0"


def test_every_mark_and_every_word_stays(pair):
    counts = [
        Counter(local(e) for e in tree.iter() if local(e) in ("use", "path", "text", "tspan"))
        for tree in pair
    ]
    assert counts[0] == counts[1]
    assert counts[0]["use"] > 60
    words = [
        ["".join(part.strip(" \n") for part in e.itertext()) for e in tree.iter()
         if local(e) == "text"]
        for tree in pair
    ]  # fmt: skip
    assert words[0] == words[1]
    assert "a & b < c" in words[1]


def test_uses_keep_their_places_and_what_they_point_at(pair):
    def drawn(tree):
        marks = {e.get("id"): e for e in tree.iter() if e.get("id")}
        return [
            (
                float(e.get("x", 0)),
                float(e.get("y", 0)),
                points(marks[link.removeprefix("#")].get("d", "")),
            )
            for e in tree.iter()
            if local(e) == "use"
            for key, link in e.attrib.items()
            if key.endswith("href")
        ]

    before, after = map(drawn, pair)
    assert len(before) == len(after)
    for old, new in zip(before, after, strict=True):
        assert new[:2] == pytest.approx(old[:2], abs=0.0051)
        assert [row[0] for row in new[2]] == [row[0] for row in old[2]]
        assert np.allclose([r[1:] for r in new[2]], [r[1:] for r in old[2]], atol=0.0051)


def looks(tree):
    """Return the declarations of style of every element that is drawn, by class or its own."""
    sheet = next(e.text or "" for e in tree.iter() if local(e) == "style")
    classes = dict(re.findall(r"\.(\w+)\{([^}]*)\}", sheet))
    styles = [
        classes[e.attrib["class"]] if "class" in e.attrib else e.get("style", "")
        for e in tree.iter()
        if local(e) in ("use", "path", "text", "tspan")
    ]
    split = [[d.partition(":") for d in style.replace("'", "").split(";") if ":" in d]
             for style in styles]  # fmt: skip
    return [{k.strip(): re.sub(r"\s*,\s*", ",", v.strip()) for k, _, v in each} for each in split]


def test_styles_become_classes_of_the_same_look(pair):
    before, after = map(looks, pair)
    assert before == after
    clips = [
        Counter(e.get("clip-path") is not None for e in tree.iter() if local(e) == "path")
        for tree in pair
    ]
    assert clips[0] == clips[1]


def test_links_lead_somewhere_and_no_id_is_left_without_a_link(pair):
    elements = list(pair[1].iter())
    values = " ".join(" ".join(e.attrib.values()) for e in elements)
    ids = {e.attrib["id"] for e in elements if "id" in e.attrib}
    links = {e.attrib["href"].removeprefix("#") for e in elements if "href" in e.attrib}
    links |= set(re.findall(r"url\(#(\w+)\)", values))
    assert links == ids


def test_the_text_is_small_and_in_single_quotes():
    text = matplotlib_svg()
    assert len(compact(text)) < 0.5 * len(text)
    assert '"' not in compact(text)
    assert f"xmlns='{SVG}'" in compact(text)
    assert compact(text) == compact(text)
