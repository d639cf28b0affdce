"""Peers without a model of the motion: rounded coordinates, and what general means make of them."""

from __future__ import annotations

import importlib
import lzma
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.motion.case import Case, Coded
from shapery_motion.gradient.streams import IntegerStream
from shapery_motion.gradient.traversal import traverse


def rounded(case: Case, kg: float) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the coordinates in whole steps that give the KG error, and what they stand for."""
    step = 2 * kg / 100 * case.spread
    low = case.frames.min(axis=(0, 1))
    for _ in range(3):
        whole = np.rint((case.frames - low) / step).astype(np.int64)
        decoded = low + step * whole
        error = case.kg(decoded)
        if 0.99 * kg < error <= kg:
            break
        step *= min(0.998 * kg / max(error, 1e-12), 4.0)
    return whole, decoded


def delta_lzma(case: Case, kg: float) -> Coded:
    """Differences from the frame before, byte plane by byte plane, through lzma, which packs smaller than zstd."""
    return _packed(case, kg, lambda plane: lzma.compress(plane, preset=6), lzma.decompress)


def delta_zstd(case: Case, kg: float) -> Coded | None:
    """Differences from the frame before, byte plane by byte plane, through zstd.

    The data of such sequences is often kept like this. Needs the package zstandard, which is not among those of
    development.
    """
    try:
        codec: Any = importlib.import_module("zstandard")
    except ModuleNotFoundError:
        return None
    return _packed(case, kg, codec.ZstdCompressor(level=19).compress, codec.ZstdDecompressor().decompress)


def _packed(case: Case, kg: float, compress: Callable[[bytes], bytes], decompress: Callable[[bytes], bytes]) -> Coded:
    whole, decoded = rounded(case, kg)
    changes = np.diff(whole, axis=0, prepend=0).astype(np.int32).transpose(0, 2, 1)
    folded = ((changes << 1) ^ (changes >> 31)).astype("<u4")
    planes = np.ascontiguousarray(folded).view(np.uint8).reshape(-1, 4).T
    data = [compress(plane.tobytes()) for plane in planes if plane.any()]
    start = time.process_time()
    for packed in data:
        decompress(packed)
    seconds = time.process_time() - start
    return Coded(sum(map(len, data)) + 32, decoded, seconds)


def delta_parallelogram(case: Case, kg: float) -> Coded:
    """Differences from the frame before, predicted by the parallelogram, through the range coder all peers share."""
    whole, decoded = rounded(case, kg)
    walk = traverse(case.faces, case.frames.shape[1])
    stream = IntegerStream(3)
    before = np.zeros_like(whole[0])
    for frame in whole:
        stream.write(walk.residuals(frame - before))
        before = frame
    data = stream.finish()
    start = time.process_time()
    reader, before = IntegerStream(3, memoryview(data)), np.zeros_like(whole[0])
    for _ in whole:
        before = before + walk.values(reader.read(len(before)))
    seconds = time.process_time() - start
    assert np.array_equal(before, whole[-1])
    return Coded(len(data) + 32, decoded, seconds)


def draco(case: Case, kg: float) -> Coded | None:
    """Draco for every frame by itself, connectivity included, with as few bits of quantisation as reach the error.

    The bytes are those of its better way to code connectivity, which does not keep the order of the vertices; the
    frames to compare come from the other, which quantises alike. Needs the package DracoPy, which is not among those
    of development.
    """
    try:
        codec: Any = importlib.import_module("DracoPy")
    except ModuleNotFoundError:
        return None
    faces = case.faces.astype(np.uint32)
    for bits in range(6, 21):
        decoded = np.empty_like(case.frames)
        settings = {"quantization_bits": bits, "compression_level": 10}
        for number, frame in enumerate(case.frames):
            ordered = codec.encode(frame.astype(np.float32), faces, preserve_order=True, **settings)
            decoded[number] = codec.decode(ordered).points
        if case.kg(decoded) <= kg:
            files = [codec.encode(frame.astype(np.float32), faces, **settings) for frame in case.frames]
            start = time.process_time()
            for data in files:
                codec.decode(data)
            seconds = time.process_time() - start
            return Coded(sum(map(len, files)), decoded, seconds, settings={"bits": bits})
    return None
