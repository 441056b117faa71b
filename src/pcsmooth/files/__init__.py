"""From file to file: clouds read, denoised or estimated in parts, and written with estimates."""
