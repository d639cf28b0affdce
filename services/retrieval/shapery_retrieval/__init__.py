"""Shape indexing and retrieval by attributed relational graphs."""
