"""`lappet report literature`: what papers measured of flaps, and what the program gives for the same."""
