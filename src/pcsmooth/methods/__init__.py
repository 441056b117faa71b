"""How a cloud is denoised: methods, the shapes they measure, and what restrains the motion."""
