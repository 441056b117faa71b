"""Filters: noise taken out of a cloud by means over neighbourhoods, before or without a flow."""
