"""Files written once are decoded by every later version, bit for bit."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from shapery_motion import decode, info

FOLDER = Path(__file__).parent / "golden" / "trajectory"
EXPECTED = json.loads((FOLDER / "expected.json").read_text())


@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_a_file_decodes_to_the_same_bits_as_when_it_was_written(name: str) -> None:
    expected = EXPECTED[name]
    data = (FOLDER / f"{name}.smc").read_bytes()
    sequence = decode(data)
    assert list(sequence.vertices.shape) == expected["shape"]
    # a readable hint before the digest says no
    assert np.allclose(sequence.vertices[-1, :4].reshape(-1), expected["sample"], rtol=1e-6, atol=1e-6)
    assert hashlib.sha256(sequence.vertices.tobytes()).hexdigest() == expected["vertices"]
    assert hashlib.sha256(sequence.faces.tobytes()).hexdigest() == expected["faces"]
    assert info(data).errors == pytest.approx(expected["errors"])
