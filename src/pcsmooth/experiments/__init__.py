"""The experiments of the report, done again: numbers, pictures, and whether they agree."""
