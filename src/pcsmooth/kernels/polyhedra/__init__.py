"""Unions of convex polyhedra: naive, by inclusion-exclusion, exact."""
