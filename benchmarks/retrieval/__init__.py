"""Retrieval measured: chapter 4's figures and table on the watertight set, beside simple peers, and worn shapes."""
