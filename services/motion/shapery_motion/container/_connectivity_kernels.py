"""Connectivity: the faces are walked through across their edges, each coded by where its third corner lies."""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

from typing import Final

import numpy as np

from shapery_motion.compiled import inlined, inner, kernel
from shapery_motion.entropy._coder_kernels import (
    DECODE,
    MODE,
    NUMBER_SLOTS,
    bit_length,
    code_adaptive,
    code_number,
)

# Slots of the adaptive probabilities.
FACE_SLOT: Final = 0
KIND_SLOT: Final = FACE_SLOT + 64
SEED_SLOT: Final = KIND_SLOT + 4 * 64
NEXT_SLOT: Final = SEED_SLOT + 8
SIGN_SLOT: Final = NEXT_SLOT + 8
DELTA_SLOT: Final = SIGN_SLOT + 8
AGO_SLOT: Final = DELTA_SLOT + 3 * NUMBER_SLOTS
CONNECTIVITY_SLOTS: Final = AGO_SLOT + NUMBER_SLOTS

NONE: Final = -1


@inlined
def open_edge(h, faces, heads_out, heads_in, next_out, next_in):
    """Note that half-edge h waits for a face on its other side."""
    a, b = faces[h // 3, h % 3], faces[h // 3, (h + 1) % 3]
    next_out[h] = heads_out[a]
    heads_out[a] = h
    next_in[h] = heads_in[b]
    heads_in[b] = h


@inner
def unlink(heads, following, at, h):
    """Take h out of the list at a vertex."""
    k = heads[at]
    if k == h:
        heads[at] = following[h]
        return
    while following[k] != h:
        k = following[k]
    following[k] = following[h]


@inner
def close_edge(a, b, faces, heads_out, heads_in, next_out, next_in, waiting):
    """Take a half-edge from a to b from those that wait, if there is one; tell whether there was."""
    h = heads_out[a]
    while h != NONE:
        if faces[h // 3, (h + 1) % 3] == b:
            unlink(heads_out, next_out, a, h)
            unlink(heads_in, next_in, b, h)
            waiting[h] = 0
            return True
        h = next_out[h]
    return False


@inner
def code_new(state, buffer, probabilities, hits, references, losses, index, limit):
    """Code the index of a vertex that comes for the first time, next to the likeliest of three references."""
    best = 0
    for k in range(1, 3):
        if losses[k] < losses[best]:
            best = k
    following = references[0] + 1
    if code_adaptive(state, buffer, probabilities, hits, NEXT_SLOT, 1 if index == following else 0):
        index = following
    else:
        sign = code_adaptive(state, buffer, probabilities, hits, SIGN_SLOT + best, 1 if index < references[best] else 0)
        distance = code_number(
            state, buffer, probabilities, hits, DELTA_SLOT + best * NUMBER_SLOTS, abs(index - references[best])
        )
        index = references[best] - distance if sign else references[best] + distance
    if index < 0 or index >= limit:
        return NONE
    for k in range(3):
        losses[k] += ((bit_length(abs(index - references[k])) << 8) - losses[k]) >> 4
    references[0] = index
    return index


@kernel
def code_faces(state, buffer, probabilities, hits, vertices, faces, given, keys, owners):
    """Code the faces of a mesh.

    Parameters
    ----------
    vertices
        Their number.
    faces : (m, 3)
        Receives the faces in the order in which they are coded.
    given : (m, 3)
        The faces to encode, in any order; empty when decoding.
    keys, owners : (3m,)
        Ascending a · vertices + b of all half-edges (a, b) given, and the half-edge of each; empty when decoding.

    Returns
    -------
    Whether the stream was sound.
    """
    count = len(faces)
    encoding = state[MODE] != DECODE
    heads_out = np.full(vertices, NONE, dtype=np.int64)
    heads_in = np.full(vertices, NONE, dtype=np.int64)
    next_out = np.full(3 * count, NONE, dtype=np.int64)
    next_in = np.full(3 * count, NONE, dtype=np.int64)
    waiting = np.zeros(3 * count, dtype=np.uint8)
    queue = np.empty(3 * count, dtype=np.int64)
    order = np.full(vertices, NONE, dtype=np.int64)
    visited = np.empty(vertices, dtype=np.int64)
    degrees = np.zeros(vertices, dtype=np.int64)
    coded = np.zeros(count if encoding else 0, dtype=np.uint8)
    references = np.full(3, NONE, dtype=np.int64)
    losses = np.zeros(3, dtype=np.int64)
    met, made, seed, head, tail = 0, 0, 0, 0, 0
    while made < count:
        source = NONE
        if head == tail:
            # a face that no edge leads to
            if encoding:
                while coded[seed]:
                    seed += 1
                source = seed
            for corner in range(3):
                v = given[source, corner] if encoding else 0
                new = code_adaptive(
                    state, buffer, probabilities, hits, SEED_SLOT + corner, 1 if encoding and order[v] == NONE else 0
                )
                if new:
                    references[1] = faces[made, 0] if corner > 0 else references[0]
                    references[2] = faces[made, 1] if corner > 1 else references[0]
                    v = code_new(state, buffer, probabilities, hits, references, losses, v, vertices)
                    if v == NONE or order[v] != NONE:
                        return False
                    order[v] = met
                    visited[met] = v
                    met += 1
                else:
                    ago = code_number(
                        state, buffer, probabilities, hits, AGO_SLOT, met - 1 - order[v] if encoding else 0
                    )
                    if ago >= met:
                        return False
                    v = visited[met - 1 - ago]
                faces[made, corner] = v
        else:
            h = queue[head]
            head += 1
            if not waiting[h]:
                continue
            a, b = faces[h // 3, h % 3], faces[h // 3, (h + 1) % 3]
            c = 0
            if encoding:
                key = np.int64(b) * vertices + a
                k = np.searchsorted(keys, key)
                while k < len(keys) and keys[k] == key:
                    if not coded[owners[k] // 3]:
                        source = owners[k] // 3
                        c = given[source, (owners[k] % 3 + 2) % 3]
                        break
                    k += 1
            known = min(degrees[a], 7) * 8 + min(degrees[b], 7)
            if not code_adaptive(state, buffer, probabilities, hits, FACE_SLOT + known, 1 if source != NONE else 0):
                continue
            # the corner may close the open border at either end of the edge
            left, right = NONE, NONE
            e = heads_in[a]
            while e != NONE:
                if e != h:
                    left = faces[e // 3, e % 3]
                    break
                e = next_in[e]
            e = heads_out[b]
            while e != NONE:
                if e != h:
                    right = faces[e // 3, (e + 1) % 3]
                    break
                e = next_out[e]
            if code_adaptive(
                state, buffer, probabilities, hits, KIND_SLOT + known, 1 if encoding and order[c] == NONE else 0
            ):
                references[1] = a
                references[2] = faces[h // 3, (h + 2) % 3]
                c = code_new(state, buffer, probabilities, hits, references, losses, c, vertices)
                if c == NONE or order[c] != NONE:
                    return False
                order[c] = met
                visited[met] = c
                met += 1
            elif left != NONE and code_adaptive(
                state, buffer, probabilities, hits, KIND_SLOT + 64 + known, 1 if c == left else 0
            ):
                c = left
            elif right != NONE and code_adaptive(
                state, buffer, probabilities, hits, KIND_SLOT + 128 + known, 1 if c == right else 0
            ):
                c = right
            else:
                ago = code_number(state, buffer, probabilities, hits, AGO_SLOT, met - 1 - order[c] if encoding else 0)
                if ago >= met:
                    return False
                c = visited[met - 1 - ago]
            faces[made, 0], faces[made, 1], faces[made, 2] = b, a, c
        if encoding:
            coded[source] = 1
        for corner in range(3):
            degrees[faces[made, corner]] += 1
        for corner in range(3):
            h = 3 * made + corner
            a, b = faces[made, corner], faces[made, (corner + 1) % 3]
            if a == b or close_edge(b, a, faces, heads_out, heads_in, next_out, next_in, waiting):
                continue
            open_edge(h, faces, heads_out, heads_in, next_out, next_in)
            waiting[h] = 1
            queue[tail] = h
            tail += 1
        made += 1
    return True
