"""What a job leaves on disk: folder, summary, history."""
