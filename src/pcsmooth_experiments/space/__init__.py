"""Experiments with polyhedra: chapter 3 of the thesis."""
