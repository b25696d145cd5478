"""Vibration about a finite preload: `solid` linearized about the compressed, relaxed finger.

With one relaxation function of the whole second Piola-Kirchhoff stress, small motions about a
relaxed press have the stiffness G* K_m + K_g: the material part of the tangent relaxes, the
geometric one, of the stress at rest, does not. The contact is that of the press and stays closed.
One sparse complex solution per frequency, without modes; it shares the elements with `solid`, and
nothing with `modal` but the mass matrix.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from fefinger.contact.oscillators import Complex, complex_modulus
from fefinger.fem.contact.deformed_gap import DeformedGap, contact_surface
from fefinger.fem.elements.assembly import mass
from fefinger.fem.hyperelastic.continuum import Continuum, HistoryStress, continuum
from fefinger.fem.hyperelastic.newton import Equilibrium
from fefinger.fem.hyperelastic.state import State, Target
from fefinger.fem.linalg.system import System
from fefinger.mechanics.press import operator, tabulated_press
from fefinger.mechanics.press.finite_strain import FINITE_STRAIN
from fefinger.mechanics.press.frequency_response import Vibrating, about
from fefinger.mechanics.press.modal_body import PER_CUBIC_METER, finger_modes
from fefinger.mechanics.press.modal_press import operator_of
from fefinger.mechanics.press.modal_response import stiffening
from fefinger.mechanics.press.problem import Press, materials
from fefinger.mechanics.press.tabulated_press import TabulatedPress, about_preload, table_of
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array, Integers
from fefinger.support.progress import Stages
from fefinger.support.units import NEWTON_PER_MILLINEWTON


STEPS = 14
"""Load steps of the press."""

STABLE = 0.01
"""Diagonal entries over the largest of their column that need no pivoting."""


def modulus(finger: Finger, frequency: Array) -> Complex:
    """Complex modulus (n_f,) of a finger over the long-time one, at frequencies (n_f,) in Hz."""
    return complex_modulus(*finger.prony.branches, frequency)


@dataclass(frozen=True)
class Preloaded:
    """A finger of stiffening tissue, pressed to a depth in mm and relaxed.

    press: of the flat plate; table: its elastic press; equilibrium: the solver of `solid`; state,
    gap: at the depth.
    """

    press: Press
    table: TabulatedPress
    depth: float
    equilibrium: Equilibrium
    state: State
    gap: DeformedGap

    @classmethod
    def of(cls, finger: Finger, depth: float) -> "Preloaded":
        """Press a finger against the plate at 30 degrees."""
        press, table = _pressed(finger, depth)
        body = FINITE_STRAIN.body(finger, press.mesh, lambda fraction: None)
        elements = continuum(body.space, materials(finger), soft=(1, 2))
        contact = contact_surface(
            *(body.space, body.pad, body.normals, press.obstacle, table.table.reach),
            spreads=elements.nearly_incompressible,
        )
        equilibrium = Equilibrium(elements, contact, body.system)
        state = State(np.zeros(body.space.n_unknowns), np.zeros(len(contact)), 0.0)
        for part in np.linspace(0, 1, STEPS + 1)[1:]:
            target = Target("depth", float(depth * part**2), elements.at_rest)
            state = equilibrium.find(state, target)
        return cls(press, table, depth, equilibrium, state, contact.at(state))

    @property
    def elements(self) -> Continuum:
        """Elements of the body."""
        return self.equilibrium.body

    @property
    def system(self) -> System:
        """The body at rest, with what is held."""
        return self.equilibrium.system

    def secant(self, part: float) -> float:
        """Difference in N/mm of the forces of two equilibria, deeper and shallower by a part."""
        forces = []
        for depth in (self.depth * (1 - part), self.depth * (1 + part)):
            target = Target("depth", depth, self.elements.at_rest)
            pressure = self.equilibrium.find(self.state, target).pressure
            forces.append(float(self.gap.contact.projected @ pressure))
        unit = NEWTON_PER_MILLINEWTON * self.press.body.sides
        return unit * (forces[1] - forces[0]) / (2 * part * self.depth)

    @cached_property
    def active(self) -> Integers:
        """Candidates in contact."""
        return np.flatnonzero(self.state.pressure > 0)

    @cached_property
    def _parts(self) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
        """Material and geometric stiffness: of a factor g, g S + (1 - g) S has the tangent g C."""
        elements, values = self.elements, self.state.values
        once = elements.tangent(values, elements.at_rest)
        isochoric, volumetric = elements.stress(values)
        twice = HistoryStress(2 * elements.at_rest.gains, -isochoric - volumetric)
        material = elements.tangent(values, twice) - once
        return material, once - material

    @cached_property
    def _mass(self) -> sparse.csr_matrix:
        finger, space = self.press.finger, self.elements.space
        densities = {1: finger.skin.density, 2: finger.subcutaneous.density}
        heavy = mass(space, {k: value * PER_CUBIC_METER for k, value in densities.items()})
        rest = space.n_unknowns - heavy.shape[0]
        return sparse.block_diag([heavy, sparse.csr_matrix((rest, rest))]).tocsr()

    def stiffness(self, factor: complex, omega: float) -> complex:
        """Force in N per mm of the plate, for a relaxation factor G* and an angular frequency."""
        free, space = self.system.free, self.elements.space
        material, geometric = self._parts
        # The contact law changes with the distance of skin and plate, not with that of the skin.
        bent = self.gap.stiffness() + self.gap.spreading_stiffness()
        along = np.zeros(space.n_unknowns)
        along[: space.n_displacements] = np.tile(self.press.obstacle.axis, space.n_nodes)
        coupled = (bent @ along)[free]
        body = (factor * material + geometric + bent - omega**2 * self._mass)[free][:, free]
        loads = self.gap.loads[free][:, self.active]
        travel = self.gap.contact.projected[self.active]
        matrix = sparse.bmat([[body, -loads], [-loads.T, None]], format="csr")
        right = np.concatenate([coupled, -travel]).astype(matrix.dtype)
        # In the order of our own, which is a quarter of the work of those of SuperLU.
        order = np.append(self.system.dissection.order, np.arange(len(free), len(right)))
        solver = splu(
            matrix[order][:, order].tocsc(),
            permc_spec="NATURAL",
            options={"SymmetricMode": True},
            diag_pivot_thresh=STABLE,
        )
        answer = np.zeros_like(right)
        for _ in range(2):
            answer[order] += solver.solve((right - matrix @ answer)[order])
        moved, pressure = answer[: len(free)], answer[len(free) :]
        force = travel @ pressure - coupled @ moved + along[free] @ coupled
        return complex(NEWTON_PER_MILLINEWTON * self.press.body.sides * force)

    @cached_property
    def statics(self) -> tuple[float, float]:
        """Material and geometric stiffness in N/mm of the press: without inertia it is G* a + b."""
        once, more = (self.stiffness(factor, 0.0).real for factor in (1.0, 4.0))
        material = (more - once) / 3
        return material, once - material

    def still(self, finger: Finger, frequency: Array) -> Complex:
        """Stiffness (n_f,) in N/mm without inertia, with the relaxation of `finger`."""
        material, geometric = self.statics
        return np.asarray(modulus(finger, frequency) * material + geometric)

    def exact(self, finger: Finger, frequency: Array) -> Complex:
        """Dynamic stiffness (n_f,) in N/mm with the relaxation of `finger`."""
        factors = modulus(finger, frequency)
        pairs = zip(factors.tolist(), (2 * np.pi * frequency).tolist(), strict=True)
        return np.array([self.stiffness(factor, omega) for factor, omega in pairs])

    @cached_property
    def _linear(self) -> Press:
        return _press(self.press.finger, self.depth, linear=True)

    @cached_property
    def factor(self) -> float:
        """Static stiffness over the linear finger's."""
        return stiffening(self._linear, self.table, self.depth)

    def linear(self, finger: Finger, frequency: Array, share: float) -> Complex:
        """Dynamic stiffness (n_f,) in N/mm of the linear finger that `modal` takes.

        share: stiffness of the material over the whole one, less 1.
        """
        press = self._linear
        solid, finger = operator_of(press), about_preload(finger, share)
        parts = finger, solid, finger_modes(finger, solid)
        return about(
            lambda on_pad, reach: Vibrating.of(*parts, on_pad, reach, None, self.factor),
            *(solid, press.obstacle, self.depth, frequency),
            depth=self.depth,
        ).stiffness


def _press(finger: Finger, depth: float, *, linear: bool) -> Press:
    """Place the finger under the plate, as `modal` and as `pressed` see it."""
    scene = Scene(finger=finger, motion=Ramp(1.0, depth), ask=Ask(fields=False, strain=False))
    method = operator.METHOD if linear else tabulated_press.METHOD
    return Press.of(scene, method, Stages(None), mechanics="modal", notes=())


def _pressed(finger: Finger, depth: float) -> tuple[Press, TabulatedPress]:
    press = _press(finger, depth, linear=False)
    return press, TabulatedPress.of(press, table_of(press, Stages(None)))


def viscous(finger: Finger) -> Finger:
    """Return a calibrated finger with the relaxation that goes on to a kHz."""
    other = Finger.subject(str(finger.subject_name), tissue=f"{finger.tissue}_viscous")
    return replace(finger, prony=other.prony)
