"""Speed of shear waves in tissue under a press: how far stiffening raises it.

A wave with the normal n and the polarization m in a body of the deformation gradient F has

    rho c² = G dE : C : dE + N . S . N,    N = F' n,  dE = sym(F' m (x) F' n),

C and S being the relaxed moduli and stress: the relaxed press bears S, and a fast wave meets C
times G, 1 / c0 where it is faster than all relaxation. The pressure of incompressible tissue does
no work in it (Ogden, Non-linear Elastic Deformations, section 6.4).
"""

import numpy as np
from fefinger.validation.human.presses import finger

from fefinger.fem.elements.probe import recovered_gradient_at
from fefinger.fem.hyperelastic.material import PAIRS, Material, at_point
from fefinger.mechanics.press import tabulated_press
from fefinger.mechanics.press.problem import Press, materials
from fefinger.mechanics.press.tabulated_press import TabulatedPress, table_of
from fefinger.scene.ask import Ask
from fefinger.scene.cautions import DENSITY
from fefinger.scene.indenters import STANDARD
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.progress import Stages


DEEP = 0.5  # mm below the surface: the middle of the skin
DEEPEST = 1.5  # mm


def shear_speed(
    law: Material, gradient: Array, normal: Array, polarization: Array, fast: float
) -> float:
    """Speed in m/s of a shear wave in tissue of a displacement gradient (3, 3).

    normal, polarization (3,): unit vectors, perpendicular; fast: G over its long-time value.
    """
    isochoric, moduli = at_point(law, gradient)
    deformation = np.eye(3) + gradient
    back, moved = deformation.T @ normal, deformation.T @ polarization
    change = np.array([moved[i] * back[j] + moved[j] * back[i] for i, j in PAIRS])
    change[:3] /= 2
    stress = np.empty((3, 3))
    for value, (i, j) in zip(isochoric, PAIRS, strict=True):
        stress[i, j] = stress[j, i] = value
    stiffness = fast * change @ moduli @ change + back @ stress @ back
    return float(np.sqrt(stiffness / DENSITY) / 1e3)


def skin_speeds(name: str, force: float) -> tuple[float, float]:
    """Means over the skin in contact, and at rest, of the speed in m/s of instantaneous waves.

    They run along the finger and move the skin along its normal, under a relaxed force in N.
    """
    subject = finger(name)
    ask = Ask(pressure=True, strain=False, fields=False)
    scene = Scene(finger=subject, indenter=STANDARD, motion=Ramp(1.0, DEEPEST), ask=ask)
    press = Press.of(scene, tabulated_press.METHOD, Stages(None), mechanics="pressed", notes=())
    table = table_of(press, Stages(None))
    placed = TabulatedPress.of(press, table)
    count = len(table.depth)
    weights = np.array([np.interp(force, table.force, row) for row in np.eye(count)])
    on = placed.contact.on.vertices[weights @ table.pressure > 0]
    body = press.body
    normals = body.normals[on]
    points = body.space.points[on] - DEEP * normals
    probe = recovered_gradient_at(body.space, body.folded(points), body.planes)
    amplitudes = weights @ table.modes.amplitudes[:count]
    gradients = (probe @ table.unknowns(amplitudes, probe.shape[1])).reshape(-1, 3, 3)
    skin, fast = materials(subject)[1], 1 / subject.prony.long_time
    loaded, rest = [], []
    for gradient, up in zip(gradients, normals, strict=True):
        along = np.cross(np.array([0.0, 1.0, 0.0]), up)
        along /= np.linalg.norm(along)
        loaded.append(shear_speed(skin, gradient, along, up, fast))
        rest.append(shear_speed(skin, 0 * gradient, along, up, fast))
    return float(np.mean(loaded)), float(np.mean(rest))
