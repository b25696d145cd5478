"""Membranes: from generator current to spikes, as siblings that can stand for one another."""

from fefinger.neural.membranes.connor_stevens import ConnorStevens
from fefinger.neural.membranes.firing import LARGEST_STEP, Firing, Membrane
from fefinger.neural.membranes.hodgkin_huxley import METHODS, HodgkinHuxley
from fefinger.neural.membranes.integrate_and_fire import IntegrateAndFire


__all__ = [
    "LARGEST_STEP",
    "METHODS",
    "ConnorStevens",
    "Firing",
    "HodgkinHuxley",
    "IntegrateAndFire",
    "Membrane",
]
