"""What is computed once per mesh, and kept outside the repository until the code that computes it changes."""

from __future__ import annotations

import hashlib
import os
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import shapery_geometry
import shapery_retrieval
from shapery_contracts.retrieval import INDEX_VERSION
from shapery_geometry.mesh import TriangleMesh
from shapery_geometry.operators.sampling import sample_surface
from shapery_retrieval.arg import Arg
from shapery_retrieval.describe import describe
from shapery_retrieval.patches import SHARES, Patches

CACHE = Path(os.environ.get("SHAPERY_BENCH_CACHE", Path(tempfile.gettempdir()) / "shapery-bench"))
_ROOT = Path(__file__).resolve().parents[2]
_COMPARING = (
    "_correspondence_kernels", "_matching_kernels", "arg", "commands", "correspondence", "coverage", "job", "laid_out",
    "local", "matching", "packing", "pose", "preview", "ranking", "report", "search", "vector", "vectors", "vocabulary",
    "warm", "threads",
)  # fmt: skip
"""Sources that compare graphs, keep or show them, and do not change what is computed from a mesh."""
_OF_VOLUMES = ("_rasterize_kernels", "_resampling_kernels", "mask_metrics", "rasterize", "resampling", "volume")


def _digest() -> str:
    digest = hashlib.sha256(b"%d" % INDEX_VERSION)
    for package in (shapery_geometry, shapery_retrieval):
        folder = Path(str(package.__file__)).parent
        for path in sorted((*folder.rglob("*.py"), *folder.rglob("*.npz"))):
            beside = path.stem in (*_COMPARING, *_OF_VOLUMES) or path.parent.name in ("fitting", "volume_io")
            if path.suffix == ".npz" or not beside:
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@dataclass(frozen=True, eq=False)
class Features:
    """A mesh's graph, and what simple peers need."""

    arg: Arg
    eigenvalues: NDArray[np.float64]
    """The first 31, of the surface of unit area."""
    d2: NDArray[np.float64]
    """(64,) histogram of distances between random points, over their mean."""
    cpu_seconds: float


def d2_histogram(mesh: TriangleMesh, rng: np.random.Generator, pairs: int = 40_000) -> NDArray[np.float64]:
    """R. Osada et al., Shape distributions, ACM TOG 21(4), 2002."""
    points = sample_surface(mesh, 2 * pairs, rng).points
    points = points[rng.permutation(len(points))]
    distances = np.linalg.norm(points[:pairs] - points[pairs:], axis=1)
    counts, _ = np.histogram(distances / distances.mean(), bins=64, range=(0, 3))
    return counts / pairs


def cached(mesh: TriangleMesh, prefix: str = "") -> Path:
    """Return where what was worked out of a mesh is kept, by its content."""
    content = hashlib.sha256(mesh.vertices.tobytes() + mesh.faces.tobytes()).hexdigest()[:20]
    return CACHE / DIGEST / f"{prefix}{content}.npz"


def keep(path: Path, **arrays: NDArray[Any]) -> None:
    """Write arrays into a file of the cache, which is there whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(f".{os.getpid()}.npz")
    np.savez(part, **arrays)
    part.replace(path)


def features_of(name: str, mesh: TriangleMesh) -> Features:
    """Return the features of a mesh, from the cache where its content was seen before."""
    path = cached(mesh)
    if not path.exists():
        start = time.process_time()
        found = describe(mesh)
        seconds = time.process_time() - start
        save(path, found.arg, found.signals.spectrum.values, found.normalised.mesh, seconds)
        print(f"  {name}: {seconds:.2f} CPU s", flush=True)
    with np.load(path, allow_pickle=False) as stored:
        arg = Arg.from_bytes(stored["arg"].tobytes())
        return Features(arg, stored["eigenvalues"], stored["d2"], float(stored["cpu_seconds"]))


def part_of(mesh: TriangleMesh) -> tuple[Arg, list[Patches]]:
    """Return the graph of a part and what it may be, from the cache where its content was seen before."""
    path = cached(mesh, "part-")
    if not path.exists():
        found = describe(mesh)
        arrays = {
            f"{name}{number}": values
            for number, patches in enumerate(found.hypotheses())
            for name, values in (("masses", patches.masses), ("features", patches.features))
        }
        keep(path, arg=np.frombuffer(found.arg.to_bytes(), dtype=np.uint8), **arrays)
    with np.load(path, allow_pickle=False) as stored:
        hypotheses = [Patches(stored[f"masses{k}"], stored[f"features{k}"]) for k in range(len(SHARES))]
        return Arg.from_bytes(stored["arg"].tobytes()), hypotheses


def save(path: Path, arg: Arg, eigenvalues: NDArray[np.float64], mesh: TriangleMesh, seconds: float) -> None:
    """Store features in a file, whole or not at all."""
    keep(
        path,
        arg=np.frombuffer(arg.to_bytes(), dtype=np.uint8),
        eigenvalues=eigenvalues[:31],
        d2=d2_histogram(mesh, np.random.default_rng(0)),
        cpu_seconds=seconds,
    )


DIGEST = _digest()
