"""Automatic differentiation (report, appendix), and the energies as plain functions to apply it to.

Nothing here shares code with `pcsmooth.kernels`; it is slow, short, and there to check them.
"""

from pcsmooth.autodiff.dual import Dual, seed

__all__ = ["Dual", "seed"]
