"""``python -m shapery_segmentation.phantoms FOLDER --seed N``: write a head with a known tumor.

Leaves ``pre.nii.gz``, ``post.nii.gz``, ``truth.nii.gz`` (1 rim, 2 necrotic core) and ``truth.json``.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import get_args

import numpy as np

from shapery_geometry.volume_io import write_nifti
from shapery_segmentation.phantoms.head import HeadPhantom, Site, TumorSpec, head_phantom


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the command line, draw the head, write it."""
    parser = argparse.ArgumentParser(prog="python -m shapery_segmentation.phantoms", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=0, help="of the random generator; another head for each")
    parser.add_argument("--tumors", type=int, default=1, help="how many; 0 for a healthy head")
    parser.add_argument("--radius", type=float, default=17.0, help="mean radius of a tumor in mm")
    parser.add_argument("--site", choices=get_args(Site), default="deep")
    parser.add_argument("--shape", type=int, nargs=3, default=(160, 192, 160), metavar="N")
    parser.add_argument("--spacing", type=float, nargs=3, default=(1.0, 1.0, 1.0), metavar="MM")
    parser.add_argument("--rotation", type=float, nargs=3, default=(0.0, 0.0, 0.0), metavar="DEGREES")
    parser.add_argument("--shift", type=float, nargs=3, default=(0.0, 0.0, 0.0), metavar="MM")
    parser.add_argument("--noise", type=float, default=0.025, help="relative to white matter")
    parser.add_argument("--stripped", action="store_true", help="the brain alone")
    given = parser.parse_args(arguments)
    phantom = head_phantom(
        np.random.default_rng(given.seed),
        tuple(given.shape),
        tuple(given.spacing),
        tumors=[TumorSpec(radius=given.radius, site=given.site)] * given.tumors,
        rotation=tuple(given.rotation),
        shift=tuple(given.shift),
        noise=given.noise,
        stripped=given.stripped,
    )
    write_phantom(phantom, given.folder, seed=given.seed)


def write_phantom(phantom: HeadPhantom, folder: Path, *, seed: int | None = None) -> None:
    """Write volumes and truth into `folder`, which is created if it is missing."""
    folder.mkdir(parents=True, exist_ok=True)
    write_nifti(phantom.pre, folder / "pre.nii.gz", description="Shapery phantom, before contrast")
    write_nifti(phantom.post, folder / "post.nii.gz", description="Shapery phantom, after contrast")
    write_nifti(phantom.truth, folder / "truth.nii.gz", description="Shapery phantom, truth")
    counts = np.bincount(phantom.truth.data.ravel(), minlength=3)
    truth = {
        "seed": seed,
        "labels": {"1": "enhancing rim", "2": "necrotic core"},
        "voxel_counts": {"1": int(counts[1]), "2": int(counts[2])},
        "voxel_volume_mm3": phantom.truth.voxel_volume,
        "tumors": [
            {
                "center": [round(x, 3) for x in tumor.center],
                "enhancing_mm3": round(tumor.enhancing_mm3, 1),
                "core_mm3": round(tumor.core_mm3, 1),
            }
            for tumor in phantom.tumors
        ],
    }
    (folder / "truth.json").write_text(json.dumps(truth, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
