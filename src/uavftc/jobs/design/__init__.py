"""A design of the inner loop as numbers, and beside a flight."""
