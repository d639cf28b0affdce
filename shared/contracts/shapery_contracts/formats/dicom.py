"""What the first bytes of a DICOM file say, read without numerics.

Only the few elements that recognition needs are read, from a window at the start of the file, and nothing that names a
person is looked at.

References
----------
DICOM PS3.5 section 7 (data elements), PS3.10 section 7 (file meta information).
"""

from __future__ import annotations

import re
import struct
from enum import Enum, auto
from types import MappingProxyType
from typing import Final

from shapery_contracts.formats.model import AssetKind, Details, FileFormat, corrupt, unsupported

_TRANSFER_SYNTAX: Final = 0x00020010
_SOP_CLASS: Final = 0x00080016
_MODALITY: Final = 0x00080060
_SERIES: Final = 0x0020000E
_FRAMES: Final = 0x00280008
_ROWS: Final = 0x00280010
_COLUMNS: Final = 0x00280011
_PIXEL_SPACING: Final = 0x00280030
_PIXELS: Final = (0x7FE00008, 0x7FE00009, 0x7FE00010)
_WANTED: Final = frozenset({_TRANSFER_SYNTAX, _SOP_CLASS, _MODALITY, _SERIES, _FRAMES, _ROWS, _COLUMNS, _PIXEL_SPACING})
_ITEM, _ITEM_END, _SEQUENCE_END = 0xFFFEE000, 0xFFFEE00D, 0xFFFEE0DD
_LONG_VR: Final = frozenset({b"OB", b"OD", b"OF", b"OL", b"OV", b"OW", b"SQ", b"SV", b"UC", b"UN", b"UR", b"UT", b"UV"})
_VR: Final = _LONG_VR | frozenset(
    re.findall(rb"\w\w", b"AE AS AT CS DA DS DT FD FL IS LO LT PN SH SL SS ST TM UI UL US")
)
_UNDEFINED: Final = 0xFFFFFFFF
_IMPLICIT_LE: Final = "1.2.840.10008.1.2"
_EXPLICIT_LE: Final = "1.2.840.10008.1.2.1"
_DEFLATED: Final = "1.2.840.10008.1.2.1.99"
_EXPLICIT_BE: Final = "1.2.840.10008.1.2.2"

NOT_IMAGES: Final = MappingProxyType(
    {
        "1.2.840.10008.1.3.10": "a directory of other files (DICOMDIR)",
        "1.2.840.10008.5.1.4.1.1.66": "raw data",
        "1.2.840.10008.5.1.4.1.1.66.1": "a spatial registration",
        "1.2.840.10008.5.1.4.1.1.66.4": "a segmentation",
        "1.2.840.10008.5.1.4.1.1.66.5": "a surface segmentation",
        "1.2.840.10008.5.1.4.1.1.104.1": "a PDF document",
        "1.2.840.10008.5.1.4.1.1.104.3": "an STL model",
        "1.2.840.10008.5.1.4.1.1.481.2": "a radiotherapy dose",
        "1.2.840.10008.5.1.4.1.1.481.3": "radiotherapy structures",
        "1.2.840.10008.5.1.4.1.1.481.5": "a radiotherapy plan",
        "1.2.840.10008.5.1.4.1.1.4.2": "a spectroscopy measurement",
    }
)
"""SOP classes that people send by mistake, and what they hold."""


def looks_like_dicom(head: bytes) -> bool:
    """Tell whether the first bytes are those of a DICOM file with its preamble."""
    return head[128:132] == b"DICM"


class _End(Enum):
    """Where the walk over a file's beginning ended."""

    PIXELS = auto()
    """At its pixels."""
    BEYOND = auto()
    """Behind the place where they would stand."""
    WINDOW = auto()
    """Where the window ends; what follows is for the reader to judge."""
    FILE = auto()
    """Where the file ends, between two elements."""
    CUT = auto()
    """Where the file ends, inside an element."""
    PACKED = auto()
    """Where the deflated part begins."""


class _Window:
    """A walk over the data elements at the start of a file, bounded by the window's end."""

    def __init__(self, data: bytes, position: int) -> None:
        self.data = data
        self.position = position
        self.order = "<"
        self.implicit = False

    def element(self) -> tuple[int, bytes, int] | None:
        """Return tag, value representation and length, and step over that header; None at the end of the window."""
        at = self.position
        if at + 8 > len(self.data):
            return None
        group, number = struct.unpack_from(self.order + "2H", self.data, at)
        tag = group << 16 | number
        if self.implicit or group == 0xFFFE:
            (length,) = struct.unpack_from(self.order + "L", self.data, at + 4)
            self.position = at + 8
            return tag, b"", length
        vr = self.data[at + 4 : at + 6]
        if vr in _LONG_VR:
            if at + 12 > len(self.data):
                return None
            (length,) = struct.unpack_from(self.order + "L", self.data, at + 8)
            self.position = at + 12
            return tag, vr, length
        (length,) = struct.unpack_from(self.order + "H", self.data, at + 6)
        self.position = at + 8
        return tag, vr, length

    def skip_sequence(self, vr: bytes, depth: int = 0) -> bool:
        """Step over the items of a sequence of undefined length; False if it does not end within the window."""
        outside = self.implicit
        # An unknown element of undefined length is a sequence whose items are in implicit form (PS3.5 section 6.2.2).
        self.implicit = outside or vr == b"UN"
        while (found := self.element()) is not None:
            tag, _, length = found
            if tag == _SEQUENCE_END:
                self.implicit = outside
                return True
            if tag != _ITEM:
                return False
            if length != _UNDEFINED:
                self.position += length
            elif not self._skip_item(depth):
                return False
        return False

    def _skip_item(self, depth: int) -> bool:
        while depth < 32 and (found := self.element()) is not None:
            tag, vr, length = found
            if tag == _ITEM_END:
                return True
            if length != _UNDEFINED:
                self.position += length
            elif not self.skip_sequence(vr, depth + 1):
                return False
        return False


def _elements(head: bytes, size: int) -> tuple[dict[int, bytes], _End]:
    """Return the wanted values and where the walk ended.

    Raises
    ------
    InvalidInput
        ``corrupt_file`` if the file has no transfer syntax.
    """
    values: dict[int, bytes] = {}
    window = _Window(head, 132)
    in_meta = True
    while True:
        start = window.position
        found = window.element()
        if found is None:
            if in_meta:
                raise corrupt("The meta information of the DICOM file does not end.")
            if size > len(head):
                return values, _End.WINDOW
            # An element that is cut leaves the position before or behind the end.
            return values, _End.FILE if window.position == len(head) else _End.CUT
        tag, vr, length = found
        if in_meta and tag >> 16 != 0x0002:
            syntax = values.get(_TRANSFER_SYNTAX, b"").rstrip(b"\0 ").decode("latin-1")
            if not re.fullmatch(r"[0-9.]{1,64}", syntax):
                raise corrupt("The DICOM file does not say how it is encoded (no transfer syntax).")
            if syntax == _DEFLATED:
                return values, _End.PACKED
            in_meta = False
            # Some programs declare one of the two forms and write the other; the first element shows which.
            known = head[start + 4 : start + 6] in _VR
            window.implicit = not known if syntax in (_IMPLICIT_LE, _EXPLICIT_LE) else False
            window.order = ">" if syntax == _EXPLICIT_BE else "<"
            window.position = start
            continue
        if tag in _PIXELS:
            whole = length == _UNDEFINED or window.position + length <= size
            return values, _End.PIXELS if whole else _End.CUT
        if tag >> 16 > 0x7FE0:
            return values, _End.BEYOND
        if not window.implicit and not re.fullmatch(rb"[A-Z]{2}", vr):
            raise corrupt(f"The DICOM file is damaged at byte {start}.")
        if length == _UNDEFINED:
            if vr not in (b"SQ", b"UN", b""):
                raise corrupt(f"The DICOM file is damaged at byte {start}.")
            if not window.skip_sequence(vr):
                return values, _End.CUT if size <= len(head) else _End.WINDOW
            continue
        if tag in _WANTED and length <= 256:
            values[tag] = head[window.position : window.position + length]
        window.position += length


def transfer_syntax(head: bytes) -> str:
    """Return the UID of the transfer syntax."""
    return _elements(head, len(head))[0].get(_TRANSFER_SYNTAX, b"").rstrip(b"\0 ").decode("latin-1")


def recognise(head: bytes, size: int) -> FileFormat:
    """Tell what the DICOM file that begins with `head` holds.

    Raises
    ------
    InvalidInput
        ``corrupt_file``, or ``unsupported_format`` for what is no image.
    """
    values, end = _elements(head, size)
    text = {tag: value.rstrip(b"\0 ").decode("latin-1") for tag, value in values.items()}
    sop_class = text.get(_SOP_CLASS, "")
    if sop_class in NOT_IMAGES or sop_class.startswith("1.2.840.10008.5.1.4.1.1.88."):
        what = NOT_IMAGES.get(sop_class, "a structured report")
        raise unsupported(f"The DICOM file holds {what}, not an image.", "Send the images of one series.")
    order = ">" if text[_TRANSFER_SYNTAX] == _EXPLICIT_BE else "<"
    columns, rows = (_unsigned(values.get(tag, b""), order) for tag in (_COLUMNS, _ROWS))
    if end is _End.CUT:
        raise corrupt(f"The DICOM file is cut off after {size} bytes.", "Send it again.")
    if end in (_End.FILE, _End.BEYOND) or (end is _End.PIXELS and not (rows and columns)):
        raise unsupported("The DICOM file holds no image.", "Send the images of one series.")
    details: Details = {"transfer_syntax": text[_TRANSFER_SYNTAX]}
    if _MODALITY in text and re.fullmatch(r"[A-Z0-9_ ]{1,16}", text[_MODALITY]):
        details["modality"] = text[_MODALITY]
    if re.fullmatch(r"[0-9.]{1,64}", text.get(_SERIES, "")):
        details["series"] = text[_SERIES]
    frames = text.get(_FRAMES, "1").strip()
    if rows and columns:
        details["shape"] = [columns, rows, int(frames) if re.fullmatch(r"[0-9]{1,9}", frames) else 1]
    return FileFormat(
        kind=AssetKind.VOLUME, format="dicom", media_type="application/dicom", extension=".dcm", details=details
    )


def _unsigned(value: bytes, order: str) -> int:
    return int(struct.unpack(order + "H", value)[0]) if len(value) == 2 else 0
