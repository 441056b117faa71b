"""Flows: clouds moved step by step so that an energy decreases."""
