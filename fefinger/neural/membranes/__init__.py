"""Membranes: models from generator current to spikes, with one interface."""

from fefinger.neural.membranes.firing import LARGEST_STEP, Firing, Membrane
from fefinger.neural.membranes.models import METHODS, HodgkinHuxley, IntegrateAndFire


__all__ = ["LARGEST_STEP", "METHODS", "Firing", "HodgkinHuxley", "IntegrateAndFire", "Membrane"]
