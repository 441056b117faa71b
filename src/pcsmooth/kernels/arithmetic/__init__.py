"""Numbers: eight at a time, twice as long, summed exactly; angles and directions."""
