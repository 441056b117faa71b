"""What restricted cells of balls and of polyhedra have in common."""
