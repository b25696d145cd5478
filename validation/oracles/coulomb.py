"""Contact with friction by projected gradients: small steps along gap and slip, back to the cone.

Another way to the solution of `contact/coulomb.py`, which shares no code with it:
slow, but each step is two lines. Source: De Saxcé and Feng, Math. Comput. Model. 28:225, 1998.
"""

import numpy as np

from fefinger.support.arrays import Array


def projected(flexibility: Array, offset: Array, mu: float, tolerance: float = 1e-11) -> Array:
    """Return x (3n,) of pressures and tractions with F x + offset against Coulomb's law.

    Steps are those of each unknown's own flexibility, damped; momentum starts anew where it turns
    against the change (O'Donoghue and Candès, Found. Comput. Math. 15:715, 2015).
    """
    n = len(offset) // 3
    diagonal = np.diag(flexibility).copy()
    diagonal[n:] = np.tile(np.maximum(diagonal[n : 2 * n], diagonal[2 * n :]), 2)
    scale = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    step = 1 / (np.linalg.eigvalsh(flexibility / np.outer(scale, scale))[-1] * scale**2)
    x, before, momentum = np.zeros(3 * n), np.zeros(3 * n), 1.0
    for _ in range(400_000):
        turned = (1 + np.sqrt(1 + 4 * momentum**2)) / 2
        ahead = x + (momentum - 1) / turned * (x - before)
        after = _onto(ahead - step * (flexibility @ ahead + offset), mu, n)
        if (ahead - after) @ ((after - x) / step) > 0:
            turned = 1.0
        before, x, momentum = x, after, turned
        if np.abs(x - before).max() <= tolerance * max(np.abs(x).max(), 1e-300):
            rest = _onto(x - step * (flexibility @ x + offset), mu, n)
            if np.abs(rest - x).max() <= tolerance * np.abs(x).max():
                return x
    message = "projected gradients: no solution"
    raise ArithmeticError(message)


def _onto(x: Array, mu: float, n: int) -> Array:
    """Return the nearest pressures above 0, and tractions within mu times those."""
    pressure = np.maximum(x[:n], 0.0)
    first, second = x[n : 2 * n], x[2 * n :]
    size = np.hypot(first, second)
    share = np.minimum(1.0, mu * pressure / np.where(size > 0, size, 1.0))
    return np.concatenate([pressure, first * share, second * share])
