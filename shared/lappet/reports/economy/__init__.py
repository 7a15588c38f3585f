"""What each feature costs, and that it costs nothing where it is absent."""
