"""Results of other programs for the same Hertz contact, measured on two cores with one thread.

a / R = 0.0015, the half-space's displacement prescribed around a mesh of tetrahedra, a rigid
frictionless plate. Pressure is nodal reaction over tributary area, RMS over the true disk.
"""

from typing import NamedTuple


class Peer(NamedTuple):
    """One run: errors in %, and CPU seconds, NaN where not measured."""

    program: str
    nodes: int
    poisson: float
    force: float
    peak: float
    rms: float
    cpu_s: float


NAN = float("nan")
PEERS = (
    Peer("scikit-fem P1, active set", 13_000, 0.3, 1.6, 4.5, 4.1, 22.7),
    Peer("scikit-fem P1, active set", 39_000, 0.3, 0.7, 2.8, 3.1, 180),
    Peer("FElupe 11.3 P1, penalty", 13_000, 0.3, 1.5, 4.3, 4.0, 23),
    Peer("FElupe 11.3 P1, penalty", 39_000, 0.3, 0.7, 2.7, 3.0, 174),
    Peer("EasyFEA 7.1 P1, penalty", 13_000, 0.3, 0.65, 1.2, 2.1, 28.9),
    Peer("SfePy 2026.3 P1, penalty", 13_000, 0.3, 0.65, 1.2, 2.1, 29.3),
    Peer("CalculiX 2.20 P1", 13_000, 0.3, 0.65, 1.2, 2.0, 54),
    Peer("GetFEM 5.4 P1, augmented", 13_000, 0.3, 1.6, 4.5, 4.6, 29),
    Peer("NGSolve P2, 1.4k vertices", 1_400, 0.3, -1.25, -1.8, 4.1, 37),
    Peer("any P1", 13_000, 0.49, 11.0, 69.0, 33.0, NAN),
    Peer("FElupe MINI", 3_400, 0.49, 2.8, 7.1, 5.0, 24),
    Peer("NGSolve P2, 1.4k vertices", 1_400, 0.49, -1.0, -1.8, 3.9, 37),
    Peer("FEBio 4.11 tet10, finite strain", 8_400, 0.49, -0.22, -1.3, 5.9, 27),
    Peer("FEBio 4.11 tet10, finite strain", 20_400, 0.49, -0.16, -1.4, 5.5, 210),
)
"""The finest runs of each program. The scatter of FEBio's pressure is about its own fit."""
