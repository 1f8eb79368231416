"""Scenario files: schema, expressions of t, loading with line numbers, the text of a flight as flown."""
