"""A finite-element fingertip: force, pressure, strain and nerve spikes of a touch.

    import fefinger as ff
    result = ff.run("flat-press")  # a built-in scene, a TOML file or a ff.Scene
    print(result)  # the numbers that matter, with their expected errors

answer      run, explain (which mechanics, how good), study (a grid), receptive_field, load
spikes      spikes(time, displacement) of a series of your own; SpikeTrains, neural.psth and others
scene       Scene(finger=, indenter=, motion=, ask=)
finger      Finger.subject("a.h."), Finger(width=, thickness=), Finger.from_surface("scan.stl")
indenter    Flat, Sphere, Pin, Bar, Cylinder, Ellipsoid, Grating, Dots, Braille, Letters, Fabric,
            Relief
motion      RampHold(speed=, depth=, hold=) or, by force, (loading_rate=, force=, hold=); Slide, ...
ask         Ask(spikes=("SAI",), rel_error=0.05, population=Scatter(), Grid, Line or Places)
loop        Loop(finger, indenter): one step of your own at a time; Vibrations(finger, indenter)
extension   register(thing): an indenter, a law, afferents or a mechanics of your own, by its name
own tissue  calibrate("press.csv", finger=Finger(width=15, thickness=11))

Lengths are in mm, times in s, pressures in kPa, forces in N; x is distal, z dorsal.
Public names are imported at first use, so that importing the package is cheap.
"""

from fefinger.support import VERSION


TYPE_CHECKING = False  # that of typing, whose import Ctrl-C would end with a traceback
if TYPE_CHECKING:
    from typing import Any

    from fefinger import shapes as shapes
    from fefinger.calibration.calibrate import calibrate as calibrate
    from fefinger.calibration.record import Calibration as Calibration
    from fefinger.calibration.rig import Rig as Rig
    from fefinger.fem.hyperelastic.continuum import check_law as check_law
    from fefinger.laws import Law as Law
    from fefinger.mechanics import Mechanics as Mechanics
    from fefinger.mechanics.former_loops import Condensed as Condensed
    from fefinger.mechanics.former_loops import Modal as Modal
    from fefinger.mechanics.former_loops import Pressed as Pressed
    from fefinger.mechanics.former_loops import Rolling as Rolling
    from fefinger.mechanics.former_loops import Sliding as Sliding
    from fefinger.mechanics.loop import Loop as Loop
    from fefinger.mechanics.press.tactile_parts import TaxelGrid as TaxelGrid
    from fefinger.mechanics.tactile_finger import TactileFinger as TactileFinger
    from fefinger.mechanics.vibrations import Vibrations as Vibrations
    from fefinger.neural.family import Family as Family
    from fefinger.neural.series import spikes as spikes
    from fefinger.neural.trains import SpikeTrains as SpikeTrains
    from fefinger.pipeline import run as run
    from fefinger.plan import choose as choose
    from fefinger.plan import explain as explain
    from fefinger.result import Result as Result
    from fefinger.result import load as load
    from fefinger.results.result_record import Plan as Plan
    from fefinger.scene.ask import Ask as Ask
    from fefinger.scene.ask import Fingertip as Fingertip
    from fefinger.scene.ask import Grid as Grid
    from fefinger.scene.ask import Line as Line
    from fefinger.scene.ask import Places as Places
    from fefinger.scene.ask import Scatter as Scatter
    from fefinger.scene.fabric import Fabric as Fabric
    from fefinger.scene.finger import Finger as Finger
    from fefinger.scene.indenter import Indenter as Indenter
    from fefinger.scene.indenters import Bar as Bar
    from fefinger.scene.indenters import Cylinder as Cylinder
    from fefinger.scene.indenters import Ellipsoid as Ellipsoid
    from fefinger.scene.indenters import Flat as Flat
    from fefinger.scene.indenters import Pin as Pin
    from fefinger.scene.indenters import Sphere as Sphere
    from fefinger.scene.key import Key as Key
    from fefinger.scene.motions import FrequencySweep as FrequencySweep
    from fefinger.scene.motions import Ramp as Ramp
    from fefinger.scene.motions import RampHold as RampHold
    from fefinger.scene.motions import RampSinusoid as RampSinusoid
    from fefinger.scene.motions import Sinusoid as Sinusoid
    from fefinger.scene.motions import Trapezoid as Trapezoid
    from fefinger.scene.motions import Vibration as Vibration
    from fefinger.scene.samples import Sampled as Sampled
    from fefinger.scene.scene import Scene as Scene
    from fefinger.scene.sliding import SampledPath as SampledPath
    from fefinger.scene.sliding import Slide as Slide
    from fefinger.scene.texts import Braille as Braille
    from fefinger.scene.texts import Letters as Letters
    from fefinger.scene.textured import Dots as Dots
    from fefinger.scene.textured import Grating as Grating
    from fefinger.scene.textured import Relief as Relief
    from fefinger.scene.tissue import Hard as Hard
    from fefinger.scene.tissue import Ridges as Ridges
    from fefinger.scene.tissue import Tissue as Tissue
    from fefinger.studies.receptive_field import ReceptiveField as ReceptiveField
    from fefinger.studies.receptive_field import receptive_field as receptive_field
    from fefinger.studies.study import study as study
    from fefinger.support.checks import ConvergenceError as ConvergenceError
    from fefinger.support.checks import InputError as InputError
    from fefinger.support.checks import Stopped as Stopped
    from fefinger.support.registry import register as register
    from fefinger.theory.relaxation import Prony as Prony

__version__ = VERSION

_HOMES = {
    "scene.ask": ("Ask", "Fingertip", "Grid", "Line", "Places", "Scatter"),
    "calibration.calibrate": ("calibrate",),
    "calibration.record": ("Calibration",),
    "calibration.rig": ("Rig",),
    "fem.hyperelastic.continuum": ("check_law",),
    "laws": ("Law",),
    "mechanics": ("Mechanics",),
    "support.checks": ("ConvergenceError", "InputError", "Stopped"),
    "support.registry": ("register",),
    "result": ("Result", "load"),
    "scene.finger": ("Finger",),
    "scene.indenter": ("Indenter",),
    "scene.key": ("Key",),
    "scene.indenters": ("Bar", "Cylinder", "Ellipsoid", "Flat", "Pin", "Sphere"),
    "scene.textured": ("Dots", "Grating", "Relief"),
    "scene.motions": (
        *("Ramp", "RampHold", "RampSinusoid", "Sinusoid", "Trapezoid", "Vibration"),
        "FrequencySweep",
    ),
    "scene.samples": ("Sampled",),
    "scene.sliding": ("Slide", "SampledPath"),
    "scene.texts": ("Braille", "Letters"),
    "scene.fabric": ("Fabric",),
    "neural.family": ("Family",),
    "neural.series": ("spikes",),
    "neural.trains": ("SpikeTrains",),
    "pipeline": ("run",),
    "plan": ("choose", "explain"),
    "mechanics.loop": ("Loop",),
    "results.result_record": ("Plan",),
    "scene.scene": ("Scene",),
    "studies.receptive_field": ("ReceptiveField", "receptive_field"),
    "studies.study": ("study",),
    "theory.relaxation": ("Prony",),
    "mechanics.press.tactile_parts": ("TaxelGrid",),
    "mechanics.tactile_finger": ("TactileFinger",),
    "mechanics.vibrations": ("Vibrations",),
    "scene.tissue": ("Hard", "Ridges", "Tissue"),
}
_HOME = {name: home for home, names in _HOMES.items() for name in names}

_MODULES = ("mujoco", "shapes")

__all__ = sorted(_HOME)

# For one version, and listed nowhere:
_HOME |= dict.fromkeys(
    ("Condensed", "Modal", "Pressed", "Rolling", "Sliding"), "mechanics.former_loops"
)
_HOME |= dict.fromkeys(
    (
        *("ForceRamp", "ForceRampHold", "ForceRampSinusoid", "ForceSinusoid", "ForceTrapezoid"),
        *("ForceSweep", "ForceSampled", "ForceSlide", "ForceSampledPath"),
    ),
    "scene.sliding",
)


def __getattr__(name: str) -> "Any":
    """Import a public name at its first use."""
    import importlib  # not above: Ctrl-C would end its import with a traceback

    if name in _MODULES:
        return importlib.import_module(f"fefinger.{name}")
    if name not in _HOME:
        raise AttributeError(f"module 'fefinger' has no attribute {name!r}")
    return getattr(importlib.import_module(f"fefinger.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    """List the public names and the attributes of every module."""
    attributes = [name for name in globals() if name.startswith("__")]
    return sorted([*attributes, *__all__])
