"""Solve the elastic presses that are shipped, and write them beside the meshes.

Run as `python -m fefinger.validation.pressed.ship meshes`; some six minutes. Those of the four
calibrated fingers and of the means, on the coarse and the standard mesh, under the plate at 30
degrees and a ball of 5 mm, to a fifth of the thickness or as deep as the object goes.
"""

import sys
from pathlib import Path

from fefinger.mechanics.press import depth_table as store
from fefinger.mechanics.press.elastic_press import solve
from fefinger.mechanics.press.problem import Press
from fefinger.mechanics.press.tabulated_press import METHOD
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.progress import Stages


SUBJECTS = ("a.h.", "d.p.", "d.s.", "p.w.")
OBJECTS = {"flat-30": Flat(30), "ball-5": Sphere(radius=5)}
PARTS = (0.2, 0.16, 0.12, 0.09, 0.07)
"""Depths over the thickness, the deepest that can be solved of which is shipped."""

STIFF = ("d.p.",)
"""Subjects whose tissue bears 6 N at the deepest of these, relaxed: shipped to the next."""


def ship(folder: Path, subject: str, resolution: str, name: str) -> Path | None:
    """Write the press of one finger under one object; None where it is there already."""
    finger, indenter = Finger.subject(subject, resolution=resolution), OBJECTS[name]
    motion = Ramp(1.0, 1.0)
    scene = Scene(finger=finger, indenter=indenter, motion=motion, ask=Ask(fields=False))
    press = Press.of(scene, METHOD, Stages(), mechanics="pressed", notes=())
    key = store.key(finger, indenter, press.mesh.source_sha256)
    if any(True for _ in store.shipped(key)):
        return None
    for part in PARTS[subject in STIFF :]:
        try:
            table = solve(press, part * finger.thickness, Stages())
        except (InputError, ConvergenceError):
            continue
        file = f"{store.PREFIX}{subject.replace('.', '')}-{resolution}-{name}"
        path = folder / f"{file}-{key[: store.DIGITS]}.npz"
        store.write(table, path)
        return path
    message = f"{subject}, {name}: expected a press to {PARTS[-1]:g} of the thickness, found none"
    raise InputError(message)


def main(folder: Path) -> None:
    """Write all presses that are not there."""
    for resolution in ("coarse", "standard"):
        for subject in SUBJECTS:
            for name in OBJECTS:
                print(ship(folder, subject, resolution, name), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
