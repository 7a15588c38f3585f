"""Reports that others can check: error against run time, stability, economy. Each writes JSON, CSV and pictures."""
