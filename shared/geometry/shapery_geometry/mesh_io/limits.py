"""How large a mesh may be, and the refusals that all readers share."""

from __future__ import annotations

from dataclasses import dataclass

from shapery_contracts.errors import InvalidInput, LimitExceeded


@dataclass(frozen=True, slots=True)
class MeshLimits:
    """Bounds that are checked against headers before anything is loaded, and while reading where there is no header."""

    vertices: int = 20_000_000
    faces: int = 40_000_000
    """Triangles."""
    bytes: int = 4 << 30
    """Size of the file."""

    def check(self, vertices: int = 0, faces: int = 0) -> None:
        """Refuse counts above the limits with ``too_large``."""
        if vertices > self.vertices:
            raise LimitExceeded(
                "too_large", f"The mesh has {vertices} vertices; at most {self.vertices} are allowed.", "Decimate it."
            )
        if faces > self.faces:
            raise LimitExceeded(
                "too_large", f"The mesh has {faces} faces; at most {self.faces} are allowed.", "Decimate it."
            )


def no_faces(what: str, points: int) -> InvalidInput:
    """Return the error for a file without any face; `what` is the format's name."""
    if points:
        message = f"The {what} file holds {points} points and no faces: it is a point cloud."
        return InvalidInput("empty_content", message, "Reconstruct a surface from the points first.")
    return InvalidInput("empty_content", f"The {what} file holds neither points nor faces.")
