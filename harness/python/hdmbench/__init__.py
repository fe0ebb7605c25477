"""Soft-tissue displacement, the same bits on every backend: what the program hdmbench computes, on NumPy arrays.

    import hdmbench
    result = hdmbench.solve(labels, {0: 1.0, 1: 3.0}, points=(before, after), affine=affine)
    result.displacement       # millimetres, a vector for every voxel
"""

from ._hdmbench import Inverse, Result, __version__, backends, scenes, solve, verify

__all__ = ["Inverse", "Result", "backends", "scenes", "solve", "verify"]
