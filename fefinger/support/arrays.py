"""Type aliases of numpy arrays."""

import numpy as np
from numpy.typing import NDArray


Array = NDArray[np.float64]
Floats = NDArray[np.floating]  # in single or double precision
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]
