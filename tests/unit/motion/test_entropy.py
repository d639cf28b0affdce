"""The range coder: identities, cost against entropy, and what it does with damaged streams."""

from __future__ import annotations

import numpy as np
import pytest

from shapery_contracts.errors import InvalidInput
from shapery_motion.compiled import kernel
from shapery_motion.container import _correction_kernels as corrections
from shapery_motion.entropy import _coder_kernels as coder
from shapery_motion.entropy.stream import Stream


@kernel
def code_bits(state, buffer, probabilities, hits, bits):  # type: ignore[no-untyped-def]
    for k in range(len(bits)):
        bits[k] = coder.code_adaptive(state, buffer, probabilities, hits, 0, bits[k])


@kernel
def code_numbers(state, buffer, probabilities, hits, values):  # type: ignore[no-untyped-def]
    for k in range(len(values)):
        values[k] = coder.code_number(state, buffer, probabilities, hits, 0, values[k])


@kernel
def code_values(state, buffer, probabilities, hits, weights, contexts, values):  # type: ignore[no-untyped-def]
    slots = np.zeros(coder.CONTEXTS, dtype=np.int64)
    logits = np.zeros(coder.CONTEXTS, dtype=np.int64)
    for k in range(len(values)):
        for i in range(coder.CONTEXTS):
            slots[i] = (3 * i + contexts[k]) * coder.BINS
        values[k] = coder.code_value(
            state, buffer, probabilities, hits, slots, weights, 0, coder.BINS, logits, -1, values[k]
        )


def test_tables_are_what_the_specification_says() -> None:
    x = np.arange(-2048, 2049, 128)
    assert tuple(np.rint(65536 / (1 + np.exp(-x / 256))).astype(int)) == coder.SQUASH_KNOTS
    squash = coder.SQUASH
    assert np.all(np.diff(squash) >= 0)
    assert np.abs(squash / 65536 - 1 / (1 + np.exp(-np.arange(-2048, 2048) / 256))).max() < 0.004
    for p in (1, 40, 5000, 32768, 60000, 65000):
        x_of_p = int(coder.STRETCH[p >> 4])
        at = squash >= 16 * (p >> 4) + 8
        assert x_of_p == (int(np.argmax(at)) - 2048 if at.any() else 2047)
    assert coder.RATES[0] == 43690
    assert coder.RATES[250] == 131072 // 503


def test_bits_come_back_and_cost_their_entropy() -> None:
    rng = np.random.default_rng(3)
    for share in (0.5, 0.1, 0.01):
        bits = (rng.random(40_000) < share).astype(np.int64)
        stream = Stream(1, room=20_000)
        code_bits(*stream.parts, bits.copy())
        data = stream.finished()
        entropy = -share * np.log2(share) - (1 - share) * np.log2(1 - share)
        assert len(data) * 8 < 40_000 * entropy * 1.02 + 200
        found = np.zeros_like(bits)
        code_bits(*Stream(1, data=memoryview(data)).parts, found)
        assert np.array_equal(found, bits)


def test_numbers_of_all_sizes_come_back() -> None:
    values = np.array([0, 1, 2, 3, 7, 8, 1000, 65535, 2**20 + 5, 2**31 - 2, 0, 0, 5], dtype=np.int64)
    stream = Stream(coder.NUMBER_SLOTS, room=1000)
    code_numbers(*stream.parts, values.copy())
    found = np.zeros_like(values)
    code_numbers(*Stream(coder.NUMBER_SLOTS, data=memoryview(stream.finished())).parts, found)
    assert np.array_equal(found, values)


def test_mixed_values_come_back_and_the_mixer_finds_the_context_that_tells() -> None:
    rng = np.random.default_rng(4)
    contexts = rng.integers(0, 3, 6000)
    values = np.rint(rng.laplace(scale=np.array([0.2, 2.0, 300.0])[contexts])).astype(np.int64)
    values[17] = (1 << 24) - 1
    slots = 32 * coder.BINS
    stream = Stream(slots, 2 * coder.BINS, room=40_000)
    code_values(*stream.parts, stream.weights, contexts, values.copy())
    data = stream.finished()
    entropy = sum(np.log2(2 * np.e * b) for b in np.array([2.0, 300.0])) * 2000 + 2000 * 0.8
    assert len(data) * 8 < entropy * 1.08
    decoder = Stream(slots, 2 * coder.BINS, data=memoryview(data))
    found = np.zeros_like(values)
    code_values(*decoder.parts, decoder.weights, contexts, found)
    assert np.array_equal(found, values)
    decoder.check_end("TEST")


def test_a_stream_that_ends_early_is_refused_by_name() -> None:
    decoder = Stream(corrections.CORRECTION_SLOTS, data=memoryview(b"\x01\x02"))
    code_numbers(*decoder.parts, np.zeros(2000, dtype=np.int64))
    with pytest.raises(InvalidInput, match="TEST"):
        decoder.check_end("TEST")


def test_a_buffer_that_is_too_small_is_a_fault_of_ours() -> None:
    stream = Stream(coder.NUMBER_SLOTS, room=4)
    code_numbers(*stream.parts, np.arange(1000, dtype=np.int64))
    with pytest.raises(ValueError, match="room for 4"):
        stream.finished()
