"""A tactile finger in MuJoCo: a ball that drops, a cube that is held, a cylinder that rolls."""

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.support.checks import InputError


mujoco = pytest.importorskip("mujoco", reason="the extra 'mujoco' is not installed")

TISSUE = {"resolution": "coarse", "tissue": "maeno1998"}
ELASTIC = ff.Finger.subject("a.h.", prony=ff.Prony((1.0,), ()), **TISSUE)
VISCOUS = ff.Finger.subject("a.h.", **TISSUE)
GRAVITY = 9.81
HELD = 0.9  # s of the cube, from the first touch; docs/simulator.md states what 10.4 s show

pytestmark = pytest.mark.usefixtures("module_operators")


def lowest(tip: ff.TactileFinger) -> float:
    """Return how far in m the pad reaches below the origin."""
    return float(-1e-3 * tip.pad.points[:, 2].min())


def bounces(tip: ff.TactileFinger, step: float = 5e-4, seconds: float = 0.55) -> list[float]:
    """Drop a ball of 20 g by 2 mm on a finger that lies on its back; return the mean energies in J.

    One for each flight between two contacts, over the depth at first touch.
    """
    mass, height = 0.02, lowest(tip) + 0.01
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{step}" gravity="0 0 -{GRAVITY}"/><worldbody>
        <body name="finger" quat="0 1 0 0"><geom size="0.001" contype="0" conaffinity="0"/></body>
        <body pos="-0.009 0 {height + 0.002}"><joint type="slide" axis="0 0 1"/>
        <geom name="ball" size="0.01" mass="{mass}"/></body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    feel = ff.mujoco.couple(model, "finger", {"ball": ff.shapes.Sphere(10)}, tip)
    flights: list[list[float]] = [[]]
    for _ in range(round(seconds / step)):
        touch = feel.step(data)
        if not touch.wrench.any():
            speed, place = data.qvel[0], data.qpos[0]
            flights[-1].append(mass * (speed**2 / 2 + GRAVITY * (place + 0.002)))
        elif flights[-1]:
            flights.append([])
        mujoco.mj_step(model, data)
    return [float(np.mean(each)) for each in flights[:-1] if len(each) > 5]  # whole flights


def test_an_elastic_pad_gives_a_ball_its_energy_back() -> None:
    energy = bounces(ff.TactileFinger(ELASTIC, finite_strain=False, deepest=2.0))
    assert len(energy) >= 5
    assert np.ptp(energy[1:]) < 0.01 * energy[1]
    assert energy[1] == pytest.approx(energy[0], rel=0.02)


def test_a_viscous_pad_takes_energy_from_a_ball() -> None:
    energy = bounces(ff.TactileFinger(VISCOUS, finite_strain=False, deepest=2.0))
    assert len(energy) >= 2
    assert (np.diff(energy) < 0).all()
    assert energy[1] < 0.6 * energy[0]


def test_two_fingers_hold_a_cube_at_a_fifth_more_than_the_least_force() -> None:
    friction, mass = 0.6, 0.02
    tips = [ff.TactileFinger(VISCOUS, friction=friction, finite_strain=False) for _ in range(2)]
    away, grip = 0.01 + lowest(tips[0]), 1.2 * mass * GRAVITY / (2 * friction)
    finger = """<body name="{name}" pos="{x} 0 0.009" quat="{turn}" gravcomp="1">
        <joint type="slide" axis="0 0 -1" damping="4" name="{name}"/>
        <geom size="0.001" mass="0.02" contype="0" conaffinity="0"/></body>"""
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="1e-3" gravity="0 0 -{GRAVITY}"/><worldbody>
        {finger.format(name="right", x=away, turn=quaternion([0, 0, 1], [0, -1, 0]))}
        {finger.format(name="left", x=-away, turn=quaternion([0, 0, 1], [0, 1, 0]))}
        <body name="cube"><freejoint/><geom name="cube" type="box" size="0.01 0.01 0.01"
        mass="{mass}" contype="0" conaffinity="0"/></body></worldbody>
        <actuator><motor joint="right"/><motor joint="left"/></actuator></mujoco>"""
    )
    data, cube = mujoco.MjData(model), ff.shapes.Box(20, 20, 20, edge=0.3)
    feel = [
        ff.mujoco.couple(model, each, {"cube": cube}, tip)
        for each, tip in zip(("right", "left"), tips, strict=True)
    ]
    model.opt.gravity[2], height = 0.0, []
    for k in range(round(1e3 * HELD)):
        data.ctrl[:] = grip * min(k / 100, 1.0)
        model.opt.gravity[2] = -GRAVITY * np.clip((k - 150) / 150, 0.0, 1.0)
        touches = [each.step(data) for each in feel]
        mujoco.mj_step(model, data)
        height.append(1e3 * data.body("cube").xpos[2])
    assert all(touch.valid for touch in touches)
    assert [touch.wrench[0, 2] for touch in touches] == pytest.approx([grip] * 2, rel=0.02)
    upward = sum(-touch.wrench[0, 0] for touch in touches)
    assert upward == pytest.approx(mass * GRAVITY, rel=0.02)
    assert -1.2 < height[-1] < -0.1  # the pads shear
    assert abs(height[-1] - height[-300]) < 0.05  # and creep, but nothing slips
    assert all(touch.stick_area[0] > 0.5 * touch.contact_area[0] for touch in touches)


def quaternion(x: list[int], y: list[int]) -> str:
    """Return the quaternion of a frame by its x and y axes."""
    turn, found = np.column_stack([x, y, np.cross(x, y)]).astype(float), np.zeros(4)
    mujoco.mju_mat2Quat(found, turn.ravel())
    return " ".join(map(str, found))


def test_a_cylinder_rolls_at_half_the_speed_of_the_finger() -> None:
    tip = ff.TactileFinger(VISCOUS, friction=0.6, finite_strain=False)
    radius, speed = 0.006, 0.01
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="1e-3" cone="elliptic" impratio="10"/><worldbody>
        <geom type="plane" size="0.2 0.2 0.01" friction="1 0.005 0.0001"/>
        <body name="finger" pos="0.004 0 {2 * radius + lowest(tip)}" gravcomp="1">
        <joint name="down" type="slide" axis="0 0 1" damping="5"/>
        <joint name="side" type="slide" axis="0 1 0"/>
        <geom size="0.001" mass="0.05" contype="0" conaffinity="0"/></body>
        <body name="roller" pos="0 0 {radius}"><freejoint/>
        <geom name="roller" type="cylinder" size="{radius} 0.02" mass="0.02"
        quat="0.70710678 0 0.70710678 0" friction="1 0.005 0.0001"/></body></worldbody>
        <contact><exclude body1="finger" body2="roller"/></contact>
        <actuator><motor joint="down"/><velocity joint="side" kv="50"/></actuator></mujoco>"""
    )
    data = mujoco.MjData(model)
    feel = ff.mujoco.couple(model, "finger", {"roller": ff.shapes.Cylinder(6, 40)}, tip)
    places = []
    for k in range(700):
        data.ctrl[:] = -0.5 * min(k / 100, 1.0), speed * np.clip((k - 200) / 100, 0.0, 1.0)
        feel.step(data)
        mujoco.mj_step(model, data)
        places.append((data.body("roller").xpos[1], data.body("finger").xpos[1]))
    rolled, moved = np.array(places[-1]) - places[400]
    assert moved > 0.002
    assert rolled / moved == pytest.approx(0.5, rel=0.05)


MODEL = """<mujoco><worldbody><body name="finger"><freejoint/><geom name="tip" size="0.001" {}/>
<site/></body><body name="other" pos="0 0 1"><freejoint/><geom name="ball" size="0.01"/></body>
</worldbody></mujoco>"""


def test_what_cannot_be_coupled_is_refused() -> None:
    tip, ball = ff.TactileFinger(VISCOUS, finite_strain=False), {"ball": ff.shapes.Sphere(10)}
    model = mujoco.MjModel.from_xml_string(MODEL.format('contype="0" conaffinity="0"'))
    with refused("body"):
        ff.mujoco.couple(model, "thumb", ball, tip)
    with refused("geom"):
        ff.mujoco.couple(model, "finger", {"bell": ff.shapes.Sphere(10)}, tip)
    colliding = mujoco.MjModel.from_xml_string(MODEL.format(""))
    with refused("geoms"):
        ff.mujoco.couple(colliding, "finger", ball, tip)
    for field, given in (
        ("model", (None, "finger", ball, tip)),
        ("body", (model, 1, ball, tip)),
        ("geoms", (model, "finger", {"ball": 10.0}, tip)),
        ("geoms", (model, "finger", {}, tip)),
        ("finger", (model, "finger", ball, VISCOUS)),
    ):
        with refused(field):
            # Arguments of other classes, which are what is refused.
            ff.mujoco.couple(*given)  # type: ignore[arg-type]
    with refused("geoms"):
        ff.mujoco.couple(model, "finger", ball, tip, place=[0.0, 0.0])
    many = ff.TactileFinger(VISCOUS, finite_strain=False, worlds=2)
    with pytest.raises(InputError, match="single world"):
        ff.mujoco.couple(model, "finger", ball, many)


def test_applied_forces_of_others_stay_and_the_finger_bears_the_reaction() -> None:
    tip = ff.TactileFinger(VISCOUS, finite_strain=False)
    model = mujoco.MjModel.from_xml_string(MODEL.format('contype="0" conaffinity="0"'))
    data = mujoco.MjData(model)
    feel = ff.mujoco.couple(model, "finger", {"ball": ff.shapes.Sphere(10)}, tip)
    data.xfrc_applied[:] = 0.5
    for down in (0.0, 0.0005, 0.001):
        data.qpos[7:10] = -0.006, 0.0, -lowest(tip) - 0.01 + down
        touch = feel.step(data)
    own, other = data.xfrc_applied[1:] - 0.5
    assert np.allclose(own[:3], touch.wrench[0, :3], atol=1e-12)
    assert np.allclose(own[:3], -other[:3], atol=1e-12)
    arm = data.xipos[2] - data.xipos[1]  # both about one point
    assert np.allclose(own[3:], -(other[3:] + np.cross(arm, other[:3])), atol=1e-12)
    assert np.allclose(feel.taxels, touch.taxels)
    data.qpos[9] = -1.0
    feel.step(data)
    assert np.allclose(data.xfrc_applied[1:], 0.5, atol=1e-12)
