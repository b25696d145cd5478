"""Membranes: models from generator current to spikes, with one interface."""

from fefinger.neural.membranes.firing import LARGEST_STEP, Firing, Membrane
from fefinger.neural.membranes.hodgkin_huxley import METHODS, HodgkinHuxley
from fefinger.neural.membranes.integrate_and_fire import IntegrateAndFire


__all__ = ["LARGEST_STEP", "METHODS", "Firing", "HodgkinHuxley", "IntegrateAndFire", "Membrane"]
