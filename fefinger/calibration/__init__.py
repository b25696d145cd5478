"""A finger that behaves like the subject's: parameters of a model fitted to curves and frames.

`calibrate` is the way in. The parts: `target` (what is to be met), `press` (the elastic press of a
finger, solved once and kept), `curve` (its force and stiffness at any exponent and modulus),
`inverse` (least squares with priors), `force` (the residuals), `pad` (the array), `record`.
"""
