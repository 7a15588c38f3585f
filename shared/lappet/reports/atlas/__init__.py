"""The atlas: every design of the flap library solved and drawn at its defaults."""
