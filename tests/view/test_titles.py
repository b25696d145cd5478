"""What is written above results that are shown side by side."""

import dataclasses
import re

from fefinger.result import Result
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.motions import Sinusoid
from fefinger.view.drawing import titles


def turned(result: Result, angle: float) -> Result:
    scene = dataclasses.replace(result.scene, indenter=Flat(angle))
    return dataclasses.replace(result, scene=scene)


def test_panels_are_called_as_their_folders_with_what_differs(synthetic: Result) -> None:
    both = [turned(synthetic, angle) for angle in (30.0, 20.0)]
    name = synthetic.scene.name
    assert titles(both, ["runs/a-1.5", "runs/b/result.nc"]) == (
        f"a-1.5: {name}, indenter.angle 30 deg",
        f"b: {name}, indenter.angle 20 deg",
    )
    assert titles(both) == (f"{name}, indenter.angle 30 deg", f"{name}, indenter.angle 20 deg")
    assert titles(both[:1], ["runs/a"]) == (name,)
    slow = dataclasses.replace(both[0].scene, motion=Sinusoid(0.3, 5.0, 2))
    other = [both[1], dataclasses.replace(both[0], scene=slow)]
    assert titles(other)[1] == f"{name}, motion.kind sinusoid, indenter.angle 30 deg"
    faces = [dataclasses.replace(each, scene=dataclasses.replace(each.scene, indenter=indenter))
             for each, indenter in zip(both, (Sphere(3.0), Flat(10.0)), strict=True)]  # fmt: skip
    assert titles(faces)[0] == f"{name}, indenter.kind sphere"
    second = dataclasses.replace(faces[1].scene, finger=Finger.subject("p.w.", tissue="maeno1998"))
    told = titles([faces[0], dataclasses.replace(faces[1], scene=second)])[1].split(", ")
    assert told[1:3] == ["indenter.kind flat", "finger.subject p.w."]
    wide = dataclasses.replace(both[0].scene.finger, width=15, thickness=9, pad_radius=12)
    bare = dataclasses.replace(both[1].scene, finger=wide)
    far = titles([both[0], dataclasses.replace(both[1], scene=bare)])
    assert all(re.search(r", \d more$", title) for title in far)
