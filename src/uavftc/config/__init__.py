"""YAML documents with line numbers, values, expressions of t, messages; knows no scenario."""
