"""``python -m shapery_motion.warm``: compile every kernel of the service once, so that the first job is fast.

numba keeps what it compiled beside the sources (or in ``NUMBA_CACHE_DIR``); later processes load it.
"""

from __future__ import annotations

import numpy as np

from shapery_contracts.motion import MotionEncodeParams


def warm() -> None:
    """Encode and decode a small sheet in motion, with corrections, in either precision."""
    from shapery_geometry.sequence import MeshSequence
    from shapery_motion.codec import encode
    from shapery_motion.container.connectivity import sorted_faces
    from shapery_motion.gradient.encoder import encode_frames
    from shapery_motion.gradient.profile import open_group
    from shapery_motion.playing import decode
    from shapery_motion.profiles import GroupTask

    x, y = (values.reshape(-1) for values in np.meshgrid(np.arange(12.0), np.arange(12.0)))
    height = np.stack([np.sin(0.4 * x + 0.3 * t) * np.cos(0.5 * y - 0.2 * t) for t in range(10)])
    vertices = np.stack((np.broadcast_to(x, height.shape), np.broadcast_to(y, height.shape), height), axis=2)
    corner = (np.arange(11)[:, None] * 12 + np.arange(11)).reshape(-1)
    faces = np.concatenate(
        (np.stack((corner, corner + 1, corner + 13), axis=1), np.stack((corner, corner + 13, corner + 12), axis=1))
    )
    for dtype in (np.float32, np.float64):
        sequence = MeshSequence(vertices.astype(dtype), faces)
        decode(encode(sequence, MotionEncodeParams(kg=0.5, max_error=0.002)).data)
    decode(encode(sequence, MotionEncodeParams(kg=0.5, profile="gradient")).data)
    # without a bound its frames are predicted
    group = encode_frames(GroupTask(vertices, sorted_faces(faces), np.inf, clusters=2))
    sections = {tag: memoryview(payload) for tag, payload in group.sections}
    open_group(sections, len(vertices), vertices.shape[1], sorted_faces(faces), 1 << 30).frame(1)


if __name__ == "__main__":
    warm()
