"""Outer loop: attitude to body-rate command."""
