"""A second decoder of the gradient profile, written from `api_schema/smc-gradient.md` alone, slowly and plainly.

It shares nothing with the first but the container, so that what the specification leaves out shows here.
"""

from __future__ import annotations

import math
import struct
from collections import deque
from pathlib import Path

import numpy as np

from shapery_motion import open_motion
from shapery_motion.container.sections import SectionReader

GOLDEN = Path(__file__).parent / "golden" / "gradient-1.0.smc"


class RangeDecoder:
    """The container's binary range coder, with adaptive probabilities by name."""

    def __init__(self, data: bytes) -> None:
        self.data, self.position, self.low, self.high = data, 4, 0, 0xFFFFFFFF
        self.code = int.from_bytes((data + bytes(4))[:4], "big")
        self.seen: dict[object, tuple[int, int]] = {}

    def raw(self, p: int = 32768) -> int:
        spread = self.high - self.low
        middle = self.low + (spread >> 16) * p + (((spread & 0xFFFF) * p) >> 16)
        bit = int(self.code <= middle)
        if bit:
            self.high = middle
        else:
            self.low = middle + 1
        while (self.low ^ self.high) >> 24 == 0:
            following = self.data[self.position] if self.position < len(self.data) else 0
            self.position += 1
            self.code = (self.code << 8) & 0xFFFFFFFF | following
            self.low = (self.low << 8) & 0xFFFFFFFF
            self.high = (self.high << 8) & 0xFFFFFFFF | 255
        return bit

    def adaptive(self, slot: object) -> int:
        p, n = self.seen.get(slot, (32768, 0))
        bit = self.raw(min(max(p, 32), 65504))
        p += ((65535 * bit - p) * (131072 // (2 * n + 3))) >> 16
        self.seen[slot] = (p, min(n + 1, 250))
        return bit

    def number(self, context: int) -> int:
        length = 0
        while length < 31 and self.adaptive((context, length)):
            length += 1
        if not length:
            return 0
        value = 1
        for k in range(length - 1):
            value = 2 * value + (self.adaptive((context, 31 + length)) if k == 0 and length < 9 else self.raw())
        return -value if self.raw() else value

    def rows(self, count: int, columns: int) -> list[list[int]]:
        result: list[list[int]] = []
        for _ in range(count):
            row: list[int] = []
            for j in range(columns):
                size = (abs(result[-1][j]) if result else 0) + (abs(row[-1]) if row else 0)
                row.append(self.number(16 * j + min(15, size.bit_length())))
            result.append(row)
        return result


def walk(faces: list[list[int]], n: int) -> tuple[dict, list[int], dict[int, int], list[int], dict[int, list[int]]]:
    """Faces across, order of faces, parents, order of vertices, predictors."""
    sides: dict[frozenset[int], list[int]] = {}
    for f, face in enumerate(faces):
        for k in range(3):
            sides.setdefault(frozenset((face[k], face[(k + 1) % 3])), []).append(3 * f + k)
    across = {}
    for ring in sides.values():
        for place, side in enumerate(ring):
            across[side] = ring[(place + 1) % len(ring)] // 3 if len(ring) > 1 else None
    order: list[int] = []
    parents: dict[int, int] = {}
    placed: list[int] = []
    predictors: dict[int, list[int]] = {}

    def place(v: int, by: list[int]) -> None:
        if v not in predictors:
            predictors[v] = by
            placed.append(v)

    appended: set[int] = set()
    for seed in range(len(faces)):
        if seed in appended:
            continue
        appended.add(seed)
        queue = deque([seed])
        while queue:
            f = queue.popleft()
            order.append(f)
            for v in faces[f]:
                place(v, placed[-1:])
            for k in range(3):
                g = across[3 * f + k]
                if g is None or g in appended:
                    continue
                appended.add(g)
                parents[g] = f
                queue.append(g)
                for v in faces[g]:
                    place(v, [faces[f][k], faces[f][(k + 1) % 3], faces[f][(k + 2) % 3]])
    for v in range(n):
        place(v, placed[-1:])
    return across, order, parents, placed, predictors


def decoded(sections: dict[str, bytes], frames: int, faces: list[list[int]], n: int) -> list[np.ndarray]:
    across, order, parents, placed, predictors = walk(faces, n)
    rank = {f: k for k, f in enumerate(order)}
    *origin, step = struct.unpack_from("<4d", sections["GFRM"])
    streams = {tag: RangeDecoder(sections[tag]) for tag in ("GKEY", "GLST", "GANC", "GMAT", "GLAB")}
    result: list[np.ndarray] = []
    positions = held = matrices = labels = None
    anchors: list[int] = []
    for entry in struct.iter_unpack("<BbHI", sections["GFRM"][32:]):
        kind, precision, clusters, stored = entry
        if kind & 1:
            whole: dict[int, np.ndarray] = {}
            for v, row in zip(placed, streams["GKEY"].rows(n, 3), strict=True):
                by = [whole[u] for u in predictors[v]]
                expected = by[0] + by[1] - by[2] if len(by) == 3 else (by[0] if by else 0)
                whole[v] = np.array(row) + expected
            grid = np.stack([whole[v] for v in range(n)])
            positions = grid + positions if kind & 4 else grid
            if kind & 8:
                anchors = np.cumsum([row[0] for row in streams["GLST"].rows(stored, 1)]).tolist()
            held = positions[anchors]
            key = np.array(origin) + step * positions
            result.append(key)
            continue
        held = held.copy()
        held[:stored] += np.array(streams["GANC"].rows(stored, 3), dtype=int).reshape(-1, 3)
        fresh = np.array(streams["GMAT"].rows(clusters + 1, 9))
        steady = matrices is not None and len(matrices[0]) == clusters + 1
        if steady and abs(precision - matrices[1]) <= 20:
            shift = precision - matrices[1]
            fresh += matrices[0] << shift if shift >= 0 else matrices[0] >> -shift
        matrices = (fresh, precision)
        same = labels is not None and max(labels[1], -1) == clusters + 1
        labels = (read_labels(streams["GLAB"], clusters + 1, across, order, parents, rank, labels[0] if same else None),
                  clusters + 1)  # fmt: skip
        transforms = fresh.reshape(-1, 3, 3) * 2.0**-precision + np.eye(3)
        places = np.array(origin) + step * held[:stored]
        result.append(glued(key, faces, labels[0], transforms, anchors[:stored], places))
    return result


def read_labels(coder: RangeDecoder, clusters: int, across, order, parents, rank, before) -> dict[int, int]:
    found: dict[int, int] = {}
    depth = (clusters - 1).bit_length()
    for f in order:
        first = found[parents[f]] if f in parents else None
        second = None
        for k in range(3):
            g = across[3 * f + k]
            if g is not None and g != parents.get(f) and rank[g] < rank[f] and found[g] != first:
                second = found[g]
                break
        third = before[f] if before else None
        p = (first is not None) + 2 * (second is not None) + 4 * (third is not None)
        if third is not None:
            p += 8 * (third == first) + 16 * (third == second)
            if f in parents:
                p += 32 * (before[parents[f]] == third) + 64 * (before[parents[f]] == first)
        if first is not None and coder.adaptive(p):
            found[f] = first
        elif second is not None and coder.adaptive(128 + p):
            found[f] = second
        elif third is not None and third not in (first, second) and coder.adaptive(256 + p):
            found[f] = third
        else:
            node = 1
            for _ in range(depth):
                node = 2 * node + coder.adaptive(384 + 2**depth + node)
            found[f] = node - 2**depth
            assert found[f] < clusters
    return found


def glued(key: np.ndarray, faces, labels, transforms, anchors, places) -> np.ndarray:
    n = len(key)
    matrix, right = np.zeros((n, n)), np.zeros((n, 3))
    for f, (v1, v2, v3) in enumerate(faces):
        a, b = key[v2] - key[v1], key[v3] - key[v1]
        c = np.cross(a, b)
        length = math.sqrt(c @ c)
        if not length > 1e-6 * max(a @ a, b @ b, (b - a) @ (b - a)):
            continue
        g2, g3 = np.cross(b, c) / length**2, np.cross(c, a) / length**2
        g = (-g2 - g3, g2, g3)
        for i, u in enumerate((v1, v2, v3)):
            right[u] += length * transforms[labels[f]] @ g[i]
            for j, v in enumerate((v1, v2, v3)):
                matrix[u, v] += length * g[i] @ g[j]
    free = np.setdiff1d(np.arange(n), anchors)
    result = np.empty((n, 3))
    result[anchors] = places
    result[free] = np.linalg.solve(
        matrix[np.ix_(free, free)], right[free] - matrix[np.ix_(free, anchors)] @ result[anchors]
    )
    return result


def test_the_specification_decodes_the_golden_file() -> None:
    data = GOLDEN.read_bytes()
    motion = open_motion(data)
    group = motion.groups[0]
    reader = SectionReader(memoryview(data), group.offset, group.offset + group.length)
    sections = {}
    while reader.offset < group.offset + group.length:
        tag, payload = reader.next()
        sections[tag] = bytes(payload)
    found = decoded(sections, group.frames, motion.faces.tolist(), motion.header.vertices)
    assert len(found) == len(motion) == 6
    for number, frame in enumerate(found):
        np.testing.assert_allclose(frame, motion.frame(number), atol=1e-6)
