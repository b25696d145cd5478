"""A finger on a patch as modes, and the static flexibility that they leave over."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg, sparse

from fefinger.fem.body import Reduced
from fefinger.fem.condensation import Operator, displaced
from fefinger.fem.contact.complementarity import Complementarity
from fefinger.fem.contact.oscillators import Oscillators
from fefinger.fem.elements.mass import mass
from fefinger.fem.elements.spaces import Array, Integers
from fefinger.fem.linalg.threads import one_thread
from fefinger.mechanics.press.mode_store import PER_CUBIC_METER, FingerModes
from fefinger.scene.finger import Finger


DEPTHS = 12
"""Depths of contact whose motion with the indenter is a mode. On the standard finger the stiffness
of 300 modes under a plate is 2.3 % off at 200 Hz without them, 0.05 % with 12."""

MASSIVE = 0.98
"""Share of the flexibility of such motions that has mass."""

INDEPENDENT = 1e-6
"""Least share of a motion that the others do not contain."""


@dataclass(frozen=True)
class ModalBody:
    """Response of a body to loads on a patch: that of its modes, and the static rest.

    static: the response without inertia; oscillators: the modes; shares (n, n_pad): work of each
    unit load on each mode; rest (n_pad, n_pad) the flexibility less that of the modes; strain
    (n_rows, n) and normal_displacement (n_near, n) of each mode, as those of `static`; carriers
    (n_pad, n): pressures whose static displacement, less that of the free modes, is the mode; zero
    for a free mode.
    """

    static: Reduced
    oscillators: Oscillators
    shares: Array
    rest: Array
    strain: Array
    normal_displacement: Array
    carriers: Array

    @property
    def complete(self) -> Reduced:
        """Response to the elastic pressures of the rest, followed by the amplitudes of modes."""
        part = self.shares.T / self.oscillators.squares
        strain = np.hstack([self.static.strain - self.strain @ part.T, self.strain])
        normal = self.static.normal_displacement - self.normal_displacement @ part.T
        moved = np.hstack([normal, self.normal_displacement])
        return replace(self.static, strain=strain, normal_displacement=moved)

    def below(self, glassy: float) -> "ModalBody":
        """Return the same body with the modes that are below a frequency in Hz in sudden strain.

        The others deform as in statics.
        """
        chosen = np.flatnonzero(self.oscillators.glassy < 2 * np.pi * glassy)
        return self.only(chosen)

    def only(self, chosen: Integers) -> "ModalBody":
        """Return the same body with some of its modes; the others deform as in statics."""
        return modal(
            self.static,
            self.oscillators.only(chosen),
            self.shares[chosen],
            self.strain[:, chosen],
            self.normal_displacement[:, chosen],
            self.carriers[:, chosen],
        )

    def pressures(self, elastic: Array) -> tuple[Array, Array]:
        """Pressures (n_t, n_pad) and amplitudes (n_t, n) whose fields make the displacement.

        elastic (n_t, n_pad + n): as for `complete`. The displacement is that of statics under the
        pressures, and of the free modes of the amplitudes; those of other modes are zero.
        """
        count = self.shares.shape[1]
        rest, amplitude = elastic[:, :count], elastic[:, count:]
        over = amplitude - rest @ self.shares.T / self.oscillators.squares
        free = ~self.carriers.any(axis=0)
        carried = rest + np.where(free, 0.0, over) @ self.carriers.T
        left = amplitude - carried @ self.shares.T / self.oscillators.squares
        return carried, np.where(free, left, 0.0)


@one_thread
def modal(
    static: Reduced,
    oscillators: Oscillators,
    shares: Array,
    strain: Array,
    normal: Array,
    carriers: Array,
) -> ModalBody:
    """Take the flexibility of the modes from the static one, and keep the rest."""
    rest = static.flexibility - (shares.T / oscillators.squares) @ shares
    return ModalBody(static, oscillators, shares, (rest + rest.T) / 2, strain, normal, carriers)


def body_of_modes(
    finger: Finger,
    modes: FingerModes,
    static: Reduced,
    probe: Callable[[], sparse.csr_matrix],
    stiffening: float = 1.0,
) -> ModalBody:
    """Read the modes of a finger on a patch, where `static` is its response without inertia.

    probe: the strain at the points of `static`; stiffening: factor on the moduli, which `static`
    includes.
    """
    prony = finger.prony
    weights = np.array(prony.weights[1:]) / prony.weights[0]
    oscillators = Oscillators.of(modes.squares * stiffening, weights, np.array(prony.v))
    shares = modes.read(static.patch.loads.T.tocsr()).T
    normal = modes.read(static.patch.places.T.tocsr())
    strain, none = modes.read(probe()), np.zeros((shares.shape[1], len(shares)))
    return modal(static, oscillators, np.ascontiguousarray(shares), strain, normal, none)


def stiffened(static: Reduced, factor: float) -> Reduced:
    """Return the response of a body with moduli that are `factor` times as large."""
    return replace(
        static,
        flexibility=static.flexibility / factor,
        strain=static.strain / factor,
        normal_displacement=static.normal_displacement / factor,
    )


@one_thread
def rest_inertia(
    finger: Finger, solid: Operator, body: ModalBody, patterns: Array, stiffening: float = 1.0
) -> Array:
    """Second static term (k, k): mass of the displacement that modes leave over.

    The integral of density times the product of the rest's displacements under two of the pressures
    `patterns` (n_pad, k): K^-1 M K^-1 less phi phi' / w^4, in kg mm²/mN²; for relaxed tissue with
    the moduli of `finger` times `stiffening`.
    """
    size = solid.space.n_displacements
    densities = {1: finger.skin.density, 2: finger.subcutaneous.density}
    heavy = mass(solid.space, {k: value * PER_CUBIC_METER for k, value in densities.items()})
    moved = displaced(solid, body.static.patch.loads @ patterns)[:size] / stiffening
    work = body.shares @ patterns
    total = moved.T @ (heavy @ moved) - (work.T / body.oscillators.squares**2) @ work
    return np.asarray((total + total.T) / 2)


@one_thread
def with_contact_modes(
    finger: Finger, solid: Operator, body: ModalBody, deepest: float, stiffening: float = 1.0
) -> ModalBody:
    """Add modes of what the free modes leave over: motions with the indenter at some depths.

    Free modes carry no pressure on the pad, and represent the tissue that moves with an indenter
    poorly. Its static motion at `DEPTHS` depths up to `deepest` mm has stiffness and mass; the
    modes of that small problem are orthogonal to the others. A share of their flexibility stays
    without mass, so that no pressure acts on mass alone.
    """
    patterns = _patterns(body.static, deepest)
    stiffness = patterns.T @ body.rest @ patterns
    inertia = rest_inertia(finger, solid, body, patterns, stiffening)
    scale = np.sqrt(np.diag(stiffness))
    chosen, _ = _independent(stiffness / np.outer(scale, scale))
    turn = (chosen.T / scale).T
    squares, vectors = linalg.eigh(turn.T @ stiffness @ turn, turn.T @ inertia @ turn)
    pressures = np.sqrt(MASSIVE) * patterns @ turn @ vectors
    o = body.oscillators
    part = body.shares.T / o.squares
    more = Oscillators.of(squares, o.weights, o.rates)
    return modal(
        body.static,
        o.followed_by(more),
        np.vstack([body.shares, pressures.T @ body.rest]),
        np.hstack([body.strain, (body.static.strain - body.strain @ part.T) @ pressures]),
        np.hstack(
            [
                body.normal_displacement,
                (body.static.normal_displacement - body.normal_displacement @ part.T) @ pressures,
            ]
        ),
        np.hstack([body.carriers, pressures]),
    )


def _patterns(static: Reduced, deepest: float) -> Array:
    """Pressures (n_pad, k) that move the contact of some depths as a whole."""
    patch, solver = static.patch, Complementarity(static.flexibility)
    patterns = []
    for depth in np.linspace(0, deepest, DEPTHS + 1)[1:]:
        active = np.flatnonzero(solver.solve(patch.gap - depth * patch.projected) > 0)
        if len(active):
            pattern = np.zeros(len(patch.gap))
            block = static.flexibility[np.ix_(active, active)]
            pattern[active] = np.linalg.solve(block, patch.projected[active])
            patterns.append(pattern)
    return np.array(patterns).T.reshape(len(patch.gap), -1)


def _independent(gram: Array) -> tuple[Array, Array]:
    """Return combinations (k, r) of patterns that are independent, and their weights."""
    values, vectors = np.linalg.eigh(gram)
    kept = values > INDEPENDENT * values.max(initial=0.0)
    return vectors[:, kept] / np.sqrt(values[kept]), values[kept]
