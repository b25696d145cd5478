"""A finger in time: the hand, presets, refused steps, and records that a run repeats."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.live.picture import Picture
from fefinger.live.player import ABOVE, OBJECTS, PRESETS, Player, Setup, population_sites
from fefinger.mechanics.press.problem import Press
from fefinger.mechanics.press.tabulated_press import METHOD
from fefinger.support.progress import Stages
from fefinger.support.vocabulary import Control


DEPTH, FORCE = Control.DEPTH, Control.FORCE


def play(player: Player, seconds: float) -> np.ndarray:
    """Step for some s of the model; return time, depth and force of the steps."""
    end = player.time + seconds - 1e-9
    while player.time < end:
        player.step()
    return player.heard().trace


def test_the_object_follows_the_hand_without_overshoot(player: Player) -> None:
    player.move(DEPTH, 0.8)
    depth = play(player, 0.5)[:, 1]
    assert depth[0] == pytest.approx(ABOVE, abs=0.01)
    assert depth.max() <= 0.8 + 1e-12
    assert depth[-1] == pytest.approx(0.8, abs=1e-9)
    assert np.diff(depth).min() > -1e-12


def test_the_other_control_goes_on_from_where_the_object_is(player: Player) -> None:
    player.move(DEPTH, 0.8)
    before = play(player, 0.3)[-1]
    player.move(FORCE, before[2] / 2)
    trace = play(player, 0.5)
    assert trace[0] == pytest.approx(before, abs=0.02)
    assert trace[-1, 2] == pytest.approx(before[2] / 2)


def test_what_is_beyond_reach_is_taken_as_the_last_that_is_not(player: Player) -> None:
    for control in (DEPTH, FORCE):
        player.move(control, 99.0)
        assert player.target == pytest.approx(player.most[control])


def test_a_refused_step_leaves_the_finger_as_it_was(player: Player) -> None:
    player.move(FORCE, 0.3)
    before = play(player, 0.3)[-1]
    player.value = player.target = 99.0
    with refused("step"):
        player.step()
    now = player.loop.now
    assert (player.time, now.depth, now.force) == pytest.approx(tuple(before))
    after = play(player, 0.1)
    assert after[:, 1] == pytest.approx(before[1])  # it rests at its depth


@pytest.mark.parametrize(
    ("name", "control"), [*((name, DEPTH) for name in PRESETS), ("tap", FORCE), ("40 Hz", FORCE)]
)
def test_a_preset_ends_and_lifts_off(player: Player, name: str, control: Control) -> None:
    player.move(control, 0.0)
    player.play(name)
    steps = 0
    while player.playing and steps < 20_000:
        player.step()
        steps += 1
    trace = player.heard().trace
    level = 0.5 * player.most[control]
    assert trace[:, control.of(1, 2)].max() == pytest.approx(level, rel=0.12)
    assert trace[:, 2].max() > 0.0
    if name == "250 Hz":
        assert np.diff(trace[-200:, 0]) == pytest.approx(0.25e-3, abs=1e-9)
    assert play(player, 0.6)[-1, 2] == pytest.approx(0.0, abs=1e-9)


def test_spikes_are_of_the_clock_of_the_trace(player: Player) -> None:
    player.play("tap")
    for _ in range(400):
        player.step()
    heard = player.heard()
    assert {player.units.types[unit] for unit, _ in heard.spikes} >= {"FAI", "FAII"}
    times = [at for _, at in heard.spikes]
    first = heard.trace[np.argmax(heard.trace[:, 2] > 0), 0]
    assert first - 1e-3 < min(times) < max(times) < player.time
    assert player.heard().spikes == ()


@pytest.mark.parametrize("control", [DEPTH, FORCE])
def test_a_record_is_repeated_by_a_run(player: Player, control: Control) -> None:
    player.move(control, 0.0)
    player.record()
    player.move(control, 0.5 * player.most[control])
    played = play(player, 0.2)
    player.recording = False
    play(player, 0.05)
    take = player.take
    assert take is not None
    assert take.seconds == pytest.approx(0.2)
    scene = take.scene("played", "coarse")
    assert scene.motion.control is control
    assert ff.Scene.from_toml(scene.to_toml()) == scene  # exact: what is written is read
    quick = replace(scene, ask=ff.Ask(fields=False, strain=False, mechanics="pressed"))
    result = ff.run(quick)
    assert result.force.max() == pytest.approx(played[:, 2].max(), rel=0.02)
    assert result.depth.max() == pytest.approx(played[:, 1].max(), rel=0.02)


def test_a_record_without_contact_is_no_scene(player: Player) -> None:
    player.record()
    play(player, 0.01)
    with pytest.raises(ff.InputError, match="touch"):
        player.take.scene("air", "coarse")


def test_a_picture_shows_the_present_finger(player: Player) -> None:
    picture = Picture(player.loop)
    shape = picture.shape().table
    count = shape["vertices"]
    player.rest()

    def read() -> tuple[np.ndarray, ...]:
        values = np.frombuffer(picture.frame(), "<f4")
        return np.split(values, np.cumsum([3 * count, count, count]))

    rest, strain, pressure, _ = read()
    assert not strain.any()
    assert not pressure.any()
    player.move(DEPTH, 1.0)
    play(player, 0.5)
    places, strain, pressure, others = read()
    assert len(others) == 3 * (shape["lineCount"] + len(shape["labels"]))
    assert pressure.max() == pytest.approx(player.loop.now.pressure.max(), rel=1e-6)
    axis = np.array(shape["indenter"]["axis"])
    ahead = rest.reshape(-1, 3) @ axis
    touching = pressure > 0.2 * pressure.max()
    pressed = places.reshape(-1, 3)[touching] @ axis - ahead.min()
    assert pressed == pytest.approx(1.0, abs=0.08)  # coarse facets
    assert 10.0 < strain.max() < 100.0
    assert shape["fields"]["pressure"]["high"] > 0.0


@pytest.mark.parametrize("kind", OBJECTS)
@pytest.mark.parametrize("along", [False, True])
def test_objects_are_symmetric_so_that_half_a_finger_does(kind: str, along: bool) -> None:
    indenter = Setup(kind=kind, along=along).indenter
    assert indenter.mirrored
    assert indenter.kind == {"plate": "flat", "ball": "sphere"}.get(kind, kind)


def test_a_population_is_placed_as_in_a_run() -> None:
    setup = Setup(units="population", angle=0.0)
    found = population_sites(setup, "coarse")
    scene = ff.Scene(
        finger=setup.finger("coarse"),
        indenter=setup.indenter,
        motion=ff.Ramp(10, 1.5),
        ask=setup.ask,
    )
    press = Press.of(scene, METHOD, Stages(None), mechanics="pressed", notes=())
    assert press.sites is not None
    assert found.points == pytest.approx(press.sites.points, abs=1e-9)
    assert found.types == press.sites.types
    assert found.unit.tolist() == press.sites.unit.tolist()
    assert 200 < len(set(found.unit.tolist())) < 400
