"""`report.html`: a flight, a comparison, a reproduction or a campaign as one page that needs no network."""
