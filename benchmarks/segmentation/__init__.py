"""Segmentation measured: real cases and phantoms, beside the usual untrained methods, and how cost grows (S14).

    python -m benchmarks.segmentation [--part real|peers|phantoms|growth|seeds …] [--only NAME …]

Writes ``benchmarks/results/segmentation.json`` and ``.md``. Each measurement is kept under ``--cache`` with a digest of
what it depends on, so a run that was interrupted goes on where it stopped, and only what changed is measured again.
"""
