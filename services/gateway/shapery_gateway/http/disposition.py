"""File names that came from outside, made safe to stand in a header and on a disk."""

from __future__ import annotations

import re
import unicodedata
from urllib.parse import quote

MAX_NAME = 255
_ASCII_UNSAFE = re.compile(r"[^A-Za-z0-9 ._()+,=@\[\]{}~-]")
_RESERVED = re.compile(r'[<>:"|?*]')


def safe_filename(name: str, fallback: str = "file") -> str:
    r"""Return the last component of `name` without control characters, at most 255 bytes of UTF-8.

    The names of both kinds of paths are cut, since a browser may send ``C:\scans\head.nii``. Bidirectional and other
    format characters go too: they can make ``exe.gpj`` look like ``jpg.exe``.
    """
    last = re.split(r"[/\\]", name)[-1]
    kept = "".join(c for c in last if unicodedata.category(c) not in {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})
    kept = _RESERVED.sub("_", kept).strip()
    if set(kept) <= {"."}:
        return fallback
    encoded = kept.encode("utf-8")
    if len(encoded) > MAX_NAME:
        # Keep the ending: `.nii.gz` says more than the tail of a long name.
        stem, dot, ending = kept.partition(".")
        tail = (dot + ending).encode("utf-8")
        if len(tail) > 32 or not stem:
            kept = encoded[:MAX_NAME].decode("utf-8", "ignore")
        else:
            kept = stem.encode("utf-8")[: MAX_NAME - len(tail)].decode("utf-8", "ignore") + dot + ending
    return kept


def content_disposition(filename: str, *, inline: bool) -> str:
    """Return the value of ``Content-Disposition`` (RFC 6266), in which `filename` cannot break out.

    The plain parameter holds what is ASCII; ``filename*`` (RFC 8187) holds the whole name.
    """
    name = safe_filename(filename)
    kind = "inline" if inline else "attachment"
    ascii_name = _ASCII_UNSAFE.sub("_", unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode())
    value = f'{kind}; filename="{ascii_name or "file"}"'
    if ascii_name != name:
        value += f"; filename*=UTF-8''{quote(name, safe='')}"
    return value
