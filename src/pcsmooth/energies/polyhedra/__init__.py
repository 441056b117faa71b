"""Unions of homothetic convex polyhedra (polygons in 2D): naive, inclusion-exclusion, exact."""
