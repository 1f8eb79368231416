"""Benchmarks: what the closed loop costs compared with what it is built on."""
