"""A tactile finger in MuJoCo: poses are read from it, and wrenches given back.

    import fefinger.mujoco
    tip = ff.TactileFinger(ff.Finger.subject("a.h."), friction=0.6)
    feel = fefinger.mujoco.couple(model, "fingertip", {"ball": ff.shapes.Sphere(10)}, tip)
    while data.time < 1:
        touch = feel.step(data)  # before each step of MuJoCo
        mujoco.mj_step(model, data)

MuJoCo counts in m, kg and s, fefinger in mm. The wrench acts through `xfrc_applied` from one step
to the next, so that an object of mass m on a pad of stiffness k needs a time step below
2 sqrt(m / k).
"""

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fefinger.mechanics.press.tactile_parts import poses
from fefinger.mechanics.tactile_finger import TactileFinger
from fefinger.results.touch import Touch
from fefinger.shapes import Shape
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, instance, shown


if TYPE_CHECKING:
    import mujoco


__all__ = ["Coupling", "couple"]

MM = 1e3
"""Millimeters in a meter, and N mm in N m."""


class Coupling:
    """A tactile finger on a body of a MuJoCo model, which feels some of its geoms; see `couple`.

    touch: what was felt in the last step; taxels (n_taxels, 3): the forces in N under them, in the
    frame of the finger, one array for all steps, as MuJoCo's `sensordata`.
    """

    def __init__(
        self,
        model: "mujoco.MjModel",
        body: str,
        geoms: Mapping[str, Shape],
        finger: TactileFinger,
        rotation: ArrayLike,
        place: ArrayLike,
    ) -> None:
        import mujoco

        instance("model", model, mujoco.MjModel, "a model, as mujoco.MjModel.from_xml_path")
        instance("finger", finger, TactileFinger, "a finger, as ff.TactileFinger(...)")
        instance("geoms", geoms, Mapping, 'a shape by the name of each, as {"ball": ...}')
        if not geoms:
            raise InputError("geoms: expected one geom or more, received none")
        if finger.worlds != 1:
            raise InputError(f"finger: expected one of a single world, received {finger.worlds}")
        self.model, self.finger, self.shapes = model, finger, tuple(geoms.values())
        self._body = _number(model, "body", body)
        self._geoms = [_number(model, "geom", name) for name in geoms]
        self._owners = [int(model.geom_bodyid[geom]) for geom in self._geoms]
        mount = poses([(shape, rotation, place) for shape in self.shapes], 1, "geoms")
        self._rotation, self._place = mount.rotation[0, 0], mount.place[0, 0] / MM
        self._given: dict[int, Array] = {}
        self.taxels = np.zeros((len(finger.taxels.places), 3))
        self.touch: Touch | None = None
        for name, geom in zip(geoms, self._geoms, strict=True):
            self._check_alone(name, geom)

    def _check_alone(self, name: str, geom: int) -> None:
        """Refuse a geom that MuJoCo itself lets collide with the body, which would push twice."""
        model, own = self.model, self._body
        kinds, affine = model.geom_contype, model.geom_conaffinity
        pair = sorted((own, int(model.geom_bodyid[geom])))
        if (pair[0] << 16) + pair[1] in set(model.exclude_signature.tolist()):
            return
        for other in np.flatnonzero(model.geom_bodyid == own):
            if kinds[geom] & affine[other] or kinds[other] & affine[geom]:
                raise InputError(
                    f"geoms: expected no contact of MuJoCo's own between {name!r} and the finger, "
                    "received geoms that collide; give those of the finger contype=0 and "
                    "conaffinity=0, or exclude the pair of bodies"
                )

    def step(self, data: "mujoco.MjData") -> Touch:
        """Feel the geoms where they are, and apply the wrenches to `data.xfrc_applied`.

        The time since the last step is read from the model. Errors as `TactileFinger.step`.
        """
        import mujoco

        instance("data", data, mujoco.MjData, "the data of the model, as mujoco.MjData(model)")
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_comPos(self.model, data)
        turn = data.xmat[self._body].reshape(3, 3) @ self._rotation
        origin = data.xpos[self._body] + data.xmat[self._body].reshape(3, 3) @ self._place
        objects = [
            (
                shape,
                turn.T @ data.geom_xmat[geom].reshape(3, 3),
                MM * turn.T @ (data.geom_xpos[geom] - origin),
            )
            for shape, geom in zip(self.shapes, self._geoms, strict=True)
        ]
        touch = self.touch = self.finger.step(objects, float(self.model.opt.timestep))
        self.taxels[:] = touch.taxels
        self._apply(data, turn, origin, touch.wrench)
        return touch

    def _apply(self, data: "mujoco.MjData", turn: Array, origin: Array, wrench: Array) -> None:
        """Replace what the last step applied by wrenches (bodies, 6) on the finger."""
        for body, given in self._given.items():
            data.xfrc_applied[body] -= given
        self._given = {body: np.zeros(6) for body in {self._body, *self._owners}}
        for owner, each in zip(self._owners, wrench, strict=True):
            force, moment = turn @ each[:3], turn @ each[3:] / MM
            for body, sign in ((self._body, 1.0), (owner, -1.0)):
                about = moment + np.cross(origin - data.xipos[body], force)
                self._given[body] += sign * np.concatenate([force, about])
        for body, given in self._given.items():
            data.xfrc_applied[body] += given

    def reset(self) -> None:
        """Forget contact and history, as after `mj_resetData`, which clears applied forces."""
        self.finger.reset()
        self._given.clear()
        self.touch, self.taxels[:] = None, 0.0


def couple(
    model: "mujoco.MjModel",
    body: str,
    geoms: Mapping[str, Shape],
    finger: TactileFinger,
    *,
    rotation: ArrayLike = ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    place: ArrayLike = (0, 0, 0),
) -> Coupling:
    """Let a tactile finger on a body of a MuJoCo model feel some of its geoms.

    body: name of the body whose frame is that of the finger, x distal and z dorsal, or has the
    finger at `place` (3,) mm, turned by `rotation` (3, 3). geoms: names of geoms with the shape
    that each has for the finger, its frame being the geom's.

    Raises InputError for what is none of these, names that the model lacks, geoms with which MuJoCo
    itself lets the body collide, or a finger of several worlds.
    """
    return Coupling(model, body, geoms, finger, rotation, place)


def _number(model: "mujoco.MjModel", kind: str, name: str) -> int:
    """Return the number of a named part of a model; InputError if there is none."""
    if isinstance(name, str):  # MuJoCo takes numbers too
        with suppress(KeyError):
            return int(getattr(model, kind)(name).id)
    raise InputError(f"{kind}: expected a name of the model, received {shown(name)}")
