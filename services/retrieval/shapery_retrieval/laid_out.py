"""Banks laid out in memory, kept for the next query of a process that stays."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence

from shapery_contracts.retrieval import ShapeBank
from shapery_retrieval.arg import Arg
from shapery_retrieval.search import Searcher

MOST_BANKS = 4
MOST_GRAPHS = 4096


class Searchers:
    """What was read of banks: graphs by the ids of their shapes, and searchers by the ids they were laid out for.

    Laying out some hundred graphs and learning their neighbourhoods costs many times what a query does. While a bank is
    small enough that all of it is compared, all queries find the same searcher. Under its id a graph never changes.
    """

    def __init__(self) -> None:
        self._graphs: OrderedDict[str, Arg] = OrderedDict()
        self._searchers: OrderedDict[tuple[str, ...], Searcher] = OrderedDict()

    def over(self, bank: ShapeBank, ids: Sequence[str]) -> Searcher:
        """Return a searcher over those of some shapes that the bank has."""
        key = tuple(sorted(ids))
        searcher = self._searchers.get(key)
        if searcher is None:
            missing = [shape_id for shape_id in key if shape_id not in self._graphs]
            for shape_id, data in bank.args(missing).items():
                self._graphs[shape_id] = Arg.from_bytes(data)
            there = {shape_id: self._graphs[shape_id] for shape_id in key if shape_id in self._graphs}
            searcher = Searcher(there)
            if len(there) == len(key):
                self._searchers[key] = searcher
            for shape_id in there:
                self._graphs.move_to_end(shape_id)
        else:
            self._searchers.move_to_end(key)
        while len(self._searchers) > MOST_BANKS:
            self._searchers.popitem(last=False)
        while len(self._graphs) > MOST_GRAPHS:
            self._graphs.popitem(last=False)
        return searcher
