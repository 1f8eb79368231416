"""Aircraft definitions."""
