"""Pieces of HTTP that more than one resource needs: ranges, conditional requests, safe headers, event streams."""
