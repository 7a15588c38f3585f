"""What a solve leaves: skin cache, report, pictures."""
