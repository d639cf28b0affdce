"""Compiled loops of `shapery_retrieval.views` and `shapery_retrieval.preview`: images and their local features."""

# mypy: allow-untyped-defs, allow-untyped-calls

import numpy as np
from numba import njit

_FAST = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": {"nnan", "nsz", "reassoc", "contract"}}


@njit(**_FAST)
def render(points, faces, size, depth, face_ids):
    """Rasterise faces from the front: `points` (n, 3) hold column, row and height in pixels; the greatest height wins.

    ``depth`` (size, size) must hold −inf and ``face_ids`` −1 where nothing is seen.
    """
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, bx, by, cx, cy = points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1]
        det = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if det == 0.0:
            continue
        left, right = max(0, int(np.ceil(min(ax, bx, cx) - 0.5))), min(size - 1, int(np.floor(max(ax, bx, cx) - 0.5)))
        low, high = max(0, int(np.ceil(min(ay, by, cy) - 0.5))), min(size - 1, int(np.floor(max(ay, by, cy) - 0.5)))
        az, bz, cz = points[a, 2], points[b, 2], points[c, 2]
        for row in range(low, high + 1):
            for column in range(left, right + 1):
                px, py = column + 0.5, row + 0.5
                w1 = ((px - ax) * (cy - ay) - (cx - ax) * (py - ay)) / det
                w2 = ((bx - ax) * (py - ay) - (px - ax) * (by - ay)) / det
                w0 = 1.0 - w1 - w2
                if w0 < -1e-9 or w1 < -1e-9 or w2 < -1e-9:
                    continue
                z = w0 * az + w1 * bz + w2 * cz
                if z > depth[row, column]:
                    depth[row, column] = z
                    face_ids[row, column] = f


@njit(**_FAST)
def halve(image):
    """Return the image at half its size, 2 × 2 pixels averaged."""
    size = len(image) // 2
    result = np.empty((size, size), dtype=image.dtype)
    for row in range(size):
        for column in range(size):
            r, c = 2 * row, 2 * column
            result[row, column] = 0.25 * (image[r, c] + image[r + 1, c] + image[r, c + 1] + image[r + 1, c + 1])
    return result


@njit(**_FAST)
def _describe_patch(gx, gy, row, column, radius, out):
    """128 numbers of a patch, turned to its mean gradient and mirrored to one side; its contrast is returned."""
    size = len(gx)
    mx = my = 0.0
    for r in range(row - radius, row + radius):
        if r < 0 or r >= size:
            continue
        for c in range(column - radius, column + radius):
            if c < 0 or c >= size:
                continue
            dx, dy = (c + 0.5 - column) / radius, (r + 0.5 - row) / radius
            w = np.exp(-1.5 * (dx * dx + dy * dy))
            mx += w * gx[r, c]
            my += w * gy[r, c]
    length = np.sqrt(mx * mx + my * my)
    if length > 1e-9:
        co, si = mx / length, my / length
    else:
        co, si = 1.0, 0.0
    for k in range(128):
        out[k] = 0.0
    side = 0.0
    total = 0.0
    reach = int(radius * 1.4) + 1
    for r in range(row - reach, row + reach):
        if r < 0 or r >= size:
            continue
        for c in range(column - reach, column + reach):
            if c < 0 or c >= size:
                continue
            x, y = gx[r, c], gy[r, c]
            if x == 0.0 and y == 0.0:
                continue
            px, py = (c + 0.5 - column) / radius, (r + 0.5 - row) / radius
            dx, dy = co * px + si * py, co * py - si * px
            u, v = 2.0 * dx + 1.5, 2.0 * dy + 1.5
            if u <= -1.0 or v <= -1.0 or u >= 4.0 or v >= 4.0:
                continue
            gu, gv = co * x + si * y, co * y - si * x
            w = np.sqrt(gu * gu + gv * gv) * np.exp(-0.5 * (dx * dx + dy * dy))
            side += w * dy
            total += w
            angle = np.arctan2(gv, gu) * (4.0 / np.pi)
            if angle < 0:
                angle += 8.0
            o = int(angle)
            fo = angle - o
            o = o % 8
            iu, iv = int(np.floor(u)), int(np.floor(v))
            fu, fv = u - iu, v - iv
            for a in range(2):
                if iu + a < 0 or iu + a > 3:
                    continue
                wu = w * (fu if a else 1.0 - fu)
                for b in range(2):
                    if iv + b < 0 or iv + b > 3:
                        continue
                    wv = wu * (fv if b else 1.0 - fv)
                    base = ((iu + a) * 4 + iv + b) * 8
                    out[base + o] += wv * (1.0 - fo)
                    out[base + (o + 1) % 8] += wv * fo
    if side < 0:
        # the mirror image across the mean gradient
        for iu in range(4):
            for iv in range(2):
                for o in range(8):
                    here, there = (iu * 4 + iv) * 8 + o, (iu * 4 + 3 - iv) * 8 + (8 - o) % 8
                    out[here], out[there] = out[there], out[here]
    return total


@njit(**_FAST)
def describe_image(image, inside, step, radius, least, out, start):
    """Write the features of an image from row `start` of `out` on; return the row after the last one."""
    size = len(image)
    gx, gy = np.zeros_like(image), np.zeros_like(image)
    for r in range(1, size - 1):
        for c in range(1, size - 1):
            gx[r, c] = 0.5 * (image[r, c + 1] - image[r, c - 1])
            gy[r, c] = 0.5 * (image[r + 1, c] - image[r - 1, c])
    buffer = np.empty(128)
    place = start
    for row in range(step // 2, size, step):
        for column in range(step // 2, size, step):
            if not inside[row, column] or place >= len(out):
                continue
            if _describe_patch(gx, gy, row, column, radius, buffer) < least:
                continue
            total = 0.0
            for k in range(128):
                total += buffer[k]
            if total <= 0:
                continue
            for k in range(128):
                out[place, k] = np.sqrt(buffer[k] / total)
            place += 1
    return place


@njit(**_FAST)
def soft_assign(similarities, sharpness, keep, histogram):
    """Give each feature, by its (n, words) dot products with the words, to the `keep` best ones in shares."""
    n, words = similarities.shape
    best = np.empty(keep, dtype=np.int64)
    value = np.empty(keep)
    for i in range(n):
        for k in range(keep):
            best[k] = -1
            value[k] = -1e30
        for w in range(words):
            s = similarities[i, w]
            if s > value[keep - 1]:
                k = keep - 1
                while k > 0 and value[k - 1] < s:
                    value[k] = value[k - 1]
                    best[k] = best[k - 1]
                    k -= 1
                value[k] = s
                best[k] = w
        total = 0.0
        for k in range(keep):
            total += np.exp(sharpness * (value[k] - value[0]))
        for k in range(keep):
            histogram[best[k]] += np.exp(sharpness * (value[k] - value[0])) / total
