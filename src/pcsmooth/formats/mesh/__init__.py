"""Vertices of meshes: OBJ, OFF and STL files."""
