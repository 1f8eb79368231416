"""The vehicles."""
