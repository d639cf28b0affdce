"""Graphs laid out in memory, kept for the next query of a process that stays."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapery_contracts.retrieval import INDEX_VERSION, VECTOR_DIMENSION, Candidate, ShapeBank
from shapery_retrieval.arg import Arg
from shapery_retrieval.packing import PackedLevel, joined, pack_levels
from shapery_retrieval.patches import Patches, patches_of
from shapery_retrieval.search import Searcher

MOST_BANKS = 4
MOST_GRAPHS = 8192
"""About 36 kB each."""


class GoneError(Exception):
    """Shapes were deleted while a search ran; it holds their ids."""

    def __init__(self, ids: frozenset[str]) -> None:
        super().__init__(f"{len(ids)} shapes are gone")
        self.ids = ids


class Searchers:
    """What was read of banks: graphs, laid out, by the ids of their shapes, and what is known of neighbourhoods.

    Reading a graph costs many times what matching it does. While a bank is small enough that all of it is compared, all
    queries share the neighbourhoods, too. Under its id a graph never changes.
    """

    def __init__(self) -> None:
        self._graphs: OrderedDict[str, tuple[tuple[PackedLevel, ...], Patches]] = OrderedDict()
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
            return joined([levels for levels, _ in self._laid(bank, [ids[place] for place in places.tolist()])])

        def lay_patches(places: NDArray[np.int64]) -> list[Patches]:
            return [patches for _, patches in self._laid(bank, [ids[place] for place in places.tolist()])]

        return Searcher(ids, vectors.reshape(len(ids), VECTOR_DIMENSION), lay, lay_patches, version, scales)

    def _laid(self, bank: ShapeBank, ids: Sequence[str]) -> list[tuple[tuple[PackedLevel, ...], Patches]]:
        missing = [shape_id for shape_id in ids if shape_id not in self._graphs]
        for shape_id, data in bank.args(missing).items() if missing else ():
            arg = Arg.from_bytes(data)
            self._graphs[shape_id] = pack_levels([arg]), patches_of(arg)
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
