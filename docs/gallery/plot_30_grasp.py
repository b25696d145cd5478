"""
A grasp as a Gymnasium environment
==================================

Two fingertips hold a cube whose weight nobody told them. The action is the force of the grip; the
observation is what the skin feels: forces on taxels, wrenches, how much of the contact sticks, and
spikes. MuJoCo moves the bodies, `ff.TactileFinger <../simulator.html>`_ is the touch.
"""

import tempfile
from pathlib import Path

import gymnasium as gym
import matplotlib.pyplot as plt
import mujoco
import numpy as np
from gymnasium.spaces import Box, Dict
from gymnasium.utils.env_checker import check_env

import fefinger as ff
from fefinger.view.pictures import write


TYPES = "SAI", "SAII", "FAI", "FAII"
finger = """<body name="{0}" pos="{1} 0 0" xyaxes="{2} 0 .866 0 {3} 0" gravcomp="1">
    <joint name="{0}" type="slide" axis=".5 0 -.866" damping="4"/>
    <geom size=".001" mass=".02" contype="0" conaffinity="0"/></body>"""
scene = f"""<mujoco><option timestep="2e-3"/><worldbody>
    {finger.format("left", -0.01, 0.5, 1)} {finger.format("right", 0.01, -0.5, -1)}
    <body name="cube"><freejoint/><geom name="cube" type="box" size=".01 .01 .01"
    contype="0" conaffinity="0"/></body></worldbody>
    <actuator><motor joint="left"/><motor joint="right"/></actuator></mujoco>"""


class Grasp(gym.Env):
    """Hold a cube of 15 to 40 g for 0.6 s with the least force, in N, in steps of 10 ms."""

    action_space = Box(0, 1, (1,))

    def __init__(self):
        self.model = mujoco.MjModel.from_xml_string(scene)
        self.data, cube = mujoco.MjData(self.model), {"cube": ff.shapes.Box(20, 20, 20, edge=0.3)}
        soft = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
        units = ff.Grid(spacing=2.5, branched=False)  # one end organ each
        options = {"friction": 0.6, "finite_strain": False, "population": units}
        options["taxels"] = ff.TaxelGrid(10, 7, pitch=1.5, center=(0, 0))
        self.tips = [ff.TactileFinger(soft, **options) for _ in range(2)]
        self.feel = [
            ff.mujoco.couple(self.model, side, cube, tip)
            for side, tip in zip(("left", "right"), self.tips, strict=True)
        ]
        self.types = np.array(self.tips[0].units.types)
        self.observation_space = Dict(
            taxels=Box(-5, 5, (2, 70, 3)),  # N
            wrench=Box(-50, 50, (2, 6)),  # N, N mm
            stick=Box(0, 1, (2,)),  # share of the area of contact
            spikes=Box(0, 10_000, (2, 4), np.int64),  # by type, in this step
        )

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        cube, mass = self.model.body("cube"), self.np_random.uniform(0.015, 0.04)
        cube.mass[:], cube.inertia[:] = mass, mass * 0.02**2 / 6
        mujoco.mj_setConst(self.model, self.data)
        mujoco.mj_resetData(self.model, self.data)
        for feel in self.feel:
            feel.reset()
            feel.finger.units.reset()
        return self.advance(0.1), {"mass": mass}

    def step(self, action):
        grip = float(action[0])
        felt, height = self.advance(grip), 1e3 * self.data.body("cube").xpos[2]
        fell = height < -3 or not all(feel.touch.valid for feel in self.feel)
        return felt, -1.0 if fell else 0.01 * (1 - grip), fell, self.data.time > 0.599, {}

    def advance(self, grip):
        self.data.ctrl[:], self.fired = grip, [[], []]
        for _ in range(5):  # the hand that holds out the cube lets go from 0.1 to 0.3 s
            self.model.opt.gravity[2] = -9.81 * np.clip((self.data.time - 0.1) / 0.2, 0, 1)
            for feel, fired in zip(self.feel, self.fired, strict=True):
                feel.finger.units.step(feel.step(self.data).strain, 2e-3)
                fired += feel.finger.units.fired()
            mujoco.mj_step(self.model, self.data)
        touch = [feel.touch for feel in self.feel]
        area = [max(each.contact_area[0], 1e-9) for each in touch]
        counts = [
            [sum(self.types[i] == kind for i, _ in each) for kind in TYPES] for each in self.fired
        ]
        return {
            "taxels": np.array([each.taxels for each in touch], np.float32),
            "wrench": np.array([each.wrench[0] for each in touch], np.float32),
            "stick": np.array(
                [t.stick_area[0] / a for t, a in zip(touch, area, strict=True)], np.float32
            ),
            "spikes": np.array(counts),
        }


env = Grasp()
check_env(env, skip_render_check=True)


def episode(name, policy):
    """Hold the cube by a policy; return time, grip, observation and spikes of each step."""
    (felt, _), grip, total, over, film = env.reset(seed=5), 0.1, 0.0, False, []
    while not over:
        grip = float(np.clip(policy(grip, felt), 0, 1))
        felt, reward, fell, late, _ = env.step(np.array([grip], np.float32))
        total, over = total + reward, fell or late
        film.append((env.data.time, grip, felt, env.fired))
    print(f"{name}: {'dropped' if fell else 'held'} at {grip:.2f} N, reward {total:.2f}")
    return film


episode("weak", lambda grip, felt: 0.1)
episode("firm", lambda grip, felt: 0.8)
# A reflex: tighten while less than 70 % of the contact sticks, else loosen slowly.
film = episode("reflex", lambda grip, felt: grip + (0.02 if min(felt["stick"]) < 0.7 else -0.001))


# %%
# The film of the reflex, five times slower than life: forces on the taxels of the pads, seen from
# the cube with the fingertips up, and the shear of the skin as arrows; the spikes of both fingers;
# the grip, and dotted the least that holds this cube.
def pictures(film):
    """Yield a picture (height, width, 3) of every second step."""
    fig = plt.figure(figsize=(7.2, 3), dpi=100, layout="constrained")
    axes = fig.subplot_mosaic("lrs;lrg", width_ratios=[1, 1, 2])
    times, grips = np.array([step[:2] for step in film]).T
    taxels = 1e3 * np.array([felt["taxels"] for _, _, felt, _ in film])  # mN
    distal, across = (each.reshape(10, 7) for each in env.tips[0].taxels.places.T)
    most, pads = taxels[..., 2].max(), []
    for hand, name in (("l", "left"), ("r", "right")):
        force = axes[hand].pcolormesh(across, distal, 0 * across, cmap="magma", vmin=0, vmax=most)
        shear = axes[hand].quiver(across, distal, across, distal, color="c", scale=80, width=0.015)
        axes[hand].set(title=f"{name}, to {most:.0f} mN", aspect="equal", xticks=[], yticks=[])
        pads.append((force, shear))
    fired = [(env.types[unit], at) for *_, spikes in film for unit, at in spikes[0] + spikes[1]]
    rows = [(kind, axes["s"].plot([], [], "|", markersize=12)[0]) for kind in TYPES]
    axes["s"].set(yticks=range(4), yticklabels=TYPES, xlim=(0, 0.6), ylim=(3.6, -0.6))
    (line,) = axes["g"].plot([], [])
    axes["g"].axhline(9.81 * env.model.body("cube").mass[0] / 2 / 0.6, color="gray", ls=":")
    axes["g"].set(xlabel="time / s", ylabel="grip / N", xlim=(0, 0.6), ylim=(0, 0.4))
    for k in range(0, len(film), 2):
        for (force, shear), each in zip(pads, taxels[k], strict=True):
            force.set_array(each[:, 2])
            shear.set_UVC(each[:, 1], each[:, 0])
        for number, (kind, row) in enumerate(rows):
            past = [at for each, at in fired if each == kind and at <= times[k]]
            row.set_data(past, np.full(len(past), number))
        line.set_data(times[: k + 1], grips[: k + 1])
        fig.canvas.draw()
        fig.set_layout_engine("none")  # that of the first picture stays
        yield np.array(fig.canvas.buffer_rgba())[..., :3]
    plt.close(fig)


file = Path(tempfile.mkdtemp(), "grasp.gif")
write(file, pictures(film), fps=10)
