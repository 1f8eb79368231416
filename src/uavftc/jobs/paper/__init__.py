"""Section 4 of the paper, flown again: its tables and figures next to ours, and what explains the differences."""
