"""Elements at finite strain: derivatives, closed forms, objectivity, order of convergence."""

import numpy as np
import pytest
from fefinger.validation.problems.grids import box, quarter
from oracles.potential import energy
from scipy.sparse.linalg import spsolve
from skfem import Basis, ElementTetP2

from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.continuum import Continuum, HistoryStress, continuum
from fefinger.fem.hyperelastic.material import Material, material_of
from fefinger.support.checks import InputError


SOFT = Elastic(30.0, 0.49)
LAWS = {
    "neo-hookean": material_of(SOFT),
    "mooney-rivlin": material_of(SOFT, "mooney-rivlin", share=0.3),
    "demiray": material_of(SOFT, "demiray", exponent=3.0),
    "veronda-westmann": material_of(SOFT, "veronda-westmann", exponent=2.0),
}
STIFFER = {
    "neo-hookean": lambda i: 1.0,
    "mooney-rivlin": lambda i: 1.0,
    "demiray": lambda i: np.exp(3 * i),
    "veronda-westmann": lambda i: 2 * np.exp(2 * i) - 1,
}
"""Secant shear modulus over that at rest in simple shear, of I1 - 3 = I2 - 3."""

EACH_LAW = pytest.mark.parametrize("material", LAWS.values(), ids=LAWS.keys())


def small() -> Space:
    return box(*3 * (np.linspace(0.0, 1.0, 3),))


def strained(body: Continuum, seed: int) -> tuple[np.ndarray, np.ndarray, HistoryStress]:
    """Return random values, a random direction and a random past."""
    random = np.random.default_rng(seed)
    values, along = 0.02 * random.normal(size=(2, body.space.n_unknowns))
    past = 3.0 * random.normal(size=(*body.weights.shape, 6))
    return values, along, HistoryStress(np.full((len(body.weights), 2), [1.7, 1.3]), past)


def homogeneous(body: Continuum, gradient: np.ndarray, pressure: float = 0.0) -> np.ndarray:
    """Return the values of a constant displacement gradient and pressure in kPa."""
    values = np.zeros(body.space.n_unknowns)
    n = body.space.n_displacements
    values[:n] = (body.space.node_points @ gradient.T).ravel()
    values[n:] = pressure / body.scale
    return values


@EACH_LAW
def test_at_rest_the_tangent_is_the_small_strain_matrix(material: Material):
    space = small()
    body = continuum(space, {1: material})
    exact = stiffness(space, {1: SOFT})
    found = body.tangent(np.zeros(space.n_unknowns), body.at_rest)
    assert abs(found - exact).max() < 1e-14 * abs(exact).max()


def test_the_tangent_is_whole_where_256_cells_meet():
    """As many as a byte counts to 0: their places in the matrix must not be lost."""
    line = np.linspace(0.0, 1.0, 3)
    space = quarter(line, line, lambda r, z: np.full_like(r, 2.0), 64)
    assert np.bincount(space.cells.ravel()).max() == 256
    exact = stiffness(space, {1: SOFT})
    body = continuum(space, {1: LAWS["neo-hookean"]})
    found = body.tangent(np.zeros(space.n_unknowns), body.at_rest)
    assert abs(found - exact).max() < 1e-13 * abs(exact).max()


def test_hard_parts_do_not_set_the_scale_that_soft_tissue_is_solved_to():
    """The residual of the volume is judged against it: bone would let soft tissue be 1e5 off."""
    space = box(*3 * (np.linspace(0.0, 1.0, 3),))
    labels = np.where(np.arange(len(space.cells)) % 2, 1, 3).astype(np.int8)
    space = Space(space.points, space.cells, labels)
    tissues = {1: material_of(SOFT), 3: material_of(Elastic(17e6, 0.3))}
    assert continuum(space, tissues, soft=(1,)).scale == tissues[1].shear
    assert continuum(space, tissues).scale == tissues[3].shear


@EACH_LAW
def test_residual_and_tangent_are_the_derivatives_of_the_energy(material: Material):
    body = continuum(small(), {1: material})
    values, along, history = strained(body, 1)
    slope = body.residual(values, history)[0] @ along
    bend = body.tangent(values, history) @ along
    errors = []
    for h in (1e-3, 1e-4):
        ahead, behind = values + h * along, values - h * along
        rise = (energy(body, ahead, history) - energy(body, behind, history)) / (2 * h)
        turn = (body.residual(ahead, history)[0] - body.residual(behind, history)[0]) / (2 * h)
        errors.append((abs(rise / slope - 1), np.linalg.norm(turn - bend) / np.linalg.norm(bend)))
    for coarse, fine in zip(*errors, strict=True):
        assert fine < 1e-4
        assert coarse / fine == pytest.approx(100, rel=0.1)  # central differences: second order


def test_the_work_of_the_stress_on_a_change_of_the_strain_is_that_of_the_residual():
    """By two ways of the elements: the strain by its definition, the residual by the kernels."""
    body = continuum(small(), {1: LAWS["demiray"]})
    values, along, _ = strained(body, 3)
    along[body.space.n_displacements :] = 0.0
    h = 1e-4
    stress = np.add(*body.stress(values))
    # The strain is quadratic in the displacement, so that the central difference is exact.
    ends = [body.weighted_strain(values + side * h * along) for side in (1, -1)]
    work = (stress * (ends[0] - ends[1])).sum() / (2 * h)
    assert work == pytest.approx(body.residual(values, body.at_rest)[0] @ along, rel=1e-8)


@EACH_LAW
def test_the_tangent_is_symmetric(material: Material):
    body = continuum(small(), {1: material})
    values, _, history = strained(body, 2)
    matrix = body.tangent(values, history)
    assert abs(matrix - matrix.T).max() == 0


@EACH_LAW
def test_a_rotated_body_has_the_stress_and_the_turned_forces_of_the_unrotated_one(
    material: Material,
):
    body = continuum(small(), {1: material})
    values, _, history = strained(body, 3)
    n, places = body.space.n_displacements, body.space.node_points
    turn = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    turned = values.copy()
    turned[:n] = ((places + values[:n].reshape(-1, 3)) @ turn.T - places).ravel()
    for before, after in zip(body.stress(values), body.stress(turned), strict=True):
        assert np.abs(after - before).max() < 1e-11 * np.abs(before).max()
    force, _ = body.residual(values, history)
    follows, _ = body.residual(turned, history)
    expected = force[:n].reshape(-1, 3) @ turn.T
    assert np.abs(follows[:n].reshape(-1, 3) - expected).max() < 1e-11 * np.abs(force).max()


@EACH_LAW
def test_the_undeformed_body_has_no_stress_and_tiny_strains_keep_their_digits(material: Material):
    body = continuum(small(), {1: material})
    isochoric, volumetric = body.stress(np.zeros(body.space.n_unknowns))
    assert not isochoric.any()
    assert not volumetric.any()
    gradient = 1e-13 * np.random.default_rng(5).normal(size=(3, 3))
    strain = (gradient + gradient.T) / 2
    isochoric, _ = body.stress(homogeneous(body, gradient))
    exact = 2 * SOFT.shear * (strain - np.trace(strain) / 3 * np.eye(3))
    assert isochoric[0, 0] == pytest.approx(exact[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]], rel=1e-9)


@EACH_LAW
def test_simple_shear_has_its_closed_form(material: Material):
    body = continuum(small(), {1: material})
    shear = 0.7
    gradient = np.zeros((3, 3))
    gradient[0, 1] = shear
    isochoric, _ = body.stress(homogeneous(body, gradient))
    full = np.zeros((3, 3))
    full[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]] = isochoric[0, 0]
    full = full + full.T - np.diag(np.diag(full))
    deformation = np.eye(3) + gradient
    cauchy = deformation @ full @ deformation.T
    rise = STIFFER[material.law.name](shear**2)  # I1 - 3 = I2 - 3 = shear²
    expected = material.shear * rise * shear
    assert cauchy[0, 1] == pytest.approx(expected, rel=1e-12)
    assert cauchy[0, 0] - cauchy[1, 1] == pytest.approx(shear * cauchy[0, 1], rel=1e-12)


def test_growth_in_all_directions_meets_the_bulk_modulus_alone():
    body = continuum(small(), {1: material_of(SOFT)})
    stretch = 1.1
    isochoric, volumetric = body.stress(homogeneous(body, (stretch - 1) * np.eye(3), 5.0))
    assert np.abs(isochoric).max() < 1e-12
    assert volumetric[0, 0, :3] == pytest.approx(5.0 * stretch**3 / stretch**2)
    bulk = 1 / SOFT.compressibility
    balanced = homogeneous(body, (stretch - 1) * np.eye(3), bulk * (stretch**3 - 1))
    residual, _ = body.residual(balanced, body.at_rest)
    assert np.abs(residual[body.space.n_displacements :]).max() < 1e-14


def test_an_inverted_cell_is_reported_and_not_summed():
    body = continuum(small(), {1: material_of(SOFT)})
    _, least = body.residual(homogeneous(body, np.diag([-1.5, 0.0, 0.0])), body.at_rest)
    assert least <= 0


def test_a_flat_cell_is_refused():
    space = small()
    flat = space.points * [1.0, 1.0, 0.0]
    with pytest.raises(InputError, match="positive volume"):
        continuum(Space(flat, space.cells, space.tissue), {1: material_of(SOFT)})


@pytest.mark.parametrize(
    ("numbers", "what"),
    [
        ({"shear": 0.0}, "material.shear"),
        ({"shear": 1.0, "compressibility": -1.0}, "material.compressibility"),
    ],
)
def test_laws_refuse_numbers_that_no_tissue_has(numbers: dict[str, float], what: str):
    with pytest.raises(InputError, match=what):
        Material(**({"compressibility": 0.1} | numbers))


# A manufactured solution: two shears in turn, which keep every volume


def moved(points: np.ndarray) -> np.ndarray:
    """Return the displacements of points (n, 3)."""
    u = np.zeros_like(points)
    u[:, 0] = 0.15 * np.sin(2 * points[:, 2])
    u[:, 2] = 0.15 * np.sin(2 * (points[:, 0] + u[:, 0])) * np.cos(points[:, 1])
    return u


def squeezed(points: np.ndarray) -> np.ndarray:
    """Return the pressure in kPa at points (n, 3)."""
    return 10 * np.cos(points[:, 0]) * np.sin(points[:, 1] + points[:, 2])


def nominal_stress(points: np.ndarray, material: Material) -> np.ndarray:
    """Return the first Piola-Kirchhoff stress (n, 3, 3), by differences of the energy by F."""
    h = 1e-5
    gradient = np.stack(
        [(moved(points + h * e) - moved(points - h * e)) / (2 * h) for e in np.eye(3)]
    )
    deformation = np.eye(3) + gradient.transpose(1, 2, 0)

    def density(f: np.ndarray) -> np.ndarray:
        c, volume = f.transpose(0, 2, 1) @ f, np.linalg.det(f)
        trace = np.trace(c, axis1=1, axis2=2)
        minors = (trace**2 - np.trace(c @ c, axis1=1, axis2=2)) / 2
        one, two = trace * volume ** (-2 / 3) - 3, minors * volume ** (-4 / 3) - 3
        return material.energy(one, two) + squeezed(points) * (volume - 1)

    stress = np.empty_like(deformation)
    for i in range(3):
        for j in range(3):
            step = np.zeros((3, 3))
            step[i, j] = 1e-4
            stress[:, i, j] = (density(deformation + step) - density(deformation - step)) / 2e-4
    return stress


def manufactured_error(material: Material, cells: int) -> float:
    """Return the L2 error of the displacement over its L2 norm on a cube of `cells`³ boxes.

    The face z = 0 is held as the solution says; the load is the work of the exact stress, which
    holds its body force and its tractions.
    """
    space = box(*3 * (np.linspace(0.0, 1.0, cells + 1),))
    body = continuum(space, {1: material})
    places = space.node_points
    exact = np.zeros(space.n_unknowns)
    exact[: space.n_displacements] = moved(places).ravel()
    fixed = np.flatnonzero(np.repeat(places[:, 2] == 0, 3))
    free = np.setdiff1d(np.arange(space.n_unknowns), fixed)
    quadrature = np.asarray(space.scalar.global_coordinates()).transpose(1, 2, 0)
    stress = nominal_stress(quadrature.reshape(-1, 3), material).reshape(*quadrature.shape, 3)
    gradients = np.einsum("qki,eij->eqkj", body.reference, body.jacobians)
    load = np.zeros(space.n_unknowns)
    work = np.einsum("eq,eqij,eqkj->eki", body.weights, stress, gradients)
    np.add.at(load, space.unknowns[:, :30], work.reshape(len(work), 30))
    values = exact.copy()
    for _ in range(12):
        residual = body.residual(values, body.at_rest)[0] - load
        if np.abs(residual[free]).max() < 1e-11 * np.abs(load).max():
            break
        matrix = body.tangent(values, body.at_rest)[free][:, free].tocsc()
        values[free] -= spsolve(matrix, residual[free])
    else:
        pytest.fail("Newton's method did not converge")
    basis = Basis(space.scalar.mesh, ElementTetP2(), intorder=6)
    points = np.asarray(basis.global_coordinates())
    true = moved(points.reshape(3, -1).T).T.reshape(points.shape)
    nodal = values[: space.n_displacements].reshape(-1, 3)
    found = np.array([np.asarray(basis.interpolate(nodal[:, c].copy())) for c in range(3)])
    norms = [float(np.sum(field**2 * basis.dx)) for field in (found - true, true)]
    return float(np.sqrt(norms[0] / norms[1]))


@pytest.mark.parametrize(
    "material",
    [
        material_of(Elastic(30.0, 0.5)),
        material_of(Elastic(30.0, 0.5), "mooney-rivlin", share=0.4),
        material_of(Elastic(30.0, 0.5), "demiray", exponent=2.0),
    ],
    ids=["neo-hookean", "mooney-rivlin", "demiray"],
)
def test_a_manufactured_incompressible_solution_is_approached_to_third_order(material: Material):
    coarse, fine = manufactured_error(material, 2), manufactured_error(material, 4)
    assert fine < 1e-3
    assert np.log2(coarse / fine) > 2.9
