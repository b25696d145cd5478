"""Build the mesh of a half finger: by a morph of a shipped one, else by the mesher.

The mesher: surfaces, tetrahedra, regions, smooth boundaries, quality.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.finger_mesh import BONE, FingerMesh, facet_sets
from fefinger.mesh import mesh_record, smooth, tetrahedralize
from fefinger.mesh.finger_shape import PATCH_CENTER, PATCH_RADIUS, Shape, touch_within
from fefinger.mesh.mesh_record import SCANNED, STRICT, gate, record
from fefinger.mesh.morph import Draft, draft, finished
from fefinger.mesh.parametric import parametric
from fefinger.mesh.recipe import Recipe, Touch, templates
from fefinger.mesh.scan import shape_of
from fefinger.mesh.tetrahedralize import MesherSettings, tetrahedra
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import ConvergenceError


Progress = Callable[[str], None]

SETTINGS = {
    "coarse": MesherSettings(pad=0.8, deep=0.7, far=0.9, largest=4.0, envelope=5e-3, facet=1.0),
    "standard": MesherSettings(pad=0.42, deep=0.5, far=0.6),
    "fine": MesherSettings(pad=0.3, deep=0.35, far=0.5, largest=2.5, envelope=2e-3, facet=0.6),
}


TEMPLATES = 3
"""Largest number of shipped meshes that are morphed before the mesher is called; of a scan all are,
as the mesher is random."""

HOPELESS, TRIED = 0.2, 0.5
"""Share of poor cells from which on a morph is not tried (0.1 came out good, of 0.3 some cells stay
inverted), and the sum of shares up to which morphs are: each poor cell takes some 8 ms, in vain."""

WANTED_SINE = np.sin(np.radians(14.0))
"""Sine of a dihedral angle below which the vertices of a cell are moved."""


def build(
    recipe: Recipe,
    *,
    settings: MesherSettings | None = None,
    name: str = "finger",
    progress: Progress | None = None,
) -> FingerMesh:
    """Build the mesh of half a finger (y >= 0); it passes the quality check.

    Raises ConvergenceError with the faults of the last attempt if none passes, or none in time.
    """
    shape = shape_of(recipe)
    say = progress or (lambda _: None)
    if settings is None:
        mesh = _morphed(shape, recipe, name=name, say=say)
        if mesh is not None:
            return mesh
        settings = SETTINGS[recipe.resolution]
    begun = monotonic()
    # Largest number of meshings; each has a smaller envelope, as the mesher is not deterministic.
    attempts, remedy = (4, "other dimensions") if recipe.surface is None else (2, "a blunter tip")
    for attempt in range(attempts):
        say(f"meshing, attempt {attempt + 1}")
        chosen = replace(settings, envelope=settings.envelope * 0.85**attempt)
        try:
            mesh = _attempt(shape, recipe, chosen, name=name, say=say)
            gate(mesh.quality, STRICT if recipe.surface is None else SCANNED)
        except ConvergenceError as error:
            problem = error
            say(str(problem))
            if monotonic() - begun > tetrahedralize.LIMIT:
                break
            continue
        return mesh if recipe.surface is None else _by_chance(mesh)
    count = "1 attempt" if attempt == 0 else f"{attempt + 1} attempts"
    message = f"{problem} in {count}; use another resolution or {remedy}"
    raise ConvergenceError(message)


def _morphed(shape: Shape, recipe: Recipe, *, name: str, say: Progress) -> FingerMesh | None:
    """Morph shipped meshes, those first that lose least; None if none passes the checks."""
    drafts = []
    for path in templates(recipe.resolution, recipe.touch):
        template = mesh_record.read(path)
        with suppress(ConvergenceError):
            source = parametric(Recipe(**template.recipe))
            drafts.append(draft(template, source, shape, recipe.touch))
    for made in promising(drafts, scanned=recipe.surface is not None):
        say(f"morphing {made.template.name}")
        try:
            return finished(made, shape, recipe, name=name)
        except ConvergenceError as error:
            say(str(error))
    return None


def promising(drafts: list[Draft], *, scanned: bool) -> list[Draft]:
    """Return the drafts that are worth improving, in the order in which they are tried.

    Those of a parametric finger that lose least; of a scan, the finest first, so that scans of one
    finger get one template.
    """
    drafts = sorted(drafts, key=lambda made: made.poor)[: None if scanned else TEMPLATES]
    if scanned:
        drafts.sort(key=lambda made: made.stretch)
    shares = np.array([made.poor / len(made.template.cells) for made in drafts])
    hopeful = shares < HOPELESS
    spent = np.cumsum(np.where(hopeful, shares, 0.0))
    return [made for made, good in zip(drafts, hopeful & (spent < TRIED), strict=True) if good]


def _by_chance(mesh: FingerMesh) -> FingerMesh:
    """Return the mesh of a scan that no shipped mesh could be morphed to, with a note on that."""
    note = (
        "No shipped mesh has good cells in the shape of this scan, as where it is pointed: the "
        "mesher made this one, and another where it is made anew, with forces some 1 to 2 % off. "
        "It is kept in the cache; blunt what is pointed for a mesh that is the same each time."
    )
    return replace(mesh, quality=mesh.quality | {"notes": [*mesh.quality.get("notes", ()), note]})


def sizes(shape: Shape, settings: MesherSettings, touch: Touch = None) -> Callable[[Array], Array]:
    """Sizing function: edge length (n,) mm at points (n, 3), fine at the pad, growing inward.

    `touch` as in `Recipe`.
    """
    balls = [(PATCH_CENTER, PATCH_RADIUS)]
    if touch is not None:
        # Fine to 2.5 mm from the origin too, for the reference press that scales strains.
        balls = [(np.zeros(3), 2.5), (touch_within(shape, touch, np.inf), PATCH_RADIUS)]

    def size(points: Array) -> Array:
        below = np.maximum(-shape.subcutaneous.level(points), 0.0)
        away = [np.linalg.norm(points - center, axis=1) - radius for center, radius in balls]
        aside = np.maximum(np.min(away, axis=0), 0.0)
        wanted = settings.pad + settings.deep * below + settings.far * aside
        return np.minimum(wanted, settings.largest)

    return size


def _attempt(
    shape: Shape, recipe: Recipe, settings: MesherSettings, *, name: str, say: Progress
) -> FingerMesh:
    """Make one half mesh with its measured quality, without checking it."""
    inputs = shape.triangles(settings.facet)
    points, cells = tetrahedra(inputs, sizes(shape, settings, recipe.touch), settings)
    tolerance = 1.6 * settings.envelope * float(np.linalg.norm(np.ptp(inputs[0][0], axis=0)))
    points, cells, region = _inside(shape, points, cells, tolerance)
    say(f"{len(cells)} cells; fitting the boundaries")
    facets = facet_sets(
        points, cells, region, cut=shape.cut, tolerance=tolerance, level=shape.skin.level
    )
    points, first = _snapped(shape, points, facets)
    constraints = smooth.supports(shape, len(points), facets)
    points = smooth.fit(points, cells, constraints, wanted=WANTED_SINE, pinned=np.array([first]))
    free = constraints.free.copy()
    free[np.setdiff1d(np.arange(len(points)), facets["bone"])] = False
    points = smooth.bone_of_volume(
        shape, points, cells[region == BONE], free, shape.volumes["bone"]
    )
    outer = facets["pad"]
    nail = shape.nail.covers(points[outer].mean(axis=1))
    sets = {**facets, "pad": outer[~nail], "nail": outer[nail]}
    return record(shape, recipe, points, cells, region, sets, name=name)


def _inside(
    shape: Shape, points: Array, cells: Integers, tolerance: float
) -> tuple[Array, Integers, NDArray[np.int8]]:
    """Select the cells of the meshed box that belong to the half finger, with their regions.

    Cells within `tolerance` mm of the medial plane, the cut or the skin's surface are dropped:
    they would be flat once their vertices are moved onto it.
    """
    centers = points[cells].mean(axis=1)
    region = shape.region(centers)
    keep = (region > 0) & (centers[:, 1] > 0.0) & (centers[:, 0] > shape.cut)
    for axis, at in ((0, shape.cut), (1, 0.0)):
        keep &= np.abs(points[cells][:, :, axis] - at).max(axis=1) > tolerance
    on_skin = np.abs(shape.skin.level(points)) < tolerance
    keep &= ~on_skin[cells].all(axis=1) | (shape.skin.level(centers) < -tolerance)
    used, cells = np.unique(cells[keep], return_inverse=True)
    return points[used], cells.reshape(-1, 4), region[keep]


def _snapped(shape: Shape, points: Array, facets: dict[str, Integers]) -> tuple[Array, int]:
    """Move the vertices of plane facets onto their planes, and one vertex to the origin P30."""
    points = points.copy()
    medial = np.unique(facets["medial"])
    points[medial, 1] = 0.0
    points[np.unique(np.concatenate([facets["cut"], facets["bone-cut"]])), 0] = shape.cut
    ridge = np.intersect1d(medial, facets["pad"])
    first = int(ridge[np.argmin(np.linalg.norm(points[ridge], axis=1))])
    points[first] = 0.0
    return points, first
