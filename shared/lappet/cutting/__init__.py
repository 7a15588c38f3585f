"""From incisions to the surfaces of the epochs."""
