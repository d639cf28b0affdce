"""Volumes and triangle meshes: readers, writers, operators and metrics."""
