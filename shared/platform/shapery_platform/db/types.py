"""Column types and identifiers that mean the same in SQLite and in PostgreSQL."""

from __future__ import annotations

import os
import struct
import sys
import threading
import time
from array import array
from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from typing import Any
from uuid import UUID

from sqlalchemy import DateTime, Dialect, LargeBinary, TypeDecorator
from sqlalchemy.dialects.postgresql.base import ischema_names
from sqlalchemy.types import TypeEngine, UserDefinedType
from typing_extensions import override

_lock = threading.Lock()
_last = 0


def new_id() -> UUID:
    """Return a UUIDv7 (RFC 9562): later ids sort after earlier ones, strictly so within a process.

    48 bits of milliseconds, 12 bits of the millisecond's fraction, 62 random bits.
    """
    global _last
    with _lock:
        # in units of 1/4096 ms, so that the fraction keeps ids of the same millisecond in order
        stamp = time.time_ns() * 4096 // 1_000_000
        _last = stamp = max(stamp, _last + 1)
    milliseconds, fraction = divmod(stamp, 4096)
    random = int.from_bytes(os.urandom(8)) >> 2
    return UUID(int=(milliseconds & (1 << 48) - 1) << 80 | 0x7 << 76 | fraction << 64 | 0b10 << 62 | random)


def utc_now() -> datetime:
    """Return the time of this machine, aware, in UTC."""
    return datetime.now(UTC)


class UtcDateTime(TypeDecorator[datetime]):
    """Times are aware and in UTC on both sides, also where the database knows no time zones."""

    impl = DateTime(timezone=True)
    cache_ok = True

    @override
    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        if value is None:
            return None
        if value.tzinfo is None:
            raise ValueError("a time without a time zone cannot be stored")
        value = value.astimezone(UTC)
        return value.replace(tzinfo=None) if dialect.name == "sqlite" else value

    @override
    def process_result_value(self, value: Any, dialect: Dialect) -> datetime | None:
        if value is None:
            return None
        if value.tzinfo is None:
            return value.replace(tzinfo=UTC)  # type: ignore[no-any-return]
        return value.astimezone(UTC)  # type: ignore[no-any-return]


class HalfVector(UserDefinedType[bytes]):
    """``halfvec`` of the extension pgvector: numbers of 16 bits, up to 65,504 in size."""

    cache_ok = True

    def __init__(self, dimension: int | None = None) -> None:
        self.dimension = None if dimension is None else int(dimension)

    @override
    def get_col_spec(self, **_: Any) -> str:
        return "HALFVEC" if self.dimension is None else f"HALFVEC({self.dimension})"

    @override
    def bind_processor(self, dialect: Dialect) -> Callable[[bytes | None], str | None]:
        return lambda value: None if value is None else str(unpack_vector(value))

    @override
    def result_processor(self, dialect: Dialect, coltype: object) -> Callable[[str | None], bytes | None]:
        return lambda value: None if value is None else pack_vector(float(x) for x in value.strip("[]").split(","))


ischema_names["halfvec"] = HalfVector  # so that the type is known when tables are read back


class SentHalfVector(TypeDecorator[bytes]):
    """What ``halfvec_send`` gives, as bytes of 32-bit numbers: text would have to be read number by number.

    Two 16-bit integers, of which the first is how many numbers follow, and the numbers in 16 bits; the highest byte
    first (pgvector, ``src/halfvec.c``).
    """

    impl = LargeBinary
    cache_ok = True

    @override
    def process_result_value(self, value: bytes | None, dialect: Dialect) -> bytes | None:
        if value is None:
            return None
        count = int.from_bytes(value[:2])
        return struct.pack(f"<{count}f", *struct.unpack_from(f">{count}e", value, 4))


class Vector(TypeDecorator[bytes]):
    """A vector, in Python its 32-bit numbers as bytes: in SQLite those very bytes, in PostgreSQL pgvector's type."""

    impl = LargeBinary
    cache_ok = True

    def __init__(self, dimension: int) -> None:
        super().__init__()
        self.dimension = dimension

    @override
    def load_dialect_impl(self, dialect: Dialect) -> TypeEngine[Any]:
        if dialect.name == "postgresql":
            return dialect.type_descriptor(HalfVector(self.dimension))
        return dialect.type_descriptor(LargeBinary())


def pack_vector(numbers: Iterable[float]) -> bytes:
    """Return numbers as they are kept: 32-bit floats, the lowest byte first."""
    packed = array("f", numbers)
    if sys.byteorder == "big":
        packed.byteswap()
    return packed.tobytes()


def unpack_vector(data: bytes) -> list[float]:
    """Return the numbers that `pack_vector` packed."""
    packed = array("f", data)
    if sys.byteorder == "big":
        packed.byteswap()
    return packed.tolist()
