"""Benchmarks: what the closed loop costs beside what it stands on."""
