"""Who is near whom: the grid of the kernels, coincident and nearest points, the spacing."""
