"""Files written once are decoded by every later version, bit for bit."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from shapery_motion import decode, info

FOLDERS = {
    version: Path(__file__).parent / "golden" / name
    for version, name in (
        ("1.0", "trajectory"),
        ("1.1", "trajectory-1.1"),
        ("1.2", "trajectory-1.2"),
        ("1.3", "trajectory-1.3"),
    )
}
EXPECTED = {
    (version, name): expected
    for version, folder in FOLDERS.items()
    for name, expected in json.loads((folder / "expected.json").read_text()).items()
}


@pytest.mark.parametrize(("version", "name"), sorted(EXPECTED))
def test_a_file_decodes_to_the_same_bits_as_when_it_was_written(version: str, name: str) -> None:
    expected = EXPECTED[version, name]
    data = (FOLDERS[version] / f"{name}.smc").read_bytes()
    assert info(data).version == version
    sequence = decode(data)
    assert list(sequence.vertices.shape) == expected["shape"]
    # a readable hint before the digest says no
    assert np.allclose(sequence.vertices[-1, :4].reshape(-1), expected["sample"], rtol=1e-6, atol=1e-6)
    assert hashlib.sha256(sequence.vertices.tobytes()).hexdigest() == expected["vertices"]
    assert hashlib.sha256(sequence.faces.tobytes()).hexdigest() == expected["faces"]
    assert info(data).errors == pytest.approx(expected["errors"])
