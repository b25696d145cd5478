"""Bodies, material points and contacts at the edges, where meshes of fingers are not needed."""

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
from fefinger.validation.extremes.invariants import invariants, off
from fefinger.validation.extremes.scenes import SUBJECT, answered, pressed, ramp
from fefinger.validation.extremes.trial import ANSWERED, REFUSED, Findings, Row, Trial, grouped
from fefinger.validation.problems import cube
from fefinger.validation.problems.grids import box

from fefinger.contact import active_set
from fefinger.contact.complementarity import Complementarity
from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.continuum import HistoryStress, continuum
from fefinger.fem.hyperelastic.material import Material, material_of
from fefinger.fem.hyperelastic.state import State, Target
from fefinger.fem.linalg.system import factor
from fefinger.mesh.store import load_or_build
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Sphere
from fefinger.scene.motions import Ramp, RampHold
from fefinger.support.arrays import Array
from fefinger.support.tensors import logarithmic
from fefinger.theory.relaxation import Prony


GROUP = "elements"

RATIOS = (0.0, 0.3, 0.499999, 0.5)


@cache
def trials() -> tuple[Trial, ...]:
    """Return the problems of elements and contact."""
    return grouped(GROUP, _bars, _points, _cubes, _contacts, _places)


def _bars() -> Iterator[Row]:
    """Bars of any ratio, of slivers, and of two tissues."""
    for poisson in RATIOS:
        for longer in (1e-4, 1.0, 1e4):
            name = f"nu = {poisson:g}, cells {longer:g} times as long as wide"
            yield "slivers", name, partial(_bar, poisson, longer), None
    for contrast in (1e-9, 1e-3, 1e9):
        for poisson in (0.0, 0.4999):
            name = f"moduli 1 to {contrast:g}, nu = {poisson:g}"
            yield "contrast", name, partial(_stacked, contrast, poisson), ANSWERED


def _bar(poisson: float, longer: float) -> Findings:
    """Return force and width of a bar that slides on three planes and is squeezed by 1 %."""
    line = np.linspace(0, 1, 3)
    space = box(line, line, longer * line)
    force, answer = _squeezed(space, {1: Elastic(7.0, poisson)}, held_sides=False)
    at_nodes = answer[: space.n_displacements].reshape(-1, 3)
    side = space.node_points[:, 0] == 1
    return {
        "modulus": off(force, -7.0 * 0.01, 1e-6),
        "Poisson's ratio": (float(np.abs(at_nodes[side, 0] - 0.01 * poisson).max()) / 0.01, 1e-6),
    }


def _stacked(contrast: float, poisson: float) -> Findings:
    """Return the force of two layers that cannot give way to the side, one after the other."""
    line = np.linspace(0, 1, 3)
    space = box(line, line, line)
    upper = space.points[space.cells][:, :, 2].mean(axis=1) > 0.5
    space = Space(space.points, space.cells, (1 + upper).astype(np.int8))
    tissues = {1: Elastic(7.0, poisson), 2: Elastic(7.0 * contrast, poisson)}
    force, _ = _squeezed(space, tissues, held_sides=True)
    confined = 7.0 * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))
    # The residual of the solution is 1e-10 of its largest forces, which are 1e9 times the others.
    return {"in series": off(force, -0.01 * confined * 2 / (1 + 1 / contrast), 1e-5)}


def _squeezed(
    space: Space, tissues: dict[int, Elastic], *, held_sides: bool
) -> tuple[float, Array]:
    """Return the force in mN on the top, moved down by 1 % of the height, and the unknowns."""
    places = space.node_points
    height = places[:, 2].max()
    top = places[:, 2] == height
    held = places == 0
    held[top, 2] = True
    if held_sides:
        held[:, :2] = True
    fixed = np.flatnonzero(held.ravel())
    prescribed = np.zeros(places.shape)
    prescribed[top, 2] = -0.01 * height
    system = factor(space, stiffness(space, tissues), fixed)
    loads = np.zeros(space.n_unknowns)
    answer = system.solve(loads, prescribed.ravel()[fixed])
    reactions = np.zeros(space.n_unknowns)
    reactions[fixed] = system.reactions(answer, loads)
    at_nodes = reactions[: space.n_displacements].reshape(-1, 3)
    return float(at_nodes[top, 2].sum()), answer


def _laws(poisson: float) -> dict[str, Material]:
    soft = Elastic(30.0, poisson)
    return {
        "neo-hookean": material_of(soft),
        "mooney-rivlin": material_of(soft, "mooney-rivlin", share=0.3),
        "demiray": material_of(soft, "demiray", exponent=3.0),
        "veronda-westmann": material_of(soft, "veronda-westmann", exponent=2.0),
    }


def _points() -> Iterator[Row]:
    """Material points under gradients from 1e-15 to 0.5, and turned."""
    for poisson in (0.0, 0.5):
        for name, material in _laws(poisson).items():
            for size in (1e-15, 1e-8, 0.5):
                case = f"{name}, nu = {poisson:g}, gradient {size:g}"
                yield "material point", case, partial(_point, material, size), ANSWERED


def _point(law: Material, size: float) -> Findings:
    """Return the stress against Hooke's at small strain, that it turns along, and its symmetry."""
    body = continuum(box(*3 * (np.array([0.0, 1.0]),)), {1: law})
    shape = np.array([[0.3, 0.2, -0.1], [0.1, -0.5, 0.2], [0.05, -0.2, 0.2]])  # no trace
    turn = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))

    def stress(gradient: Array) -> Array:
        values = np.zeros(body.space.n_unknowns)
        values[: body.space.n_displacements] = (body.space.node_points @ gradient.T).ravel()
        return np.asarray(body.stress(values)[0][0, 0])

    gradient = size * shape
    computed = stress(gradient)
    turned = stress(turn @ (np.eye(3) + gradient) - np.eye(3))
    rows, columns = (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)
    hooke = (law.shear * (gradient + gradient.T))[rows, columns]
    strain = logarithmic(gradient[None])[0][rows, columns]
    findings = {
        # A turn by rounding strains by rounding.
        "turned": (float(np.abs(computed - turned).max()) / law.shear, 1e-14 + 1e-12 * size),
        "Hooke": off(computed, hooke, max(20 * size, 1e-13)) if size < 1e-3 else (0.0, 1.0),
        "finite": (float(np.sum(~np.isfinite([*computed, *strain]))), 0.0),
    }
    if size < 1e-3:
        small = ((gradient + gradient.T) / 2)[rows, columns]
        findings["logarithmic strain"] = off(strain, small, max(20 * size, 1e-6))
    return findings


def _cubes() -> Iterator[Row]:
    """Cubes at finite strain, squeezed by 1e-9 to 0.7."""
    for poisson in (0.0, 0.5):
        for name, material in _laws(poisson).items():
            for compression in (1e-9, 0.5) if name != "demiray" else (1e-9, 0.3, 0.7):
                case = f"{name}, nu = {poisson:g}, squeezed by {compression:g}"
                yield "finite strain", case, partial(_cube, material, compression), None


def _cube(law: Material, compression: float) -> Findings:
    """Return the pressure of a cube under a plate against its closed form."""
    made = cube.cube(law, cells=1)
    rest = made.body.at_rest
    memory = HistoryStress(rest.gains, rest.past)
    places = len(made.equilibrium.contact)
    state = State(np.zeros(made.body.space.n_unknowns), np.zeros(places), 0.0)
    for part in np.linspace(0, 1, 9)[1:] if compression > 0.1 else (1.0,):
        state = made.equilibrium.find(state, Target("depth", float(part * compression), memory))
    force = float(made.equilibrium.contact.projected @ state.pressure)
    small = 3 * law.shear if law.compressibility == 0 else 2 * law.shear  # nu 0.5 and 0
    exact = small * compression if compression < 1e-6 else cube.nominal(law, 1 - compression)
    return {
        "pressure": off(force, exact, 1e-5),
        "no pull": (max(0.0, -float(state.pressure.min())), 0.0),
    }


def _contacts() -> Iterator[Row]:
    """Complementarity with ties, stiff and soft places side by side, and nothing to touch."""
    for spread in (1.0, 1e9, 1e14):
        for tie in (False, True):
            name = f"flexibilities 1 to {spread:g}{', gaps of exactly nothing' if tie else ''}"
            yield "complementarity", name, partial(_complementarity, spread, tie), None
    for force in (2.0, 3.5):
        name = f"candidates that grow, {force:g} N"
        yield "rim of the candidates", name, partial(_grown, force), None


def _complementarity(spread: float, tie: bool) -> Findings:
    """Solve with both solvers: no pull, no penetration, and not both at once."""
    rng = np.random.default_rng(8)
    n = 40
    scale = np.logspace(0, -np.log10(spread) / 2, n)
    root = rng.normal(size=(n, n)) / np.sqrt(n) + np.eye(n)
    flexibility = scale[:, None] * (root @ root.T) * scale
    gap = rng.normal(size=n) * scale
    if tie:
        gap[::3] = 0.0
    one = Complementarity(flexibility).solve(gap)
    state = active_set.lcp_state(flexibility)
    outcome = active_set.solve(state, gap, 1e-10)
    if outcome != active_set.DONE:
        message = f"contact: no solution, outcome {outcome}"
        raise ArithmeticError(message)
    findings = {}
    for name, x in (("Cholesky", one), ("bordering", state.x)):
        w = (flexibility @ x + gap) / np.abs(gap).max()
        findings[f"no pull ({name})"] = (max(0.0, -float(x.min())), 0.0)
        findings[f"no penetration ({name})"] = (max(0.0, -float(w.min())), 1e-9)
        product = float(np.abs(x * w).max()) / max(float(x.max()), 1e-300)
        findings[f"either, or ({name})"] = (product, 1e-9)
    return findings


def _grown(force: float) -> Findings:
    """Press by a force until the contact meets the rim of its first candidates, then by depth."""
    elastic = Prony((1.0,), ())
    pushed = answered(
        "linear",
        {
            "prony": elastic,
            "motion": RampHold(loading_rate=10 * force, force=force, hold=0.1, corner=0.0),
        },
    )
    depth = float(pushed[1].depth[-1])
    moved = answered("linear", {"prony": elastic, "motion": ramp(60, depth)})
    same = off(moved[1].force[-1], force, 1e-6)
    return invariants(*pushed) | invariants(*moved) | {"the same by depth": same}


def _places() -> Iterator[Row]:
    """First touch exactly at a vertex, in the middle of an edge, and grazing ones."""
    for name, weights in {
        "at a vertex": (1.0, 0.0, 0.0),
        "on an edge": (0.5, 0.5, 0.0),
        "inside a facet": (0.4, 0.3, 0.3),
    }.items():
        for radius in (4.0, 50.0):
            case = f"{name}, ball of {radius:g} mm"
            yield "first touch", case, partial(_touching, weights, radius), ANSWERED
    border = {"indenter": Sphere(3, (-19.0, 0.0))}
    yield "first touch", "on the border of the pad", partial(pressed, "condensed", border), REFUSED
    grazing = {"indenter": Sphere(50.0), "motion": ramp(60, 1e-3 * 50)}
    yield "first touch", "grazing, a depth of 1e-3 R", partial(pressed, "condensed", grazing), None


def _touching(weights: tuple[float, ...], radius: float) -> Findings:
    """Return the invariants of a ball at a place of a facet, and that a nudge changes little."""
    mesh = load_or_build(
        Finger.subject(SUBJECT, resolution="coarse", tissue="maeno1998"), half=True
    )
    corners = mesh.points[mesh.facets["pad"]]
    middle = corners.mean(axis=1)
    chosen = corners[int(np.argmin(np.linalg.norm(middle - [1.5, 1.5, 0.0], axis=1)))]
    x, y, _ = (np.array(weights) @ chosen).tolist()
    forces = []
    findings: dict[str, tuple[float, float]] = {}
    for aside in (0.0, 1e-9):
        settings = {"indenter": Sphere(radius, (x + aside, y)), "motion": Ramp(60, 0.4)}
        scene, response = answered("condensed", settings)
        findings |= invariants(scene, response)
        forces.append(response.force)
    return findings | {"a nudge of 1e-9 mm": off(forces[1], forces[0], 1e-5)}
