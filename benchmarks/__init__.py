"""Measurements beside peers, and the counterparts of the dissertation's tables."""
