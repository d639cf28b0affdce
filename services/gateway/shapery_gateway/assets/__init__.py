"""Assets: files addressed by their content."""
