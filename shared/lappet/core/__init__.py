"""What every other folder may use: problems, refusals, the machine, the version."""
