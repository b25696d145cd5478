"""Calibration of a finger model to measured force curves and frames of a tactile array.

`calibrate` is the entry point. `targets`: the measured data and their residuals; `slow_press`: the
elastic press of a finger, solved once and cached; `curve`: force and array pressure at any
exponent, modulus and rate; `inverse`: least squares with priors; `pad_radius`: the pad radius from
the array; `outcome` and `record`: the result and its files.
"""
