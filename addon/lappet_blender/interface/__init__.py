"""What every operator and panel shares: one way to refuse, sentences over several rows, durations in words."""
