"""Tolerances below which a residual, gap or difference counts as zero; dimensionless, one aside."""

LINEAR_RESIDUAL = 1e-10
"""Relative residual of a linear solution; forces must balance to 1e-6, this leaves a margin."""

FORCE_BALANCE = 1e-8
"""Relative residual of the force balance that rounding may leave where moduli are far apart."""

FACTOR_COMPRESSIBILITY = 1e-6
"""Compressibility, against the shear compliance, with which an incompressible body is factored;
refinement removes its effect, at a rate of about this number per step."""

REDUCED_COMPRESSIBILITY = 1e-13
"""The same for a body that is condensed, which cannot be refined: it changes displacements by 2e-12
and strains by 5e-12 of the largest, and is far above rounding."""

SINGULAR_PIVOT = 1e-12
"""Pivot, against the diagonal entry it came from, below which nothing is left of the stiffness."""

COMPLEMENTARITY = 1e-10
"""Tension or penetration, over the largest of its kind, that still counts as none."""

FORCE_MATCH = 1e-9
"""Relative error of the force under force control."""

SMALL_FORCE = 1e-6
"""Force (at finite strain, depth too) over the largest one of its path, below which errors are
taken relative to a force of this size: the contact cannot resolve smaller ones."""

LEAST_FORCE = 1e-3
"""Force in mN that no motion needs less of, a thousandth of what is felt: errors of a prescribed
force are taken relative to no smaller one, which would leave only rounding to converge to."""

INSIDE = 1e-3
"""Barycentric coordinate by which a site may lie outside the nearest cell: facets are flat, the
surface is not."""

SHARED = 1e-9
"""Barycentric coordinate up to which a site counts as lying on a face that cells share."""

EQUILIBRIUM = 5e-8
"""Relative residual of a finite-strain equilibrium: of force, volume, gap and prescribed force."""

PRESS_EQUILIBRIUM = 1e-5
"""The same for the press of a finger: on flat-press, against 1e-8, it changes the force by 3e-6 of
its peak, strain by 1e-5 and the pressure by 3e-5, for four fifths of the iterations."""
