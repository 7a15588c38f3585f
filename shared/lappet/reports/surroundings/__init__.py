"""What the tissue beyond a cut-out's rim would change: each operation with its rim held, free, and farther away."""
