"""The side information of a group: which frames repeat, which cluster each vertex is in, ranks and runs."""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

from typing import Final

from shapery_motion.compiled import kernel
from shapery_motion.entropy._coder_kernels import (
    NUMBER_SLOTS,
    code_adaptive,
    code_below,
    code_number,
)

FRAME_SLOT: Final = 0
LABEL_SLOT: Final = 8
RANK_SLOT: Final = 64
RUNS_SLOT: Final = RANK_SLOT + NUMBER_SLOTS
LENGTH_SLOT: Final = RUNS_SLOT + NUMBER_SLOTS
MODEL_SLOTS: Final = LENGTH_SLOT + NUMBER_SLOTS


@kernel
def code_frames(state, buffer, probabilities, hits, sources):
    """Code which earlier kept frame each frame repeats; a frame that repeats none is kept itself.

    Returns how many are kept, or -1 where a damaged stream refers to a frame that is not there.
    """
    kept = 0
    repeats = 0
    for k in range(len(sources)):
        repeats = code_adaptive(state, buffer, probabilities, hits, FRAME_SLOT + repeats, 1 if sources[k] < kept else 0)
        if repeats and kept == 0:
            return -1
        if repeats:
            sources[k] = code_below(state, buffer, kept, sources[k])
            if sources[k] >= kept:
                return -1
        else:
            sources[k] = kept
            kept += 1
    return kept


@kernel
def code_labels(state, buffer, probabilities, hits, starts, neighbours, clusters, labels):
    """Code the cluster of each vertex in their order, predicted by the neighbours that come before it.

    Returns False where a damaged stream names a cluster that is not there.
    """
    last = 0
    for v in range(len(labels)):
        # the two most frequent labels around; of equally frequent ones the first
        first, second, first_count, second_count = last, -1, 0, 0
        for e in range(starts[v], starts[v + 1]):
            u = neighbours[e]
            if u >= v:
                break
            label = labels[u]
            count = 0
            for other in range(starts[v], starts[v + 1]):
                if neighbours[other] >= v:
                    break
                if labels[neighbours[other]] == label:
                    count += 1
            if count > first_count:
                if label != first and first_count > 0:
                    second, second_count = first, first_count
                first, first_count = label, count
            elif label != first and count > second_count:
                second, second_count = label, count
        label = labels[v]
        slot = LABEL_SLOT + min(first_count, 5) * 3 + min(second_count, 2)
        if code_adaptive(state, buffer, probabilities, hits, slot, 1 if label == first else 0):
            label = first
        elif second >= 0 and code_adaptive(
            state, buffer, probabilities, hits, LABEL_SLOT + 20 + min(second_count, 3), 1 if label == second else 0
        ):
            label = second
        else:
            label = code_below(state, buffer, clusters, label)
            if label >= clusters:
                return False
        labels[v] = label
        last = label
    return True


@kernel
def code_ranks(state, buffer, probabilities, hits, ranks):
    """Code the number of modes of each cluster."""
    for k in range(len(ranks)):
        ranks[k] = code_number(state, buffer, probabilities, hits, RANK_SLOT, ranks[k])


@kernel
def code_runs(state, buffer, probabilities, hits, frames, run_starts, lengths):
    """Code into which runs of frames each cluster is cut.

    `lengths[run_starts[c]:run_starts[c + 1]]` are those of cluster c when encoding; decoding fills both as far as
    `lengths` has room. Returns False where a damaged stream's runs do not make up the frames.
    """
    for c in range(len(run_starts) - 1):
        begin = run_starts[c]
        rest = frames
        at = begin
        while rest > 0:
            whole = 0
            if at < len(lengths) and lengths[at] == rest:
                whole = 1
            whole = code_adaptive(state, buffer, probabilities, hits, RUNS_SLOT + min(at - begin, 7), whole)
            if at >= len(lengths):
                return False
            if not whole:
                lengths[at] = code_number(state, buffer, probabilities, hits, LENGTH_SLOT, lengths[at] - 1) + 1
                if lengths[at] >= rest:
                    return False
            else:
                lengths[at] = rest
            rest -= lengths[at]
            at += 1
        run_starts[c + 1] = at
    return True
