"""Scans by stations: E57 and PTX files."""
