"""Segmentation measured: real cases and phantoms, beside the usual untrained methods, and how cost grows (S14).

    python -m benchmarks.segmentation [--part real|peers|settings|ablation|phantoms|vessels|growth …] [--only NAME …]

Brings those parts of ``benchmarks/results/segmentation.json`` and ``.md`` up to date, and leaves the others. Each
measurement is kept under ``--cache`` with a digest of what it depends on, so a run that was interrupted goes on where
it stopped, and only what changed is measured again.
"""
