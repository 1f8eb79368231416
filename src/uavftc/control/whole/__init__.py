"""Controllers that take the place of both loops."""
