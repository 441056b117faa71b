"""What Python callers use: clouds of other libraries in, results that show themselves out."""
