"""FEBio's deck of the hemisphere and what is read of its output; FEBio itself is not needed."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from fefinger.validation.fem.solid import TIMES
from fefinger.validation.problems import febio
from fefinger.validation.problems.febio_deck import deck
from fefinger.validation.problems.hemisphere import DEPTH, RADIUS


EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))  # of FEBio's nodes 5 to 10

DATA = """*Step  = 0
*Time  = 0
*Data  = Fz
2 0
*Step  = 1
*Time  = 0.00125
*Data  = Fz
2 3.20942890273
"""

LOG = """
	Number of time steps completed .................... : 61

	Total number of equilibrium iterations ............ : 285

	Average number of equilibrium iterations .......... : 4.67213

	Total number of right hand evaluations ............ : 393

	Total number of stiffness reformations ............ : 67

Retrying time step. Retry attempt 1 of max 10
"""


@pytest.fixture(scope="module")
def ball():
    return febio.quarter(5.0)


@pytest.fixture(scope="module")
def root(ball):
    return ET.fromstring(ET.tostring(deck(ball)))


def rows(root, path):
    return np.array([[float(word) for word in row.text.split(",")] for row in root.findall(path)])


def members(root, path):
    return rows(root, path).astype(int) - 1


def test_the_mesh_of_the_deck_is_that_of_the_space(ball, root):
    points, cells = (
        rows(root, "Mesh/Nodes/node"),
        members(root, "Mesh/Elements[@type='tet10']/elem"),
    )
    assert len(points) == ball.n_nodes + 8
    # exact: the text has every digit
    np.testing.assert_array_equal(points[:-8], ball.space.node_points)
    np.testing.assert_array_equal(np.sort(cells), np.sort(ball.space.nodes))
    corners = points[cells[:, :4]]
    assert (np.linalg.det(corners[:, 1:] - corners[:, :1]) > 0).all()
    for middle, (first, last) in enumerate(EDGES, 4):
        halfway = (points[cells[:, first]] + points[cells[:, last]]) / 2
        np.testing.assert_allclose(points[cells[:, middle]], halfway, atol=1e-12)


def test_the_facets_of_the_deck_point_out_and_its_plate_up(root):
    points, skin = rows(root, "Mesh/Nodes/node"), members(root, "Mesh/Surface[@name='skin']/tri6")
    corners = points[skin[:, :3]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("fc,fc->f", normals, corners[:, 0] - [0, 0, RADIUS]) > 0).all()
    for middle, (first, last) in enumerate(EDGES[:3], 3):
        halfway = (points[skin[:, first]] + points[skin[:, last]]) / 2
        np.testing.assert_allclose(points[skin[:, middle]], halfway, atol=1e-12)
    a, b, c, d = points[members(root, "Mesh/Surface[@name='face']/quad4")[0]]
    assert np.cross(c - a, d - b)[2] > 0
    brick = points[members(root, "Mesh/Elements[@type='hex8']/elem")[0]]
    assert np.linalg.det(brick[[1, 3, 4]] - brick[0]) > 0


def test_the_deck_holds_the_nodes_and_reaches_the_times(ball, root):
    for axis, held in zip("xyz", ball.held.T, strict=True):
        numbers = root.find(f"Mesh/NodeSet[@name='{axis}']").text.split(",")
        np.testing.assert_array_equal(np.array(numbers, int) - 1, np.flatnonzero(held))
    # exact: the text has every digit
    np.testing.assert_array_equal(rows(root, "LoadData/*[@id='2']/points/pt")[:, 0], TIMES)
    control = root.find("Control")
    end = int(control.find("time_steps").text) * float(control.find("step_size").text)
    assert end == pytest.approx(TIMES[-1], rel=1e-12)
    assert float(root.find("Rigid/rigid_bc[@name='moved']/value").text) == DEPTH


def test_the_moduli_of_the_deck_relax_to_those_of_the_law(ball, root):
    tissue = root.find("Material/material[@name='tissue']")
    ratios = [float(tissue.find(f"g{number}").text) for number in (1, 2, 3)]
    shear = 2 * float(tissue.find("elastic/c1").text)
    assert shear == pytest.approx(ball.law.shear)
    assert shear * (1 + sum(ratios)) == pytest.approx(100 / (2 * 1.49))  # 100 kPa at once
    assert float(tissue.find("elastic/k").text) == pytest.approx(26 / (3 * 0.02))


def test_forces_and_counts_are_read_of_the_output():
    times, force = febio.read_force(DATA)
    np.testing.assert_array_equal(times, [0, 0.00125])
    np.testing.assert_allclose(force, [0, 4e-3 * 3.20942890273])  # N, of four quarters in mN
    assert febio.read_counts(LOG) == {
        "steps": 61,
        "iterations": 285,
        "residuals": 393,
        "factors": 67,
        "retries": 1,
    }
