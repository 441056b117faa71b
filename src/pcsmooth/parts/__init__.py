"""A cloud in parts: what work on points sees, whether they are in memory or on disk."""
