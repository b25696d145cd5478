"""Membranes: from generator current to spikes, as siblings that can stand for one another."""

from fefinger.neural.membranes.firing import LARGEST_STEP, Firing, Membrane
from fefinger.neural.membranes.hodgkin_huxley import METHODS, HodgkinHuxley


__all__ = ["LARGEST_STEP", "METHODS", "Firing", "HodgkinHuxley", "Membrane"]
