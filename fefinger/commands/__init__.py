"""The commands of `fefinger`, one file each; a command imports what it needs when it runs."""

from fefinger.commands.bench import bench
from fefinger.commands.cache import cache
from fefinger.commands.calibrate import calibrate
from fefinger.commands.explain import explain
from fefinger.commands.field import field
from fefinger.commands.fit import fit
from fefinger.commands.live import live
from fefinger.commands.mesh import mesh
from fefinger.commands.run import run
from fefinger.commands.scenes import scenes
from fefinger.commands.spikes import spikes
from fefinger.commands.study import study
from fefinger.commands.validate import validate
from fefinger.commands.view import view


COMMANDS = (
    *(run, explain, scenes, study, mesh, spikes, field, view, live, fit, calibrate, validate),
    *(bench, cache),
)
"""All commands, in the order of the help text."""
