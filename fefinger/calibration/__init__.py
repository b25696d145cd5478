"""A finger that behaves like the subject's: parameters of a model fitted to curves and frames.

`calibrate` is the way in, `jobs` several of it. `target`: what is to be met; `press`: the elastic
press of a finger, solved once and kept; `curve`: force and array at any exponent and modulus;
`force`: residuals and predictions; `inverse`: least squares with priors; `pad`: the pad radius by
the array; `outcome` and `record`: what was found, and its files.
"""
