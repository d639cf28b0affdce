"""The cases: real ones with an expert's labels beside the checkout, and generated heads with known truth."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shapery_geometry.volume_io import write_nifti
from shapery_segmentation.phantoms import HeadPhantom, TumorSpec, head_phantom

ROOT = Path(__file__).resolve().parent.parent.parent
DATA = Path(os.environ.get("SHAPERY_TEST_DATA", ROOT.parent / "shared" / "data")) / "volumes"

MEASURED_MM3 = 4000.0
"""Enhancing tumor from which a case counts in the means; below lie tumors of a few voxels' width."""

VISIBLE_MM3 = 1200.0
"""Enhancing tumor that should be found at all."""

WEAK = ("2013_21", "01479")
"""Cases whose tumor hardly enhances; the means are given with and without them."""


@dataclass(frozen=True)
class Case:
    """Files of one case, and which of the reference's values are the enhancing part and the core."""

    name: str
    group: str
    post: Path
    pre: Path | None
    reference: Path
    enhancing: tuple[int, ...]
    core: tuple[int, ...]

    @property
    def weak(self) -> bool:
        """Whether the tumor hardly enhances."""
        return any(part in self.name for part in WEAK)


def real_cases(data: Path) -> list[Case]:
    """Return the real cases that are there."""
    found = []
    for folder in sorted(data.glob("tumor_*/seg.nii.gz")):
        # Cases of 2023 count the enhancing tumor as 3.
        enhancing = (3,) if "brats23" in folder.parent.name else (4,)
        files = [folder.parent / name for name in ("t1c.nii.gz", "t1.nii.gz", "seg.nii.gz")]
        name = folder.parent.name.removeprefix("tumor_")
        found.append(Case(name, "real", files[0], files[1], files[2], enhancing, (1, *enhancing)))
    for image in sorted((data / "brain_t1gd_nrrd").glob("*_image.nrrd")):
        label = image.with_name(image.name.replace("_image", "_label"))
        name = f"t1gd_{image.name.split('_')[0]}"
        found.append(Case(name, "real, after contrast alone, slices of 6.5 mm", image, None, label, (1,), (1,)))
    return found


HEADS: dict[str, Callable[[], HeadPhantom]] = {
    "head": lambda: head_phantom(np.random.default_rng(101)),
    "head, stripped": lambda: head_phantom(np.random.default_rng(102), stripped=True),
    "head, healthy": lambda: head_phantom(np.random.default_rng(103), tumors=()),
    "head, healthy, tilted": lambda: head_phantom(
        np.random.default_rng(104), (176, 208, 176), tumors=(), rotation=(-8, 4, -12), shift=(3, 2, -4)
    ),
    "head, tilted 15°": lambda: head_phantom(
        np.random.default_rng(105), (180, 210, 180), rotation=(5, -8, 15), shift=(4, -6, 3)
    ),
    "head, tumor at the dura": lambda: head_phantom(np.random.default_rng(106), tumors=[TumorSpec(site="surface")]),
    "head, tumor across the middle": lambda: head_phantom(
        np.random.default_rng(107), tumors=[TumorSpec(site="midline", radius=20)]
    ),
    "head, two tumors": lambda: head_phantom(
        np.random.default_rng(108), tumors=[TumorSpec(radius=15), TumorSpec(radius=9)]
    ),
    "head, solid tumor of 12 mm": lambda: head_phantom(np.random.default_rng(109), tumors=[TumorSpec(radius=6, rim=9)]),
    "head, slices of 3 mm": lambda: head_phantom(np.random.default_rng(110), (160, 192, 54), (1.0, 1.0, 3.0)),
    "head, weak enhancement, noise": lambda: head_phantom(
        np.random.default_rng(111), tumors=[TumorSpec(enhancement=0.6)], noise=0.05
    ),
}
"""Name and drawing of each head; every one has a seed of its own."""


def head_cases(folder: Path) -> Iterator[Case]:
    """Draw the heads one by one as they are asked for, write them into `folder`, and yield them."""
    for number, (name, draw) in enumerate(HEADS.items()):
        files = {part: folder / f"head{number}_{part}.nii.gz" for part in ("post", "pre", "truth")}
        if not all(path.exists() for path in files.values()):
            phantom = draw()
            for part, path in files.items():
                write_nifti(getattr(phantom, part), path)
        yield Case(name, "phantom", files["post"], files["pre"], files["truth"], (1,), (1, 2))
