"""Elastic solutions of a relaxed finger at finite strain over depth, solved once for `pressed`.

`load_or_solve` reads the table or solves and stores it; `solve` goes through depths with equal
steps in their root. The work of the stress of one press on the deformation of a deeper one, in
theory in `theory/contact/ting.py`, is a sum over the integration points of the stress at the depth
a and the derivative of the strain at the depth d, which a spline through all strains gives.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from fefinger.fem.hyperelastic.continuum import Continuum, continuum
from fefinger.fem.hyperelastic.load_path import LoadPath, StressHistory
from fefinger.mechanics.press import depth_table, mesh_limits
from fefinger.mechanics.press.depth_table import DepthTable, DisplacementBasis
from fefinger.mechanics.press.finite_strain import BUDGET, FINITE_STRAIN, Course, follow_course
from fefinger.mechanics.press.load_steps import LoadSteps
from fefinger.mechanics.press.placement import whole_pad
from fefinger.mechanics.press.problem import Press, materials
from fefinger.mechanics.press.reference import reference_unknowns
from fefinger.mechanics.press.response import areas_of_steps, stiffening
from fefinger.mechanics.press.sites import REFERENCE_DEPTH
from fefinger.scene.motions import Ramp
from fefinger.support import cache
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.progress import Stages
from fefinger.support.units import NEWTON_PER_MILLINEWTON


PART, STEPS, FIRST, FEWEST = 0.16, 20, 2, 8
"""Depth over the thickness of the finger that STEPS steps reach; the first that is solved, below
which no mesh resolves the contact; and the last one at least, also of a lighter press."""

RESOLVED = 2
"""Least number of depths with a force: between fewer, none can be interpolated."""

FARTHEST = 0.32
"""Depth over the thickness to which a force is sought; tissue is 0.5 of it thick under the pad."""


def depths(thickness: float, least: float, steps: int = STEPS) -> Array:
    """Return depths (n,) mm from 0 to at least `least`, in `steps` steps or more.

    The same for all tables of a finger but those of `depths_to`: a deeper one changes no answer.
    """
    deep = PART * thickness
    last = max(steps, int(np.ceil(STEPS * np.sqrt(least / deep) * (1 - 1e-9))))
    return np.concatenate([[0.0], deep * (np.arange(FIRST, last + 1) / STEPS) ** 2])


def depths_to(depth: float) -> Array:
    """Return depths (n,) mm of a table that goes to a depth in mm and has no other ones.

    For a contact that reaches the rim beyond, or does not converge at one of the others.
    """
    own = 16  # number of depths of a table that cannot have the same as others
    return np.asarray(depth * (np.concatenate([[0.0], np.arange(1.0, own + 1)]) / own) ** 2)


def solve(
    press: Press, least: float, stages: Stages, *, force: float = 0.0, further: bool = True
) -> DepthTable:
    """Solve the table of a contact problem: its relaxed finger under its obstacle.

    It goes to `least` mm or more, or on until it bears `force` N, or to FARTHEST. If `further`, it
    goes to PART of the thickness where it can, so that other motions find it.

    Errors as `load_or_solve`.
    """
    thickness, steps = press.finger.thickness, STEPS if further else FEWEST
    tried = depths(thickness, FARTHEST * thickness if force else least, steps)
    if press.standard:  # the reference press is one of its depths
        tried = np.union1d(tried, REFERENCE_DEPTH)
    if force:
        enough = float(depths(thickness, 0.0, steps)[-1]) * (1 - 1e-9)
        borne = force / NEWTON_PER_MILLINEWTON / press.body.sides
        return _solved(press, tried, stages, (enough, borne))
    try:
        return _solved(press, tried, stages)
    except (InputError, ConvergenceError):
        if not least:
            raise
    return _solved(press, depths_to(least), stages)


def _solved(
    press: Press,
    wanted: Array,
    stages: Stages,
    enough: tuple[float, float] = (np.inf, np.inf),
) -> DepthTable:
    """Solve the table at the `wanted` depths (n,) in mm; `enough` as of `Course`."""
    with stages.stage("factor") as report:
        body = FINITE_STRAIN.body(press.finger, press.mesh, report)
        elements = continuum(body.space, materials(press.finger), soft=(1, 2))
    whole = replace(
        press,
        method=FINITE_STRAIN,
        body=body,
        motion=Ramp(1.0, float(wanted[-1]), corner=0.0),
        sites=None,
        reference=None,
    )
    course = Course(  # at 1 mm/s
        LoadPath("depth", wanted, float),
        lambda: StressHistory(elements, {}),
        LoadSteps(wanted, wanted, np.arange(len(wanted)), wanted, np.array([0, len(wanted) - 1])),
        frozenset(range(len(wanted))),
        enough,
        BUDGET,
    )
    history = follow_course(whole, elements, course, stages)
    if history.halt:
        raise ConvergenceError(history.halt)
    solved = wanted[: len(history.depth)]
    fields = [history.frames[k] for k in range(len(solved))]
    if not (press.standard and REFERENCE_DEPTH in solved):
        with stages.stage("reference"):
            fields.append(reference_unknowns(whole, elements))
    pressure, travel = history.pressure, history.contact.projected
    force = press.body.sides * pressure @ travel * NEWTON_PER_MILLINEWTON
    if (force > 0).sum() < RESOLVED:
        raise InputError(mesh_limits.unresolved(float(solved[-1])))
    with stages.stage("work"):
        work = work_ratios(elements, fields[: len(solved)], solved, force)
    pad, column = whole_pad(body, history.contact.neighborhood)
    return DepthTable(
        depth=solved,
        force=force,
        moment=history.moment,
        area=areas_of_steps(press, history, pad, column),
        stiffening=stiffening(whole, fields[: len(solved)]),
        work=work,
        pressure=pressure,
        gap=history.gap,
        modes=DisplacementBasis.of(np.array(fields)[:, : body.space.n_displacements]),
        reach=history.contact.reach,
        modulus=press.finger.skin.modulus,
    )


def load_or_solve(press: Press, least: float, stages: Stages, *, force: float = 0.0) -> DepthTable:
    """Read or solve the table of a finger under its object; a new one is stored in the cache.

    It goes to `least` mm or more; or, where a `force` in N is given, to one that bears it, if any
    up to FARTHEST does.

    InputError if contact leaves what the indenter or the pad offers, or the mesh does not resolve
    it. ConvergenceError if an equilibrium is not reached.
    """

    def stored() -> DepthTable | None:
        table = depth_table.available(press.finger, press.indenter, press.mesh)
        if table is None or table.deepest < least * (1 - 1e-9):
            return None
        sought = table.deepest < FARTHEST * press.finger.thickness * (1 - 1e-9)
        return None if sought and table.force[-1] < force else table

    table = stored()
    if table is not None:
        return table
    name = depth_table.key_on(press.finger, press.indenter, press.mesh)
    with cache.alone(depth_table.cached_path(name)):
        table = stored()  # another process may have solved it meanwhile
        if table is None:
            # A plate ends nowhere; contact with any other object may reach its rim.
            further = press.indenter.flat is not None
            solved = solve(press, least, stages, force=force, further=further)
            table = depth_table.as_stored(solved)
            with suppress(OSError):  # without room for it, it is solved again the next time
                depth_table.keep(table, name)
                cache.limit("elastic")
    return table


def work_ratios(elements: Continuum, states: Sequence[Array], depth: Array, force: Array) -> Array:
    """Ratios W (n, n) of the stress at a depth (row) and the deformation at another (column).

    states: unknowns (n_unknowns,) of the body at each of the depths (n,) mm, from 0; force (n,) at
    them, in any unit. Where a mesh resolves no contact, they repeat the first depth where it
    does. Above the diagonal W(a, d) is as computed; below it, where contact never asks for it, it
    continues as 2 - W(d, a), so that what is interpolated across the diagonal is 1 on it.
    """
    from scipy.interpolate import CubicSpline

    strain = np.array([elements.weighted_strain(each).ravel() for each in states])
    rows = [strain @ np.add(*elements.stress(each)).ravel() for each in states]
    root = np.sqrt(depth)
    slopes = CubicSpline(root, np.eye(len(root)))(root, 1)
    work = np.array(rows) @ slopes.T
    first = int(np.argmax(force > 0))
    ratio = np.ones_like(work)
    touching = work[first:, first:]
    ratio[first:, first:] = touching / touching.diagonal() * force[first:] / force[first:, None]
    ratio[:first, first:] = ratio[first, first:]
    upper = np.triu(ratio, 1)
    return np.eye(len(depth)) + upper + np.tril(2 - upper.T, -1)
