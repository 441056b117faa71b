"""Linear systems of the flows."""
