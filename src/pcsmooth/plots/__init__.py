"""Pictures of clouds and pages that hold them; matplotlib is an optional library."""
