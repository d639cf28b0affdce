"""Write the golden files of a new version: ``python -m tests.unit.motion.golden.write_trajectory``.

Those of earlier versions stay as they are.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from shapery_contracts.motion import MotionEncodeParams
from shapery_motion import decode, encode, info
from shapery_motion.container.header import VERSION
from tests.support.motions import difficult_sequences

FOLDER = Path(__file__).parent / "trajectory-{}.{}".format(*VERSION)
CASES = {
    "waving": ("waving", MotionEncodeParams(kg=0.2, fps=24.0, unit="m", name="waving")),
    "double": ("double precision", MotionEncodeParams(kg=0.05)),
    "corrected": ("flips", MotionEncodeParams(max_error=0.006, group_frames=8)),
    "bodies": ("41 components", MotionEncodeParams(kg=0.3)),
    "repeated": ("repeated frames", MotionEncodeParams(rmse=0.02)),
    "degenerate": ("degenerate and repeated faces", MotionEncodeParams(kg=0.5, preset="fast")),
    "triangle": ("one triangle", MotionEncodeParams(kg=0.1)),
    "hub": ("noise around a hub", MotionEncodeParams(kg=1.0)),
}


def write() -> None:
    """Write the files and what they decode to."""
    FOLDER.mkdir()
    sequences = difficult_sequences()
    expected = {}
    for name, (case, params) in CASES.items():
        data = encode(sequences[case], params).data
        (FOLDER / f"{name}.smc").write_bytes(data)
        found = decode(data)
        expected[name] = {
            "shape": list(found.vertices.shape),
            "sample": [float(x) for x in found.vertices[-1, :4].reshape(-1)],
            "vertices": hashlib.sha256(found.vertices.tobytes()).hexdigest(),
            "faces": hashlib.sha256(found.faces.tobytes()).hexdigest(),
            "errors": info(data).errors,
        }
    (FOLDER / "expected.json").write_text(json.dumps(expected, indent=1) + "\n")


if __name__ == "__main__":
    write()
