"""The row, compiled laws and their cache, and small mathematics: knows nothing above it."""
