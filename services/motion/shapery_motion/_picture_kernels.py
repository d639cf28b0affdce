"""A depth buffer."""

# mypy: allow-untyped-defs, allow-untyped-calls

from __future__ import annotations

import numpy as np

from shapery_motion.compiled import kernel


@kernel
def nearest_faces(points, faces, width, height):
    """Return which face is seen at the middle of each pixel (height, width), -1 for none.

    `points` (n, 3) lie in pixels to the right and downwards, and towards the eye.
    """
    depth = np.full((height, width), -np.inf)
    seen = np.full((height, width), -1, dtype=np.int32)
    for f in range(len(faces)):
        a, b, c = points[faces[f, 0]], points[faces[f, 1]], points[faces[f, 2]]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area == 0.0:
            continue
        left = max(int(min(a[0], b[0], c[0])), 0)
        right = min(int(max(a[0], b[0], c[0])) + 1, width - 1)
        top = max(int(min(a[1], b[1], c[1])), 0)
        bottom = min(int(max(a[1], b[1], c[1])) + 1, height - 1)
        for y in range(top, bottom + 1):
            for x in range(left, right + 1):
                px, py = x + 0.5, y + 0.5
                u = ((b[0] - px) * (c[1] - py) - (b[1] - py) * (c[0] - px)) / area
                v = ((c[0] - px) * (a[1] - py) - (c[1] - py) * (a[0] - px)) / area
                w = 1.0 - u - v
                if u >= 0.0 and v >= 0.0 and w >= 0.0:
                    z = u * a[2] + v * b[2] + w * c[2]
                    if z > depth[y, x]:
                        depth[y, x] = z
                        seen[y, x] = f
    return seen
