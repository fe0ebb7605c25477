"""Soft-tissue displacement, the same bits on every backend: what the program hdmbench computes, on NumPy arrays.

    import hdmbench
    result = hdmbench.solve(labels, {0: 1.0, 1: 3.0}, points=(before, after), affine=affine)
    result.displacement       # millimetres, a vector for every voxel
"""

import os

# Threads that wait give their processor away, as those of the program do. OpenMP reads it when it is loaded.
_asks_to_wait = "GOMP_SPINCOUNT" not in os.environ and "OMP_WAIT_POLICY" not in os.environ
if _asks_to_wait:
    os.environ["GOMP_SPINCOUNT"] = "1000"

from ._hdmbench import Gradient, Inverse, Result, __version__, backends, bench, register, scenes, solve, verify  # noqa: E402

if _asks_to_wait:
    del os.environ["GOMP_SPINCOUNT"]

__all__ = ["Gradient", "Inverse", "Result", "backends", "bench", "register", "scenes", "solve", "verify"]
