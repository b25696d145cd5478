"""
A mechanics of your own
=======================

Winkler's foundation: springs side by side, which know nothing of each other. A mechanics has a
name, an expected time and an answer; it may refuse a scene, and say how far it errs.
"""

import numpy as np

import fefinger as ff
from fefinger.mechanics.situation import Situation
from fefinger.results.records import Refusal, Response


@ff.register
class Winkler(ff.Mechanics):
    """Pad of springs as long as the finger is thick: the force is stiffness times overlap."""

    name = "winkler"

    def refuse(self, case):
        flat = case.indenter.flat is not None and not case.motion.by_force
        return () if flat else (Refusal("winkler", "ability", "it presses plates, by depth"),)

    def cost(self, case):
        return 1e-3

    def respond(self, scene, progress=None):
        finger, time = scene.finger, Situation.of(scene).times
        depth = np.maximum(scene.motion.value(time), 0.0)
        stiffness = finger.subcutaneous.modulus / finger.thickness  # kPa/mm
        force = 1e-3 * stiffness * np.pi * finger.pad_radius * depth**2  # N, of the overlap
        said = {"mechanics": "winkler", "status": "exact", "seconds": {}, "notes": ("Elastic.",)}
        return Response(time=time, depth=depth, force=force, **said)


scene = {"motion.depth": 0.5, "ask.pressure": False, "ask.strain": False, "ask.spikes": []}
print(ff.explain("flat-press", changes=scene))
print(ff.run("flat-press", changes=scene, mechanics="winkler"))
