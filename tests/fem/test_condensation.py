"""The reduction of a body to its pad, against solutions of the whole mesh."""

import numpy as np
import pytest
from fefinger.validation.problems.grids import box
from scipy import sparse

import fefinger as ff
from fefinger.fem import condensation
from fefinger.fem.body import Body, body, prescribed, reduce, solid
from fefinger.fem.contact.patch import patch
from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.elements.probe import strain_at
from fefinger.mechanics.press import placement, problem
from fefinger.mesh.store import load_or_build
from fefinger.support.checks import InputError


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
TISSUES = problem.tissues(FINGER)


@pytest.fixture(scope="module")
def parts() -> tuple[condensation.Compliance, condensation.Compliance]:
    """Return the even and the odd compliance of the half."""
    mesh = load_or_build(FINGER, half=True)
    own = solid(mesh, TISSUES)
    held = problem.fixed_facets(FINGER)
    even, odd = (
        condensation.condense(own, TISSUES, prescribed(own, mesh, held, odd=odd))
        for odd in (False, True)
    )
    return even, odd


@pytest.fixture(scope="module", params=["half", "whole"])
def both(request: pytest.FixtureRequest, parts: tuple) -> tuple[Body, condensation.Operator]:
    """Return a factored body and its operator."""
    half = request.param == "half"
    exact = body(load_or_build(FINGER, half=half), TISSUES, problem.fixed_facets(FINGER))
    own = solid(load_or_build(FINGER, half=True), TISSUES)
    if half:
        pieces = [condensation.Part(parts[0], sparse.eye(own.space.n_unknowns, format="csr"), 1.0)]
    else:
        pieces = [
            condensation.Part(part, condensation.mirrored(exact.space, own.space, odd=odd), 0.5)
            for part, odd in zip(parts, (False, True), strict=True)
        ]
    shape = (exact.space, exact.pad, exact.normals, exact.original, exact.half)
    return exact, condensation.Operator(*shape, tuple(pieces))


@pytest.mark.parametrize("points", [3, 40])
def test_flexibility_and_strains_are_those_of_the_whole_mesh(both: tuple, points: int) -> None:
    exact, operator = both
    place = None if exact.half else (1.0, 1.5)
    touch = placement.obstacle(ff.Sphere(6, at=place), exact)
    on_pad = patch(exact.space, exact.pad, exact.normals, touch, 0.8)
    inside = touch.origin + np.linspace(0.4, 3.0, points)[:, None] * touch.axis
    probe = strain_at(exact.space, inside, exact.planes)
    expected, found = reduce(exact, on_pad, probe), condensation.reduce(operator, on_pad, probe)
    for name in ("flexibility", "strain_operator"):
        scale = np.abs(getattr(expected, name)).max()
        assert np.abs(getattr(found, name) - getattr(expected, name)).max() < 1e-12 * scale


def test_gaps_beyond_the_palmar_part_are_those_of_the_whole_mesh(both: tuple) -> None:
    exact, operator = both
    touch = placement.obstacle(ff.Flat(45), exact)
    on_pad = patch(exact.space, exact.pad, exact.normals, touch, 1.25)
    assert not np.isin(on_pad.neighborhood.vertices, condensation.palmar(exact)).all()
    probe = strain_at(exact.space, touch.origin[None] + touch.axis, exact.planes)
    expected, found = reduce(exact, on_pad, probe), condensation.reduce(operator, on_pad, probe)
    for name in ("strain_operator", "normal_displacement"):
        scale = np.abs(getattr(expected, name)).max()
        assert np.abs(getattr(found, name) - getattr(expected, name)).max() < 1e-12 * scale


def test_displacements_everywhere_are_those_of_the_whole_mesh(both: tuple) -> None:
    exact, operator = both
    touch = placement.obstacle(ff.Flat(20), exact)
    on_pad = patch(exact.space, exact.pad, exact.normals, touch, 0.8)
    pressure = np.random.default_rng(0).uniform(size=(len(on_pad.vertices), 2))
    loads = np.asarray(on_pad.loads @ pressure)
    moving = slice(0, exact.space.n_displacements)
    expected = exact.system.solve(loads)[moving]
    found = condensation.displaced(operator, loads)[moving]
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


def test_a_load_beyond_the_palmar_part_is_refused(both: tuple) -> None:
    exact, operator = both
    outside = np.setdiff1d(exact.space.face_nodes(exact.pad), condensation.palmar(exact))
    loads = np.zeros((exact.space.n_unknowns, 1))
    loads[3 * outside[0]] = 1.0
    with pytest.raises(InputError, match="beyond the side of the finger"):
        condensation.displaced(operator, loads)


@pytest.mark.parametrize("poisson", [(0.5, 0.48), (0.499999, 0.5)])
def test_an_incompressible_body_is_reduced_as_well(poisson: tuple[float, float]) -> None:
    mesh, held = load_or_build(FINGER, half=True), problem.fixed_facets(FINGER)
    stiff = {1: Elastic(80.0, poisson[0]), 2: Elastic(34.0, poisson[1])}
    exact = body(mesh, stiff, held)
    even = condensation.condense(exact, stiff, prescribed(exact, mesh, held))
    pieces = (condensation.Part(even, sparse.eye(exact.space.n_unknowns, format="csr"), 1.0),)
    shape = (exact.space, exact.pad, exact.normals, exact.original, exact.half)
    touch = placement.obstacle(ff.Flat(30), exact)
    on_pad = patch(exact.space, exact.pad, exact.normals, touch, 0.8)
    inside = touch.origin + np.linspace(0.4, 3.0, 40)[:, None] * touch.axis
    probe = strain_at(exact.space, inside, exact.planes)
    expected = reduce(exact, on_pad, probe)
    found = condensation.reduce(condensation.Operator(*shape, pieces), on_pad, probe)
    for name in ("flexibility", "strain_operator", "normal_displacement"):
        scale = np.abs(getattr(expected, name)).max()
        assert np.abs(getattr(found, name) - getattr(expected, name)).max() < 2e-11 * scale


def test_only_twins_are_mirrored() -> None:
    grid = np.linspace(0.0, 1.0, 3)
    half, other = box(grid, grid, grid), box(grid, 1.1 * grid, grid)
    with pytest.raises(InputError, match="symmetric about y = 0"):
        condensation.mirrored(other, half, odd=False)
