"""Jobs: their state, progress and results."""
