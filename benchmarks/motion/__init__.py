"""Motion: rate and distortion of the codec beside its peers, and the tables and figures of chapter 5."""
