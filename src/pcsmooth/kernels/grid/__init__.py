"""Points in cells: their order, and those near a point."""
