"""Unions of equal convex polyhedra (polygons in 2D): naive, inclusion-exclusion, exact."""
