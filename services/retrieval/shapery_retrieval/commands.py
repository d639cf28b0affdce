"""What the command line asks of the library: files in, a bank in a file, answers out."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from shapery_contracts.errors import InvalidInput, UserError
from shapery_contracts.retrieval import ShapeSearchParams, ShapeSearchResult
from shapery_geometry.mesh_io import read_mesh_bytes
from shapery_retrieval.arg import Arg
from shapery_retrieval.describe import build_arg
from shapery_retrieval.job import query_for, search_bank
from shapery_retrieval.laid_out import Searchers
from shapery_retrieval.local import open_bank
from shapery_retrieval.search import score_matrix

MESH_SUFFIXES = frozenset({".obj", ".ply", ".stl", ".off", ".glb"})
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
Outcome = dict[str, Any]
OnProgress = Callable[[float, str], None]


def index_files(paths: Sequence[Path], bank: Path, processes: int, on_progress: OnProgress) -> list[Outcome]:
    """Index files into a bank and return for each its name, whether it was indexed now, and the error or None.

    Shapes are named by their files; where two have the same name, by their paths as given.

    Raises
    ------
    InvalidInput
        ``missing_input`` where a file does not exist, ``corrupt_file`` where the bank is none.
    """
    files = _named(paths)
    outcomes: list[Outcome] = []
    with open_bank(bank) as stored:
        waiting = [(name, path) for name, path in files if not stored.holds(name, path.read_bytes())]
        outcomes += [_outcome(name, False) for name, path in files if (name, path) not in waiting]
        for done, (name, path, data, error) in enumerate(_all_args(waiting, processes), start=1):
            if data is not None:
                stored.put(name, path.read_bytes(), Arg.from_bytes(data))
            outcomes.append(_outcome(name, data is not None, error))
            on_progress(done / len(waiting), name)
    return sorted(outcomes, key=lambda outcome: str(outcome["name"]))


def search(query: str, bank: Path, params: ShapeSearchParams) -> ShapeSearchResult:
    """Search a bank by a mesh in a file, or else by a shape that the bank holds under this name.

    Raises
    ------
    InvalidInput
        ``not_found`` where there is no bank, or neither such a file nor such a shape; what `query_for` refuses.
    """
    path = Path(query)
    with open_bank(bank, must_exist=True) as stored:
        if path.is_file():
            mesh_file: Path | None = path
        elif query in stored.names():
            mesh_file, params = None, params.model_copy(update={"shape_id": query})
        else:
            raise InvalidInput("not_found", f"{query} is neither a file nor a shape of the bank at {bank}.")
        searchers = Searchers()
        asked = query_for(params, mesh_file, stored, None, searchers)
        return search_bank(asked, params, stored, None, {}, searchers)


def write_matrix(bank: Path, out: Path, *, rerank: bool = False) -> int:
    """Write ``names`` (n,) and ``scores`` (n, n) of a whole bank, and return n.

    Raises
    ------
    InvalidInput
        ``not_found`` where there is no bank, ``empty_content`` where nothing is in it.
    """
    with open_bank(bank, must_exist=True) as stored:
        names = stored.names()
        data = stored.args(names)
    if not names:
        raise InvalidInput("empty_content", f"The bank at {bank} holds no shapes.", "Add some with: shapery index")
    scores = score_matrix([Arg.from_bytes(data[name]) for name in names], rerank=rerank)
    with out.open("wb") as stream:
        np.savez_compressed(stream, names=np.array(names), scores=scores)
    return len(names)


def count(bank: Path) -> int:
    """Return how many shapes a bank holds."""
    with open_bank(bank, must_exist=True) as stored:
        return len(stored)


def _named(paths: Sequence[Path]) -> list[tuple[str, Path]]:
    files: list[Path] = []
    for path in paths:
        if path.is_dir():
            files += sorted(p for p in path.rglob("*") if p.is_file() and p.suffix.lower() in MESH_SUFFIXES)
        elif path.is_file():
            files.append(path)
        else:
            raise InvalidInput("missing_input", f"The file {path} does not exist.")
    files = list(dict.fromkeys(files))
    names = [path.name for path in files]
    return [(str(path) if names.count(path.name) > 1 else path.name, path) for path in files]


def _all_args(
    files: Sequence[tuple[str, Path]], processes: int
) -> Iterator[tuple[str, Path, bytes | None, dict[str, str] | None]]:
    if processes <= 1 or len(files) <= 2:
        for name, path in files:
            yield name, path, *_arg_of(path)
        return
    given = {name: os.environ.get(name) for name in _THREADS}
    # processes share the processors already; threads of linear algebra in each would only wait for each other
    os.environ.update({name: "1" for name, value in given.items() if value is None})
    try:
        # a forked child of a process with threads may hang: each begins anew
        with ProcessPoolExecutor(min(processes, len(files)), mp_context=get_context("spawn")) as pool:
            for (name, path), (data, error) in zip(files, pool.map(_arg_of, [path for _, path in files]), strict=True):
                yield name, path, data, error
    finally:
        for name in (name for name, value in given.items() if value is None):
            del os.environ[name]


def _arg_of(path: Path) -> tuple[bytes | None, dict[str, str] | None]:
    try:
        return build_arg(read_mesh_bytes(path.read_bytes())).to_bytes(), None
    except UserError as error:
        return None, {"code": error.code, "message": error.message, "hint": error.hint}


def _outcome(name: str, indexed: bool, error: dict[str, str] | None = None) -> Outcome:
    return {"name": name, "indexed": indexed, "error": error}
