"""A flight watched while it flies: at the pace of a clock, and sent to another program; one of them a file."""
