"""Controllers that replace both loops, as a custom controller does; one a file."""

NAMES = ("pid", "lqi")
"""Each the name of a module here, and of the controller."""
