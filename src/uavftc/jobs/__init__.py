"""What a command does: fly, compare, design, the paper, the bench, campaigns."""
