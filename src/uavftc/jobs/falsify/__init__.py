"""The search for the faults that break a controller."""
