"""An indenter of the user's own: a class with a surface, from Python, a plugin and a saved result.

Its answers are held against the package's own object of the same shape.
"""

import math
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner
from numpy.testing import assert_allclose

import fefinger as ff
from fefinger.commands.cli import cli
from fefinger.geometry import profiles
from fefinger.mechanics.press import depth_table
from fefinger.scene.indenters import INDENTERS
from fefinger.scene.schema import column, schema
from fefinger.studies import tasks
from fefinger.support.checks import InputError


@dataclass(frozen=True)
class Slab(ff.Indenter):
    """A bar, by a function of its heights."""

    width: Annotated[float, ff.Key("Width over all", unit="mm", above=0)]
    corner: float
    roll: float = 0.0
    at: tuple[float, float] | None = None

    def surface(self, x, y):
        """Heights of the bar."""
        return -profiles.Bar(self.width, self.corner).height(np.stack([x, y], axis=-1))[0]


@dataclass(frozen=True)
class Marble(ff.Indenter):
    """A ball of 4 mm, with its gradient."""

    at: tuple[float, float] | None = None
    sharp = False

    def surface(self, x, y):
        """Heights of the ball over its middle."""
        return 3 - profiles.Ellipsoid((4.0,) * 3).height(np.stack([x, y], axis=-1))[0]

    def gradient(self, x, y):
        """Slopes of the ball."""
        slope = profiles.Ellipsoid((4.0,) * 3).height(np.stack([x, y], axis=-1))[1]
        return -slope[..., 0], -slope[..., 1]


PLUGIN = '''
from dataclasses import dataclass
from typing import Annotated
import numpy as np
import fefinger as ff

@dataclass(frozen=True)
class KeyEdge(ff.Indenter):
    """The edge of a key."""

    radius: Annotated[float, ff.Key("Radius of the edge", unit="mm", above=0)] = 0.5
    roll: float = 0.0

    def surface(self, x, y):
        return self.radius - np.hypot(x, self.radius)
'''

SCENE = """
plugins = ["my_objects"]
[finger]
subject = "a.h."
resolution = "coarse"
[indenter]
kind = "key-edge"
radius = 0.8
[motion]
kind = "ramp"
speed = 10
depth = 0.5
[ask]
fields = false
"""


@pytest.fixture(autouse=True)
def _own_modules(own_registry: None, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Forget what a test registers and imports."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    yield
    sys.modules.pop("my_objects", None)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "my_objects.py").write_text(PLUGIN)
    (tmp_path / "mine.toml").write_text(SCENE)
    return tmp_path


def press(indenter: ff.Indenter, motion: Any = None, **ask: Any) -> ff.Scene:
    return ff.Scene(
        finger=ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998"),
        indenter=indenter,
        motion=motion or ff.Ramp(20, 0.6),
        ask=ff.Ask(fields=False, **ask),
    )


# What an object answers


def test_an_object_answers_as_the_one_of_the_package_with_its_shape() -> None:
    own, bar = Slab(3.0, 0.5, roll=20), ff.Bar(3.0, 0.5, roll=20)
    assert (own.kind, own.sharp, own.turn, own.place) == ("slab", True, 20, None)
    assert own.least_radius == pytest.approx(bar.least_radius, rel=0.02)
    assert own.describe() == "a rigid slab (width 3 mm, corner 0.5)"
    assert Marble().least_radius == pytest.approx(4.0, rel=1e-3)
    assert own.moved((1.0, 2.0)).place == (1.0, 2.0)


def test_derivatives_by_differences_are_those_of_the_profile() -> None:
    rng = np.random.default_rng(1)
    places = rng.uniform(-3.0, 3.0, (500, 2))
    for own, exact in (
        (Slab(3.0, 0.5), profiles.Bar(3.0, 0.5)),
        (Marble(), profiles.Ellipsoid((4.0,) * 3)),
    ):
        for got, wanted in zip(own.profile.height(places), exact.height(places), strict=True):
            scale = 1 + np.abs(wanted).max()
            close = np.abs(got - wanted) < 1e-5 * scale
            assert close.mean() > 0.995  # but where an arc begins within a step
            assert np.abs(got - wanted).max() < 3.0 * scale
        assert_allclose(own.profile.rise(places), own.profile.height(places)[0])
        assert_allclose(own.profile.incline(places), own.profile.height(places)[1])


@dataclass(frozen=True)
class Lopsided(ff.Indenter):
    """A bowl whose sides differ along y."""

    roll: float = 0.0

    def surface(self, x, y):
        """Heights of the bowl."""
        return -(x**2) / 5 - y**2 / 5 - 0.02 * y**3 / (1 + y**2)


@pytest.mark.parametrize(("roll", "mirrored"), [(0.0, False), (90.0, True), (180.0, False)])
def test_half_a_finger_is_enough_for_a_shape_that_is_its_mirror_image(
    roll: float, mirrored: bool
) -> None:
    assert Lopsided(roll).mirrored == mirrored
    assert Slab(3.0, 0.5, roll=roll).mirrored
    assert not Slab(3.0, 0.5, roll=30.0).mirrored


@pytest.mark.parametrize(
    "body",
    [
        "def __post_init__(self): 1 / 0",
        "def gradient(self, x, y): return 5",
        "depth: 'Nothing' = 5.0",
        "def surface(self, x, y): return 1j * x",
        "def surface(self, x, y): raise SystemExit(4)",
    ],
)
def test_a_class_that_fails_is_an_error_of_the_scene(folder: Path, body: str) -> None:
    (folder / "my_objects.py").write_text(f"{PLUGIN}\n    {body}\n")
    answer = CliRunner().invoke(cli, ["explain", str(folder / "mine.toml")])
    assert isinstance(answer.exception, InputError)


# Mechanics


MECHANICS = [
    pytest.param("linear", None, id="linear"),
    pytest.param("condensed", None, id="condensed"),
    pytest.param("pressed", None, id="pressed"),
    pytest.param(
        "condensed", ff.Slide(20, 0.4, distance=2.0, settle=0.05), id="condensed, sliding"
    ),
]


@pytest.mark.parametrize(("mechanics", "motion"), MECHANICS)
def test_every_mechanics_answers_as_under_the_object_of_the_package(
    mechanics: str,
    motion: Any,
    operators: Path,
    request: pytest.FixtureRequest,
) -> None:
    if mechanics == "pressed":
        request.getfixturevalue("few_depths")
    pairs = [(Slab(3.0, 0.6), ff.Bar(3.0, 0.6)), (Marble(), ff.Sphere(4.0))]
    own, known = pairs[mechanics == "linear"]
    got, wanted = (ff.run(press(each, motion), mechanics=mechanics) for each in (own, known))
    peak = float(wanted.force.max())
    assert_allclose(got.force, wanted.force, atol=1e-5 * peak)
    assert_allclose(got.strain, wanted.strain, atol=1e-5 * float(np.abs(wanted.strain).max()))


def test_the_error_of_an_unknown_object_is_said_to_be_unknown() -> None:
    with pytest.raises(InputError, match=r"name (pressed|solid) .*error here is not known"):
        ff.explain(press(Slab(3.0, 0.6)))
    result = ff.run(press(Slab(3.0, 0.6)), mechanics="linear")
    assert "not known" in str(result)
    assert "slab" in result.scene.indenter.describe()


def test_a_table_of_presses_knows_the_heights() -> None:
    """Another function under the same name and fields must not read it."""

    def table(steepness: float) -> str:
        @dataclass(frozen=True)
        class Same(ff.Indenter):
            def surface(self, x, y):
                return -steepness * x**2

        Same.__qualname__ = "Same"
        return depth_table.key(ff.Finger.subject("a.h."), Same(), "")

    assert table(0.1) == table(0.1) != table(0.2)


def test_a_stored_answer_of_a_study_knows_the_code_of_a_plugin(folder: Path) -> None:
    def key() -> str:
        task = {"scene": ff.Scene.from_toml(folder / "mine.toml").to_dict()}
        return tasks.key(task)

    first = key()
    assert key() == first
    (folder / "my_objects.py").write_text(PLUGIN.replace("hypot(x", "hypot(2 * x"))
    assert key() != first


# Scene files


def test_a_plugin_is_read_beside_its_scene(folder: Path) -> None:
    scene = ff.Scene.from_toml(folder / "mine.toml")
    assert type(scene.indenter).__name__ == "KeyEdge"
    assert (scene.indenter.radius, scene.plugins) == (0.8, ("my_objects",))
    assert ff.Scene.from_toml(scene.to_toml()) == scene  # exact: TOML has every digit
    tables = tomllib.loads(SCENE)
    jsonschema.Draft7Validator(schema()).validate(tables)
    tables["indenter"]["radius"] = 0
    assert not jsonschema.Draft7Validator(schema()).is_valid(tables)
    assert column("indenter.radius") == "indenter.radius_mm"


def test_a_scene_names_the_module_of_its_object_itself(folder: Path) -> None:
    object_ = ff.Scene.from_toml(folder / "mine.toml").indenter
    scene = press(object_)
    assert scene.plugins == ("my_objects",)
    assert ff.Scene.from_toml(scene.to_toml()) == scene  # exact: TOML has every digit
    assert press(ff.Flat()).plugins == ()


def test_a_saved_result_loads_its_plugin_in_another_process(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = ff.run(folder / "mine.toml", mechanics="linear")
    result.save(folder / "out")
    INDENTERS._things.pop("key-edge")
    del sys.modules["my_objects"]
    sys.path.remove(str(folder))
    with pytest.raises(InputError, match=r"plugins: expected a module.*received 'my_objects'"):
        ff.load(folder / "out")
    monkeypatch.chdir(folder)
    again = ff.load(folder / "out")
    assert again.scene.indenter.describe() == result.scene.indenter.describe()
    assert_allclose(again.force, result.force)


def test_the_command_line_knows_it(folder: Path) -> None:
    asked = CliRunner().invoke(cli, ["explain", str(folder / "mine.toml")])
    assert "its error here is not known: no press like it was measured" in str(asked.exception)
    written = CliRunner().invoke(cli, ["scenes", str(folder / "mine.toml"), "--schema"])
    assert '"key-edge"' in written.output


def bad(body: str) -> str:
    """Return a plugin whose surface has another body."""
    return PLUGIN.replace("return self.radius - np.hypot(x, self.radius)", body)


BAD = [
    pytest.param(
        "import nothing_there", "'my_objects' failed with ModuleNotFound", id="import fails"
    ),
    pytest.param("raise RuntimeError('no')", "RuntimeError: no", id="code fails"),
    pytest.param("x = 1", "expected one of .*received 'key-edge'", id="no such class"),
    pytest.param(bad("return -np.sqrt(25 - x**2)"), "surface: expected finite", id="not finite"),
    pytest.param(
        bad("return -abs(x - 0.013)"), "smooth surface.*8[0-9] degrees at once", id="kink"
    ),
    pytest.param(bad("return x**2"), "largest value within 10 mm.*change their sign", id="bowl"),
    pytest.param(bad("import math; return math.sqrt(x)"), "functions of NumPy", id="no arrays"),
    pytest.param(bad("return x[:2]"), "returns a height for each place", id="shape"),
    pytest.param(
        PLUGIN.replace("@dataclass(frozen=True)", ""),
        "expected a dataclass.*'radius'",
        id="no decorator",
    ),
    pytest.param(
        PLUGIN.replace("surface", "surfaces"), "a class with a method surface", id="no surface"
    ),
    pytest.param(
        PLUGIN + "\n    def gradient(self, x, y):\n        return x, y\n",
        "gradient: expected the derivatives",
        id="wrong gradient",
    ),
]


@pytest.mark.parametrize(("text", "message"), BAD)
def test_a_plugin_that_cannot_be_used_gets_a_sentence(
    tmp_path: Path, text: str, message: str
) -> None:
    (tmp_path / "my_objects.py").write_text(text)
    (tmp_path / "mine.toml").write_text(SCENE.replace("radius = 0.8", ""))
    with pytest.raises(InputError, match=message) as refused:
        ff.Scene.from_toml(tmp_path / "mine.toml")
    assert "\n" not in str(refused.value)


def test_no_code_runs_but_what_the_scene_itself_names(folder: Path) -> None:
    (folder / "tissue.toml").write_text('plugins = ["my_objects"]\n')
    text = SCENE.replace('plugins = ["my_objects"]', "").replace('"key-edge"', '"flat"')
    text = text.replace("radius = 0.8", "")
    text = text.replace("[finger]", '[finger]\ntissue = "tissue.toml"')
    (folder / "other.toml").write_text(text)
    with pytest.raises(InputError, match="plugins"):
        ff.Scene.from_toml(folder / "other.toml")
    assert "my_objects" not in sys.modules


@dataclass(frozen=True)
class Folded(ff.Indenter):
    """A plane that is folded by 6 degrees."""

    fold: float

    def surface(self, x, y):
        """Heights of the plane."""
        return -math.tan(math.radians(6.0)) * np.maximum(x - self.fold, 0.0)


def test_a_kink_is_found_wherever_it_lies() -> None:
    for place in np.random.default_rng(3).uniform(-8.0, 8.0, 10).tolist():
        with pytest.raises(
            InputError, match=r"turns by some \d+ degrees at once at x = " + f"{place:.4g}"
        ):
            Folded(place)
