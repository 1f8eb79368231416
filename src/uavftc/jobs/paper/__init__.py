"""The paper's section 4 again: its tables and figures beside ours, and what explains the differences."""
