"""Graphs laid out in memory, kept for the next query of a process that stays."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.retrieval import INDEX_VERSION, VECTOR_DIMENSION, Candidate, ShapeBank
from shapery_retrieval.arg import Arg
from shapery_retrieval.correspondence import SampledSurface, surface_of
from shapery_retrieval.packing import PackedLevel, joined, pack_levels, whole_arrays
from shapery_retrieval.patches import Patches, patches_of
from shapery_retrieval.search import Searcher
from shapery_retrieval.vector import vectors_of

MOST_BANKS = 4
MOST_GRAPHS = 8192
"""About 55 kB each, with the bytes that they were read from; 90 where it was found, and its samples are kept; 45 where
only its patches were asked for."""


class GoneError(Exception):
    """Shapes were deleted while a search ran; it holds their ids."""

    def __init__(self, ids: frozenset[str]) -> None:
        super().__init__(f"{len(ids)} shapes are gone")
        self.ids = ids


@dataclass(eq=False)
class LaidOut:
    """A graph; what it is compared by is laid out when it is first asked for."""

    arg: Arg

    @cached_property
    def levels(self) -> tuple[PackedLevel, ...]:
        """Its levels below the root."""
        return pack_levels([self.arg])

    @cached_property
    def patches(self) -> Patches:
        """Its patches."""
        return patches_of(self.arg)

    @cached_property
    def vector(self) -> NDArray[np.float64]:
        """(256,) its vector."""
        return np.asarray(vectors_of(self.levels, whole_arrays([self.arg]))[0], dtype=np.float64)

    @cached_property
    def surface(self) -> SampledSurface:
        """Its samples."""
        return surface_of(self.arg)


class Searchers:
    """What was read of banks: graphs, laid out, by the ids of their shapes, and what is known of neighbourhoods.

    Reading a graph costs many times what matching it does. While a bank is small enough that all of it is compared, all
    queries share the neighbourhoods, too. Under its id a graph never changes.
    """

    def __init__(self) -> None:
        self._graphs: OrderedDict[str, LaidOut] = OrderedDict()
        self._scales: OrderedDict[tuple[str, ...], dict[str, NDArray[np.float64]]] = OrderedDict()

    def over(self, bank: ShapeBank, near: Sequence[Candidate], version: int = INDEX_VERSION) -> Searcher:
        """Return a searcher over some shapes of a bank.

        Searching raises `GoneError` where a shape that is to be matched is not there any more.
        """
        ordered = sorted(near)
        ids = [candidate.shape_id for candidate in ordered]
        vectors = np.frombuffer(b"".join(candidate.vector for candidate in ordered), dtype="<f4")
        key = tuple(ids)
        scales = self._scales.setdefault(key, {})
        self._scales.move_to_end(key)
        while len(self._scales) > MOST_BANKS:
            self._scales.popitem(last=False)

        def lay(places: NDArray[np.int64]) -> tuple[PackedLevel, ...]:
            return joined(_levels(self._laid(bank, [ids[place] for place in places.tolist()])))

        def lay_patches(places: NDArray[np.int64]) -> list[Patches]:
            return [laid.patches for laid in self._laid(bank, [ids[place] for place in places.tolist()])]

        def lay_surfaces(places: NDArray[np.int64]) -> list[SampledSurface]:
            return [laid.surface for laid in self._laid(bank, [ids[place] for place in places.tolist()])]

        table = vectors.reshape(len(ids), VECTOR_DIMENSION)
        return Searcher(ids, table, lay, lay_patches, lay_surfaces, version, scales)

    def stored(self, bank: ShapeBank, shape_id: str) -> LaidOut | None:
        """Return a graph of a bank, or None where it is not there, or not any more."""
        # under the very name that it has in results: it is left out of them
        return self._laid(bank, [shape_id])[0] if shape_id in bank.args([shape_id]) else None

    def _laid(self, bank: ShapeBank, ids: Sequence[str]) -> list[LaidOut]:
        missing = [shape_id for shape_id in ids if shape_id not in self._graphs]
        read = bank.args(missing) if missing else {}
        for shape_id, data in read.items():
            self._graphs[shape_id] = LaidOut(Arg.from_bytes(data, trusted=True))
        gone = frozenset(shape_id for shape_id in missing if shape_id not in self._graphs)
        if gone:
            raise GoneError(gone)
        found = []
        for shape_id in ids:
            self._graphs.move_to_end(shape_id)
            found.append(self._graphs[shape_id])
        while len(self._graphs) > MOST_GRAPHS:
            self._graphs.popitem(last=False)
        return found


def _levels(graphs: Sequence[LaidOut]) -> list[tuple[PackedLevel, ...]]:
    """Return the levels of graphs; those that were not laid out are so together, which is faster than one by one."""
    missing = [laid for laid in graphs if "levels" not in vars(laid)]
    if missing:
        together = pack_levels([laid.arg for laid in missing])
        for place, laid in enumerate(missing):
            laid.levels = tuple(level.taken(np.array([place])) for level in together)
    return [laid.levels for laid in graphs]
