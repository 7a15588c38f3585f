"""How far frames that have converged are from the same frames solved to 1e-8 in double precision."""
