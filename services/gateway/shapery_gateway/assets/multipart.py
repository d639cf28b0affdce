"""The one file of a ``multipart/form-data`` body, as a stream.

FastAPI's own `UploadFile` spools the whole body to disk before the route begins; here each piece goes on to storage
as it arrives, and no more than one piece is in memory.
"""

from __future__ import annotations

from collections.abc import AsyncGenerator, AsyncIterator

from python_multipart.exceptions import FormParserError
from python_multipart.multipart import MultipartParser, parse_options_header

from shapery_gateway.http.disposition import safe_filename
from shapery_gateway.problems import ProblemError

FIELD = "file"
MAX_OTHER_FIELDS = 1 << 20
"""Bytes of fields beside the file, which are read over."""


class MultipartFile:
    """Reads a multipart body and gives out the content of the part called ``file``.

    Parameters
    ----------
    content_type
        The value of ``Content-Type``, with the boundary.

    Raises
    ------
    ProblemError
        ``unsupported_media_type`` or ``bad_request``.
    """

    def __init__(self, content_type: str) -> None:
        kind, options = parse_options_header(content_type)
        if kind != b"multipart/form-data":
            raise ProblemError(
                "unsupported_media_type",
                f"The body is {content_type[:80]!r}, not multipart/form-data.",
                f"Send the file as the form field {FIELD!r}: curl -F {FIELD}=@head.nii.gz",
            )
        boundary = options.get(b"boundary", b"")
        if not boundary:
            raise ProblemError("bad_request", "The multipart body's Content-Type names no boundary.")
        self.filename = ""
        self.found = False
        self._pieces: list[bytes] = []
        self._in_file = False
        self._finished = False
        self._header_name = b""
        self._header_value = b""
        self._disposition = b""
        self._other = 0
        try:
            self._parser = MultipartParser(
                boundary,
                {
                    "on_part_begin": self._on_part_begin,
                    "on_header_field": self._on_header_field,
                    "on_header_value": self._on_header_value,
                    "on_header_end": self._on_header_end,
                    "on_headers_finished": self._on_headers_finished,
                    "on_part_data": self._on_part_data,
                    "on_part_end": self._on_part_end,
                    "on_end": self._on_end,
                },
            )
        except FormParserError as error:
            raise ProblemError("bad_request", f"The multipart boundary is not valid: {error}.") from None

    async def content(self, stream: AsyncIterator[bytes]) -> AsyncGenerator[bytes, None]:
        """Yield the file's content as `stream`, the body, arrives.

        Raises
        ------
        ProblemError
            ``bad_request`` where the body is malformed or cut, ``missing_input`` where it holds no file.
        """
        async for data in stream:
            try:
                self._parser.write(data)
            except FormParserError as error:
                raise ProblemError("bad_request", f"The multipart body is malformed: {error}.") from None
            pieces, self._pieces = self._pieces, []
            for piece in pieces:
                yield piece
        if not self._finished:
            raise ProblemError("bad_request", "The multipart body ends before its last boundary.")
        if not self.found:
            raise ProblemError(
                "missing_input", f"The form has no file field {FIELD!r}.", f"curl -F {FIELD}=@head.nii.gz"
            )

    def _on_part_begin(self) -> None:
        self._disposition = b""
        self._in_file = False

    def _on_header_field(self, data: bytes, start: int, end: int) -> None:
        self._header_name += data[start:end]

    def _on_header_value(self, data: bytes, start: int, end: int) -> None:
        self._header_value += data[start:end]

    def _on_header_end(self) -> None:
        if self._header_name.lower() == b"content-disposition":
            self._disposition = self._header_value
        self._header_name = self._header_value = b""

    def _on_headers_finished(self) -> None:
        _, options = parse_options_header(self._disposition)
        if options.get(b"name") != FIELD.encode():
            return
        if self.found:
            raise ProblemError(
                "validation_failed", f"The form has more than one {FIELD!r}.", "Send one file a request."
            )
        self.found = self._in_file = True
        self.filename = safe_filename(options.get(b"filename", b"").decode("utf-8", "replace"))

    def _on_part_data(self, data: bytes, start: int, end: int) -> None:
        if self._in_file:
            self._pieces.append(data[start:end])
            return
        self._other += end - start
        if self._other > MAX_OTHER_FIELDS:
            raise ProblemError("request_too_large", f"The form's other fields have more than {MAX_OTHER_FIELDS} bytes.")

    def _on_part_end(self) -> None:
        self._in_file = False

    def _on_end(self) -> None:
        self._finished = True


async def blocks(stream: AsyncIterator[bytes], size: int) -> AsyncGenerator[bytes, None]:
    """Yield the bytes of `stream` in blocks of at least `size` bytes, but for the last.

    Storage is written from a thread; a hop for each packet would cost more than the write.
    """
    gathered: list[bytes] = []
    count = 0
    async for data in stream:
        if data:
            gathered.append(data)
            count += len(data)
        if count >= size:
            yield b"".join(gathered)
            gathered, count = [], 0
    if gathered:
        yield b"".join(gathered)
