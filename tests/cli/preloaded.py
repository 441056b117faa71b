"""What processes import that others are forked from: modules that commands need, and kernels."""

import sys

import tqdm  # noqa: F401

import pcsmooth.cli.curvature
import pcsmooth.cli.files
import pcsmooth.files.curvature_file
import pcsmooth.files.denoise_file
import pcsmooth.formats
from cli.clouds import circle, sphere

if "pytest" not in sys.modules:  # which imports this to look for examples
    for _points in (circle(), sphere()):
        for _scheme in ("filter", "euler"):
            pcsmooth.denoise(_points, scheme=_scheme, threads=1)  # leaves no thread behind
