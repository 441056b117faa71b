"""Clouds larger than memory: spatial tiles with halos, over columns of rows on disk."""
