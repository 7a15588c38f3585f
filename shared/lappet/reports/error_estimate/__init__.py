"""`lappet report error-estimate`: how far the printed error is from the true one, on scenes it was not fitted on."""
