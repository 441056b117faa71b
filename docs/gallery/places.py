"""Where the scripts of the gallery find the clouds that are shipped."""

from pathlib import Path

DATA = Path(__file__).resolve().parents[2] / "data"
