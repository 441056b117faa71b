"""Lets scripts of this folder import what the tests share, which pytest finds by itself."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]))
