"""What a user sees of a flight: table, figures, summary, result folder."""
