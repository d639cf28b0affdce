"""The one settings class: every process of the platform reads it from the environment (``SHAPERY_*``).

Two profiles share it. ``embedded`` needs nothing but a folder (`Settings.home`); ``production`` refuses whatever is
fit for one machine only: SQLite, the local-only mode without keys, and secrets that are empty or well known.
"""

from __future__ import annotations

import hashlib
import importlib
import ipaddress
import os
import tempfile
from pathlib import Path
from typing import Annotated, Any, Literal, Self
from urllib.parse import urlsplit

from pydantic import Field, SecretStr, ValidationError, field_validator, model_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from shapery_contracts.errors import ShaperyError

GIB = 1 << 30

_WEAK_SECRETS = frozenset(
    {
        "admin",
        "changeme",
        "change-me",
        "default",
        "example",
        "minio",
        "minioadmin",
        "password",
        "secret",
        "shapery",
        "test",
    }
)
_LEAST_ADMIN_KEY = 32
"""Characters of the first administrator's key: as many as a random 128-bit key has in hexadecimal digits."""

_LONGEST_SOCKET_PATH = 100
"""The kernel takes 107 bytes for the path of a Unix socket; the rest is room for a suffix."""


class SettingsError(ShaperyError):
    """The environment does not describe a platform that may be started; the text says every reason."""


def _default_home() -> Path:
    base = os.environ.get("XDG_DATA_HOME") or "~/.local/share"
    return Path(base).expanduser() / "shapery"


def is_loopback(host: str) -> bool:
    """Tell whether `host` can be reached from this machine only."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


class Settings(BaseSettings):
    """What can be set, with the defaults of the embedded profile."""

    model_config = SettingsConfigDict(env_prefix="SHAPERY_", extra="ignore", frozen=True)

    # where things are
    profile: Literal["embedded", "production"] = "embedded"
    home: Path = Field(default_factory=_default_home)
    """Folder of the embedded profile: database, objects, socket."""
    database_url: str = ""
    """``sqlite:///…`` or ``postgresql://…``."""
    redis_url: str = ""
    """``redis://…``, ``rediss://…`` or ``unix://…``."""
    storage_url: str = ""
    """``file:///folder`` or ``s3://bucket/prefix``."""
    s3_endpoint: str | None = None
    """Address of an S3-compatible store; none: that of the region."""
    s3_region: str = "us-east-1"
    s3_access_key: str | None = None
    s3_secret_key: SecretStr | None = None
    scratch: Path | None = None
    """Folder for temporary files of jobs and uploads; none: that of the system."""

    # the server
    host: str = "127.0.0.1"
    port: Annotated[int, Field(ge=0, le=65535)] = 8000
    public_url: str | None = None
    """Address under which people reach the server, where a proxy stands before it."""
    auth: Literal["local", "keys"] | None = None
    """``local``: whoever reaches the loopback address is the owner; ``keys``: API keys. None: that of the profile."""
    cors_origins: Annotated[list[str], NoDecode] = []
    """Origins (``https://lab.example``) whose pages may use the API from a browser; none but our own by default."""
    bootstrap_admin_key: SecretStr | None = None
    """The first administrator's key of a new installation."""

    # limits
    max_upload_bytes: Annotated[int, Field(gt=0)] = 64 * GIB
    max_request_bytes: Annotated[int, Field(gt=0)] = 16 << 20
    max_batch_items: Annotated[int, Field(gt=0)] = 10_000
    rate_limit_per_minute: Annotated[int, Field(ge=0)] = 600
    """Requests per minute of one key or address; 0: no limit."""
    min_free_bytes: Annotated[int, Field(ge=0)] = 1 * GIB
    """Local storage refuses what would leave less than this free."""
    job_time_limit: dict[str, Annotated[float, Field(gt=0)]] = {}
    """Seconds by job kind, instead of the kind's own limit."""
    job_memory_limit: dict[str, Annotated[int, Field(gt=0)]] = {}
    """Bytes by job kind, instead of the kind's own limit."""

    # how long things stay
    upload_ttl: Annotated[float, Field(gt=0)] = 86_400.0
    result_ttl: Annotated[float, Field(gt=0)] = 30 * 86_400.0

    # the pulse of the platform, in seconds
    heartbeat_interval: Annotated[float, Field(gt=0)] = 1.0
    lease_seconds: Annotated[float, Field(gt=0)] = 6.0
    """A worker silent for so long is taken for lost."""
    max_attempts: Annotated[int, Field(ge=1)] = 3
    progress_interval: Annotated[float, Field(ge=0)] = 0.25
    cancel_poll: Annotated[float, Field(gt=0)] = 0.5
    event_poll: Annotated[float, Field(gt=0)] = 0.25
    reaper_interval: Annotated[float, Field(gt=0)] = 1.0
    retention_interval: Annotated[float, Field(gt=0)] = 60.0
    dispatch_window: Annotated[int, Field(gt=0)] = 256
    """Messages that wait in one queue at the most; the rest of the queued rows follow as it drains."""

    plugins: Annotated[list[str], NoDecode] = []
    """Modules imported at the start of every process; each may register job kinds and handlers."""

    @field_validator("plugins", "cors_origins", mode="before")
    @classmethod
    def _split_commas(cls, value: Any) -> Any:
        if isinstance(value, str):
            return [name.strip() for name in value.split(",") if name.strip()]
        return value

    @field_validator("home", mode="after")
    @classmethod
    def _absolute_home(cls, value: Path) -> Path:
        return value.expanduser().absolute()

    @model_validator(mode="before")
    @classmethod
    def _ignore_empty(cls, values: Any) -> Any:
        """Take an empty variable for one that is not set: compose files and charts pass both alike."""
        if isinstance(values, dict):
            return {key: value for key, value in values.items() if value != ""}
        return values

    @model_validator(mode="after")
    def _derive_and_check(self) -> Self:
        derived: dict[str, Any] = {}
        if self.profile == "embedded":
            derived["database_url"] = self.database_url or f"sqlite:///{self.home / 'shapery.db'}"
            derived["redis_url"] = self.redis_url or f"unix://{self._socket()}"
            derived["storage_url"] = self.storage_url or f"file://{self.home / 'objects'}"
            derived["auth"] = self.auth or ("local" if is_loopback(self.host) else "keys")
        else:
            derived["auth"] = self.auth or "keys"
        for name, value in derived.items():
            # the model is frozen for everybody else
            object.__setattr__(self, name, value)
        faults = [*self._faults(), *(self._production_faults() if self.profile == "production" else [])]
        if faults:
            raise ValueError("; ".join(faults))
        return self

    def _socket(self) -> Path:
        path = self.home / "redis.sock"
        if len(os.fsencode(path)) <= _LONGEST_SOCKET_PATH:
            return path
        digest = hashlib.sha256(os.fsencode(self.home)).hexdigest()[:16]
        return Path(tempfile.gettempdir()) / f"shapery-{os.getuid()}-{digest}.sock"

    def _faults(self) -> list[str]:
        faults = []
        if self.auth == "local" and not is_loopback(self.host):
            faults.append(
                f"SHAPERY_AUTH=local lets everybody in who reaches the server, so it needs a loopback host, "
                f"not SHAPERY_HOST={self.host}: use SHAPERY_AUTH=keys"
            )
        if self.lease_seconds < 2 * self.heartbeat_interval:
            faults.append(
                f"SHAPERY_LEASE_SECONDS={self.lease_seconds:g} must be at least twice "
                f"SHAPERY_HEARTBEAT_INTERVAL={self.heartbeat_interval:g}, or live workers are taken for lost"
            )
        if self.database_url and self.database_kind not in ("sqlite", "postgresql"):
            faults.append("SHAPERY_DATABASE_URL must begin with sqlite:/// or postgresql://")
        if self.storage_url and urlsplit(self.storage_url).scheme not in ("file", "s3"):
            faults.append("SHAPERY_STORAGE_URL must begin with file:/// or s3://")
        if self.redis_url and urlsplit(self.redis_url).scheme not in ("redis", "rediss", "unix"):
            faults.append("SHAPERY_REDIS_URL must begin with redis://, rediss:// or unix://")
        return faults

    def _production_faults(self) -> list[str]:
        faults = [
            f"SHAPERY_{name.upper()} must be set in production"
            for name in ("database_url", "redis_url", "storage_url")
            if not getattr(self, name)
        ]
        if self.database_url and self.database_kind == "sqlite":
            faults.append("SHAPERY_DATABASE_URL names SQLite, which serves one machine only: use postgresql://")
        if self.auth == "local":
            faults.append("SHAPERY_AUTH=local is for one machine only: use SHAPERY_AUTH=keys")
        database = urlsplit(self.database_url)
        if database.scheme.startswith("postgresql") and database.password and _weak(database.password):
            faults.append("the password in SHAPERY_DATABASE_URL is a well-known default")
        if self.storage_url.startswith("s3://"):
            secret = self.s3_secret_key.get_secret_value() if self.s3_secret_key else None
            if (self.s3_access_key is None) != (secret is None):
                faults.append("SHAPERY_S3_ACCESS_KEY and SHAPERY_S3_SECRET_KEY must be set together or not at all")
            if secret is not None and _weak(secret):
                faults.append("SHAPERY_S3_SECRET_KEY is empty or a well-known default")
        if self.bootstrap_admin_key is not None:
            key = self.bootstrap_admin_key.get_secret_value()
            if len(key) < _LEAST_ADMIN_KEY or _weak(key):
                faults.append(
                    f"SHAPERY_BOOTSTRAP_ADMIN_KEY has {len(key)} characters and needs {_LEAST_ADMIN_KEY} random ones"
                )
        return faults

    @property
    def database_kind(self) -> str:
        """``sqlite`` or ``postgresql``."""
        kind = self.database_url.split(":", 1)[0].split("+", 1)[0]
        return "postgresql" if kind == "postgres" else kind

    @property
    def redis_socket(self) -> Path | None:
        """The Unix socket of `redis_url`, if it is one."""
        parts = urlsplit(self.redis_url)
        return Path(parts.path) if parts.scheme == "unix" else None


def _weak(secret: str) -> bool:
    plain = secret.strip().lower()
    return len(plain) < 8 or plain in _WEAK_SECRETS or len(set(plain)) < 4


def load_settings(**overrides: Any) -> Settings:
    """Read the settings from the environment; `overrides` come before it.

    Raises
    ------
    SettingsError
        With every reason in one sentence each.
    """
    try:
        return Settings(**overrides)
    except ValidationError as error:
        lines = []
        for fault in error.errors(include_url=False):
            where = ".".join(str(part) for part in fault["loc"])
            text = fault["msg"].removeprefix("Value error, ")
            lines.append(f"SHAPERY_{where.upper()}: {text}" if where else text)
        raise SettingsError("\n".join(lines)) from error


def load_plugins(settings: Settings) -> None:
    """Import the modules that `settings.plugins` names; what they register counts from then on."""
    for name in settings.plugins:
        try:
            importlib.import_module(name)
        except ImportError as error:
            raise SettingsError(f"The plugin {name!r} of SHAPERY_PLUGINS cannot be imported: {error}.") from error
