"""Restricted cells of balls: their facets, measures and gradients."""
