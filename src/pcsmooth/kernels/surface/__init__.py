"""What is measured on the surface that the points sample: planes, means, normals, curvatures."""
