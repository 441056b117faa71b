"""Experiments on curves in the plane: chapter 2 of the thesis."""
