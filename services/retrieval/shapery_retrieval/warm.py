"""``python -m shapery_retrieval.warm``: compile every kernel of the service once, so that the first job is fast."""

from __future__ import annotations


def warm() -> None:
    """Index two small shapes, match them and search, which runs all kernels."""
    from shapery_geometry.decimation import decimate
    from shapery_geometry.mesh import icosphere
    from shapery_retrieval.describe import describe
    from shapery_retrieval.preview import preview
    from shapery_retrieval.search import Searcher

    ball = icosphere(subdivisions=3)
    egg = ball.with_vertices(ball.vertices * [1.0, 1.3, 2.0])
    found = [describe(mesh) for mesh in (ball, egg)]
    found[1].cells_on(egg)
    searcher = Searcher.of({"ball": found[0].arg, "egg": found[1].arg})
    searcher.search(found[0].arg)
    searcher.search(found[0].arg, partial=True)
    preview(egg, 32)
    decimate(ball, 100)


if __name__ == "__main__":
    warm()
