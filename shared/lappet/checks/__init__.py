"""What is wrong with a procedure before anything is cut."""
