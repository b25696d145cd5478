"""Gauss-Legendre rules for the integrals of layered bodies."""

import itertools
import math
from functools import cache

import numpy as np
from numpy.polynomial import legendre

from fefinger.theory.contact.elastic import Array


PHASE = 14.0
"""Largest phase of a cosine per panel in radians: its Legendre coefficient 32 is then 1e-19."""

_NODES, _WEIGHTS = legendre.leggauss(16)


@cache
def even_rule(count: int) -> tuple[Array, Array]:
    """Nodes and weights (count,) on 0..1, exact for even polynomials of degree < 4 count."""
    nodes, weights = legendre.leggauss(2 * count)
    return nodes[count:], weights[count:]


@cache
def even_basis(count: int) -> Array:
    """Legendre P_0, P_2, ... (count, count) at the nodes of `even_rule`, one row per node."""
    nodes, _ = even_rule(count)
    basis = np.array(legendre.legvander(nodes, 2 * count - 1)[:, ::2], np.float64)
    basis.flags.writeable = False
    return basis


def panels(low: float, high: float, *, reach: float) -> tuple[Array, Array]:
    """Composite Gauss-Legendre nodes and weights (n,) on 0..high: one panel to `low`, then octaves.

    No panel is wider than PHASE / reach.
    """
    octaves = max(1, math.ceil(math.log2(high / low)))
    edges = [0.0, *np.geomspace(low, high, octaves + 1)]
    cuts = [np.zeros(1)]
    for start, end in itertools.pairwise(edges):
        pieces = max(1, math.ceil((end - start) * reach / PHASE))
        cuts.append(np.linspace(start, end, pieces + 1)[1:])
    cut = np.concatenate(cuts)
    half = np.diff(cut)[:, None] / 2
    return (cut[:-1, None] + half * (_NODES + 1)).ravel(), (half * _WEIGHTS).ravel()


def panels_up_to(nodes: Array, high: float) -> int:
    """Count the first `nodes` of `panels` that cover 0..high, in whole panels."""
    points = len(_NODES)
    return min(len(nodes), points * math.ceil(int(np.searchsorted(nodes, high)) / points))
