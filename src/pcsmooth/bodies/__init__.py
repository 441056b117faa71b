"""Convex bodies, the unit balls of polyhedral norms, and the presets that name them."""
