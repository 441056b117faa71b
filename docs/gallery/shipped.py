"""Where the clouds and meshes are that come with the sources."""

from pathlib import Path

DATA = Path(__file__).resolve().parents[2] / "data"
