"""A design of the inner loop as numbers, and compared with a flight."""
