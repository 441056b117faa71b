"""Pictures of clouds and pages that hold them; matplotlib and plotly are optional libraries."""
