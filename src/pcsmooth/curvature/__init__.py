"""Normals and curvatures of the surface under a cloud, from the measures of a union."""
