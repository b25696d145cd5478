"""Scenes and command lines that are refused, for the fingerprint of their messages."""

from collections.abc import Mapping
from typing import Any


BAD_TABLES: tuple[Mapping[str, Any], ...] = (
    {"fingr": {}},
    {"finger.widht": 3},
    {"finger": 3},
    {"finger": {}},
    {"finger": {"width": 14}},
    {"finger": {"subject": "f.c."}},
    {"finger.width": -1},
    {"finger.tissue": "maeno"},
    {"finger.bone": "soft"},
    {"finger.resolution": "finer"},
    {"finger.skin": {"poisson": 0.51}},
    {"finger.skin": {"modulus": 0}},
    {"finger.skin": {"thickness": 5}},
    {"finger.prony": {"c": [0.3, 0.6], "v": [10]}},
    {"finger.prony": {"c": [0.4, 0.6], "v": [-10]}},
    {"finger.prony": {"c": [0.4, 0.6], "v": [10, 20]}},
    {"indenter": {"kind": "cone"}},
    {"indenter.angle": 61},
    {"indenter.tilt": 46},
    {"indenter": {"kind": "sphere"}},
    {"indenter": {"kind": "sphere", "radius": 3, "at": [0, 7]}},
    {"indenter": {"kind": "ellipsoid", "radii": [1, 2]}},
    {"motion": {}},
    {"motion.kind": "rampe"},
    {"motion.sped": 3},
    {"motion.speed": 0},
    {"motion.depth": 5},
    {"motion.corner": 0.1},
    {"motion.hold": 4000},
    {"motion": {"kind": "sampled", "file": "none.csv"}},
    {"ask.force": "yes"},
    {"ask.spikes": ["SA1"]},
    {"ask.rel_error": 0},
    {"ask.seconds": -1},
    {"ask.depths": {"SAI": 6}},
    {"ask.drives": {"SAI": "compress"}},
    {"ask.generator": "linea"},
    {"name": " "},
)
"""Changes to the scene flat-press that make it unusable."""

PRESS = '[finger]\nsubject = "a.h."\n[motion]\nkind = "ramp"\nspeed = 60\ndepth = 1\n'

FILES = {
    "empty.toml": "",
    "not.toml": "finger: a.h.",
    "corner.toml": PRESS + "corner = = 3\n",
    "misspelt.toml": PRESS + "cornr = 0\n",
    "missing.toml": PRESS.replace("depth = 1\n", ""),
    "nan.toml": PRESS.replace("= 60", "= nan"),
    "series.csv": "time_s,SAI\n0,0\n0,1\n",
    "press.csv": "time,position\n0,0\n1,1\n",
}
"""Files that the bad commands are given."""

SPHERE = "--set indenter.kind=sphere --set indenter.radius=2"

BAD_COMMANDS = (
    *(f"run {name}" for name in FILES if name.endswith(".toml")),
    "run flat-pres",
    "scenes flat-pres",
    "mesh empty.toml",
    "explain not.toml",
    "run flat-press --set depth",
    "run flat-press --set motion.depth=-1",
    "run flat-press --set motion.depth.x=3",
    "run flat-press --set finger.subject=x.y.",
    "run flat-press --set finger.tissue=maeno",
    f"run flat-press {SPHERE} --set indenter.at=[0,9]",
    "run flat-press --mechanics lumped",
    "run flat-press --mechanics linaer",
    "run flat-press --set ask.rel_error=1e-4",
    "run p10-ball-on-array --set finger.bone.modulus=17e6 --mechanics hertz",
    "run flat-press -o series.csv",
    "run",
    "run --x",
    "rn",
    "validate neurol",
    "validate --quick --name a/b",
    "bench neurol",
    "study flat-press --over indenter.angel=0:60:3",
    "study flat-press --over indenter.angle=0:60:1000000 -o none",
    "fit none.csv",
    "fit press.csv",
    "spikes",
    "spikes --from series.csv",
    "spikes --from press.csv --type RA",
    "calibrate press.csv --subject x.y.",
    "view .",
    "view out --screenshot a.xyz",
    "mesh flat-press --picture a",
    "cache --prune -1",
)
"""Command lines that are refused; run in a folder that holds the files above."""
