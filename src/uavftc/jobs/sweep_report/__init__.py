"""What came of a campaign: how often each controller holds, which is better on the same cases, what matters most."""
