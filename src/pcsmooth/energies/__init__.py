"""Energies of a cloud: one protocol, and the unions of shapes that implement it."""
