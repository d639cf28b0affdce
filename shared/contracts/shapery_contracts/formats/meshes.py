"""The first bytes of single meshes: OBJ, PLY, STL, OFF and GLB."""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Iterator
from typing import Final

from shapery_contracts.formats.model import (
    AssetKind,
    Details,
    FileFormat,
    check_data_fits,
    corrupt,
    text_of,
    unsupported,
)

OBJ_KEYWORDS: Final = frozenset(
    re.findall(
        r"\S+",
        """
        v vn vt vp f fo l p o g s mg mtllib usemtl maplib usemap bevel c_interp d_interp lod shadow_obj trace_obj
        cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con ctech stech call csh
        """,
    )
)
_NUMBER: Final = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|[-+]?(?:nan|inf)"
_OBJ_VERTEX: Final = re.compile(rf"v(?:\s+(?:{_NUMBER})){{3,7}}\s*", re.IGNORECASE)
_OBJ_FACE: Final = re.compile(r"fo?(?:\s+-?[0-9]+(?:/-?[0-9]*){0,2}){1,}\s*")
OFF_MAGIC: Final = re.compile(r"(ST)?(C)?(N)?(4)?(n)?OFF(?![A-Za-z0-9])")
_PLY_SIZES: Final = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("int", "uint", "float", "int32", "uint32", "float32"), 4),
    **dict.fromkeys(("double", "float64"), 8),
}
_GLB_JSON_LIMIT: Final = 1 << 16


def recognise(head: bytes, size: int) -> FileFormat | None:
    """Tell which mesh format the file of `size` bytes that begins with `head` has, or None if it has none of them.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` or ``unsupported_format``.
    """
    if head.startswith(b"glTF"):
        return _glb(head, size)
    if re.match(rb"ply[ \t]*\r?[\n\r]", head):
        return _ply(head, size)
    if (stl := _binary_stl(head, size)) is not None:
        return stl
    text = text_of(head)
    if text is None:
        # A binary OFF begins like its plain sister.
        if re.match(rb"\w{0,5}OFF\s+BINARY", head):
            raise unsupported("The OFF file is binary.", "Write it as plain text, or as PLY.")
        return None
    if len(head) < size:
        # The last line of the window may be cut.
        text = text[: max(text.rfind("\n"), text.rfind("\r")) + 1] or text
    return _off(text) or _text_stl(text) or _obj(text)


def _mesh(format_name: str, media_type: str, details: Details) -> FileFormat:
    return FileFormat(
        kind=AssetKind.MESH, format=format_name, media_type=media_type, extension=f".{format_name}", details=details
    )


def _glb(head: bytes, size: int) -> FileFormat:
    if len(head) < 20:
        raise corrupt(f"The GLB file ends after {len(head)} bytes.")
    version, length, json_length, json_type = struct.unpack_from("<3L4s", head, 4)
    if version != 2:
        raise unsupported(f"The GLB file has version {version}.", "Write it as glTF 2.0.")
    if length > size or json_length > size - 20:
        raise corrupt(f"The GLB file should have {length} bytes and has {size}.", "Send it again.")
    if json_type != b"JSON":
        raise corrupt("The GLB file does not begin with its JSON chunk.")
    details: Details = {}
    if json_length <= min(_GLB_JSON_LIMIT, len(head) - 20):
        details = _gltf_counts(head[20 : 20 + json_length])
    return _mesh("glb", "model/gltf-binary", details)


def _gltf_counts(raw: bytes) -> Details:
    """Return the vertices and triangles of all meshes, each counted once; nothing where the JSON is unusual."""
    try:
        document = json.loads(raw)
    except (ValueError, RecursionError) as error:
        raise corrupt("The JSON chunk of the GLB file is damaged.") from error
    vertices = faces = 0
    try:
        accessors = document.get("accessors", [])
        seen = set()
        for mesh in document.get("meshes", []):
            for primitive in mesh["primitives"]:
                if primitive.get("mode", 4) != 4:
                    continue
                position = primitive["attributes"]["POSITION"]
                if position not in seen:
                    vertices += int(accessors[position]["count"])
                seen.add(position)
                faces += int(accessors[primitive.get("indices", position)]["count"]) // 3
    except (KeyError, IndexError, TypeError, AttributeError, ValueError) as error:
        raise corrupt("The JSON chunk of the GLB file describes its meshes wrongly.") from error
    return {"vertices": vertices, "faces": faces}


def _ply(head: bytes, size: int) -> FileFormat:
    end = re.search(rb"(?:\r\n|\n|\r)end_header[ \t]*(?:\r\n|\n|\r|$)", head)
    if end is None:
        raise corrupt("The header of the PLY file does not end.")
    lines = re.split(r"\r\n|\n|\r", head[: end.start()].decode("latin-1"))
    encoding = ""
    counts: dict[str, int] = {}
    row_bytes: dict[str, int] = {}
    element = ""
    for line in lines[1:]:
        words = line.split()
        if not words or words[0] in ("comment", "obj_info"):
            continue
        if words[0] == "format" and len(words) >= 2:
            encoding = words[1]
        elif words[0] == "element" and len(words) == 3 and re.fullmatch(r"[0-9]{1,18}", words[2]):
            element = words[1]
            counts[element] = int(words[2])
            row_bytes[element] = 0
        elif words[0] == "property" and element and len(words) >= 3:
            # A list has at least its length; a scalar its own size; text needs a character and a separator.
            row_bytes[element] += _PLY_SIZES.get(words[2] if words[1] == "list" else words[1], 1)
        else:
            raise corrupt(f"The header of the PLY file has the line {line[:60]!r}, which means nothing there.")
    if encoding not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise unsupported(f"The PLY file is written as {encoding[:40]!r}.", "Write it as plain text or binary PLY.")
    if "vertex" not in counts:
        raise corrupt("The header of the PLY file names no vertices.")
    claimed = sum(
        count * (1 if encoding == "ascii" and row_bytes[name] else row_bytes[name]) for name, count in counts.items()
    )
    check_data_fits("PLY", claimed, size - end.end() + 1)
    details: Details = {"vertices": counts["vertex"]}
    if "tristrips" not in counts:
        details["faces"] = counts.get("face", 0)
    return _mesh("ply", "application/x-ply", details)


def _binary_stl(head: bytes, size: int) -> FileFormat | None:
    """Recognise a binary STL, whose only mark is its length: 84 bytes and 50 for each triangle that it counts."""
    if len(head) < 84:
        return None
    (count,) = struct.unpack_from("<L", head, 80)
    if count == 0 or size != 84 + 50 * count:
        return None
    return _mesh("stl", "model/stl", {"faces": int(count)})


def _text_stl(text: str) -> FileFormat | None:
    if not re.match(r"\s*solid\b", text, re.IGNORECASE):
        return None
    if not re.search(r"^\s*(facet\s+normal|endsolid)\b", text, re.IGNORECASE | re.MULTILINE):
        return None
    return _mesh("stl", "model/stl", {})


def _off(text: str) -> FileFormat | None:
    words = _words(text)
    first = next(words, "")
    match = OFF_MAGIC.match(first)
    if match is None or match.end() != len(first):
        return None
    if match.group(4) or match.group(5):
        raise unsupported("The OFF file has vertices of more or fewer than 3 dimensions.", "Write it as plain OFF.")
    counts = [next(words, "") for _ in range(2)]
    if counts[0].upper() == "BINARY":
        raise unsupported("The OFF file is binary.", "Write it as plain text, or as PLY.")
    if not all(re.fullmatch(r"[0-9]{1,18}", word) for word in counts):
        raise corrupt(f"The OFF file gives its counts as {' '.join(counts)[:60]!r}.")
    return _mesh("off", "application/x-off", {"vertices": int(counts[0]), "faces": int(counts[1])})


def _words(text: str) -> Iterator[str]:
    for line in text.splitlines():
        yield from line.split("#", 1)[0].split()


def _obj(text: str) -> FileFormat | None:
    """Recognise an OBJ, which has no mark.

    Every line of the window must be one of OBJ, and vertices and faces among them must be well formed.
    """
    vertices = faces = data = 0
    # A backslash joins a line with the next.
    for line in re.sub(r"\\\r?\n", " ", text).splitlines():
        words = line.split("#", 1)[0].strip()
        if not words:
            continue
        keyword = words.split(None, 1)[0]
        if keyword not in OBJ_KEYWORDS:
            return None
        if keyword == "v":
            if not _OBJ_VERTEX.fullmatch(words):
                return None
            vertices += 1
        elif keyword in ("f", "fo"):
            if not _OBJ_FACE.fullmatch(words):
                return None
            faces += 1
        data += keyword in ("v", "vn", "vt")
    if data < 3 or (vertices == 0 and faces == 0):
        return None
    return _mesh("obj", "model/obj", {})
