"""How a client reaches a server and how patient it is: arguments, else the environment, else defaults."""
import dataclasses
import os
import pathlib
from typing import Any, Optional

from axiscal.errors import InvalidArgument

MAX_CHUNK_READINGS = 4096  # core/records/chunk.h
MAX_TOKEN_BYTES = 4096


@dataclasses.dataclass(frozen=True)
class Options:
    """Each field has a variable: AXISCAL_CA, AXISCAL_CALL_DEADLINE_S ... Files are PEM."""

    ca: Optional[str] = None  # authority of the server's certificate; with it the connection is TLS
    certificate: Optional[str] = None  # of this client, with its key
    key: Optional[str] = None
    token_file: Optional[str] = None  # a token on one line, read again for each call; sent by TLS or on this machine only
    user: str = "python"  # a name for the server's log, trusted by nothing
    connect_deadline_s: float = 5.0  # how long connect() waits for the server; 0: until the first call
    call_deadline_s: float = 20.0  # of one call, its retries included
    stream_deadline_s: float = 1800.0  # of one upload, download or watch; a broken stream is resumed
    give_up_after_s: float = 60.0  # a transfer ends after so long without progress
    first_backoff_s: float = 0.1  # wait between attempts: doubles from first to max, with chance in it
    max_backoff_s: float = 1.0
    chunk_readings: int = 1000  # readings in a chunk, 1 to 4096
    window_chunks: int = 8  # chunks on the way at a time, 1 to 64

    def __post_init__(self) -> None:
        def require(holds: bool, text: str) -> None:
            if not holds:
                raise InvalidArgument(text)

        require(0 < len(self.user) <= 200 and self.user.isascii() and self.user.isprintable(),
                f"user = {self.user!r}, must be 1 to 200 printable ASCII characters")
        require((self.certificate is None) == (self.key is None), "certificate and key must be set together")
        require(self.ca is not None or self.certificate is None, "ca must name the authority of the server's certificate")
        require(self.connect_deadline_s >= 0, f"connect_deadline_s = {self.connect_deadline_s}, must be >= 0")
        for field in ("call_deadline_s", "stream_deadline_s", "give_up_after_s", "first_backoff_s"):
            require(getattr(self, field) > 0, f"{field} = {getattr(self, field)}, must be > 0")
        require(self.max_backoff_s >= self.first_backoff_s, f"max_backoff_s = {self.max_backoff_s}, must be >= first_backoff_s")
        require(1 <= self.chunk_readings <= MAX_CHUNK_READINGS, f"chunk_readings = {self.chunk_readings}, must be 1 to {MAX_CHUNK_READINGS}")
        require(1 <= self.window_chunks <= 64, f"window_chunks = {self.window_chunks}, must be 1 to 64")

    @classmethod
    def read(cls, **given: Any) -> "Options":
        """`given` where it is not None, else the environment, else the default."""
        values = {}
        for field in dataclasses.fields(cls):
            value = given.pop(field.name, None)
            variable = "AXISCAL_" + field.name.upper()
            if value is None and os.environ.get(variable):
                value = os.environ[variable]
                try:
                    value = {"float": float, "int": int}.get(getattr(field.type, "__name__", str(field.type)), str)(value)
                except ValueError:
                    raise InvalidArgument(f"{variable} = {value!r}, must be a number") from None
            if value is not None:
                values[field.name] = os.fspath(value) if isinstance(value, pathlib.PurePath) else value
        if given:
            raise TypeError(f"connect() has no option {', '.join(given)}")
        return cls(**values)


def read_token(file: str) -> str:
    """The token of a file that holds one, on one line."""
    try:
        with open(file, "rb") as stream:
            token = stream.read(MAX_TOKEN_BYTES + 1).rstrip(b"\r\n ")
    except OSError as error:
        raise InvalidArgument(f"{file}: {error.strerror}") from None
    if not token or len(token) > MAX_TOKEN_BYTES or not all(0x20 < byte < 0x7F for byte in token):
        raise InvalidArgument(f"{file}: must hold one token on one line")
    return token.decode("ascii")


# Nobody between can read what goes there (client/client.cc has the same list).
_THIS_MACHINE = ("unix:", "unix-abstract:", "127.", "ipv4:127.", "[::1]:", "ipv6:[::1]:", "localhost:", "dns:localhost:", "dns:///localhost:")


def require_safe_token(address: str, options: Options) -> None:
    """A token is neither sent readable over a network nor missing at the start."""
    if options.token_file is None:
        return
    read_token(options.token_file)
    if options.ca is None and not address.startswith(_THIS_MACHINE):
        raise InvalidArgument(f"a token for {address} would go over the network readable: name the server's authority (ca)")
