"""What a solved skin looks like, as arrays: its source, threads, hooks, bed and edges, and where a camera stands."""
