"""A measuring session: header entries and named columns, as its file holds them (docs/formats.md, "Measuring session").

Read here is what makes a session of a file. Whether its keys, columns and readings are those of its instrument and machine is judged by
the server, which refuses a wrong one with its place and keeps nothing of it.
"""
import dataclasses
import hashlib
import os
import pathlib
import struct
from typing import Any, Iterable, List, Mapping, Optional, Tuple, Union

import numpy as np
import pandas as pd

from axiscal._crc32c import crc32c
from axiscal.errors import InvalidArgument
from axiscal.v1 import session_pb2

PathLike = Union[str, "os.PathLike[str]"]

# Columns of names; all others are numbers (core/session/instrument_format.cc).
TEXT_COLUMNS = ("feature", "rod", "run", "target")
MAX_SESSION_BYTES = 256 << 20  # core/session/line_reader.h
_NEWLINE = b"\n"
_NUMBER_CHARACTERS = frozenset("0123456789+-.eE")


@dataclasses.dataclass(frozen=True)
class Column:
    """values: float64, NaN where a cell is empty. texts: of a column of names, else None."""
    name: str
    values: Optional[Any] = None
    texts: Optional[List[str]] = None

    def __len__(self) -> int:
        return len(self.values if self.texts is None else self.texts)  # type: ignore[arg-type]


class Session:
    """Header entries (a key may repeat) and columns of equal length, in the order of the file."""

    def __init__(self, header: Iterable[Tuple[str, str]], columns: Iterable[Column]) -> None:
        self.header: List[Tuple[str, str]] = [(str(key), str(value)) for key, value in header]
        self.columns: List[Column] = list(columns)
        for key, value in self.header:
            if not key or ":" in key or (key + value).isspace() or key != key.strip(" ") or value != value.strip(" ") or "\n" in key + value:
                raise _refuse(f"header entry {key!r}: {value!r}, expected '# key: value' on one line, without blanks around")
        if not self.columns or len(self) == 0:
            raise _refuse("no readings, expected at least one")
        for column in self.columns:
            if len(column) != len(self):
                raise _refuse(f"column {column.name}: {len(column)} cells, expected {len(self)}")

    def __len__(self) -> int:
        return len(self.columns[0]) if self.columns else 0

    def __repr__(self) -> str:
        return f"<Session {self.get('session')!r} of machine {self.get('machine')!r}: {len(self)} readings of {self.get('instrument')!r}>"

    def get(self, key: str) -> Optional[str]:
        """The first value of a header key, or None."""
        return next((value for name, value in self.header if name == key), None)

    @classmethod
    def read(cls, path: PathLike) -> "Session":
        """A session file. InvalidArgument with file, line, column, value and rule."""
        try:
            data = pathlib.Path(path).read_bytes()
        except OSError as error:
            raise InvalidArgument(f"{path}: {error.strerror}") from None
        try:
            return cls.parse(data)
        except InvalidArgument as error:
            raise _refuse(f"{os.fspath(path)}: {error.message}") from None

    @classmethod
    def parse(cls, data: bytes) -> "Session":
        """The content of a session file."""
        if len(data) > MAX_SESSION_BYTES:
            raise _refuse(f"{len(data)} bytes, a session file has at most {MAX_SESSION_BYTES} ({MAX_SESSION_BYTES >> 20} MB): split the session")
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise _refuse(f"line {data.count(_NEWLINE, 0, error.start) + 1}: not UTF-8") from None
        if "\0" in text:
            raise _refuse(f"line {text.count(chr(10), 0, text.index(chr(0))) + 1}: a NUL byte: no text file")
        lines = text.split("\n")
        if lines.pop() != "":
            raise _refuse(f"line {len(lines) + 1}: the last line has no line end: is the file cut off?")
        lines = [line[:-1] if line.endswith("\r") else line for line in lines]
        header: List[Tuple[str, str]] = []
        for line in lines:
            if not line.startswith("#"):
                break
            key, colon, value = line[1:].partition(":")
            if not colon:
                raise _refuse(f"line {len(header) + 1}: {line!r}, expected '# key: value'")
            header.append((key.strip(" "), value.strip(" ")))
        if not header:
            raise _refuse(f"line 1: {lines[0] if lines else ''!r}, expected header lines '# key: value' first")
        if len(lines) < len(header) + 2:
            raise _refuse(f"line {len(lines)}: no readings follow, expected column names and at least one reading")
        names = lines[len(header)].split(",")
        first_line = len(header) + 2
        rows = [line.split(",") for line in lines[first_line - 1:]]
        for number, row in enumerate(rows):
            if len(row) != len(names):
                raise _refuse(f"line {first_line + number}: {len(row)} cells, expected {len(names)}")
        columns = [_column_of_cells(name, [row[index] for row in rows], index, first_line) for index, name in enumerate(names)]
        return cls(header, columns)

    @classmethod
    def from_frame(cls, frame: pd.DataFrame, header: Mapping[str, Any]) -> "Session":
        """Of a frame whose columns bear the names of the format, with units (X_mm, B_deg, dL_mm); the index is left out.

        header: "machine", "session", "instrument", "sigma_um" ...; a list is written with blanks between: tool_tip_mm=[0, 0, -356.4]. A key that
        stands several times has a list of texts.
        """
        entries: List[Tuple[str, str]] = []
        for key, value in header.items():
            if isinstance(value, (list, tuple, np.ndarray)):
                if all(isinstance(item, str) for item in value):
                    entries += [(key, item) for item in value]
                else:
                    entries.append((key, " ".join(repr(float(item)) for item in value)))
            elif isinstance(value, (pd.Timestamp,)) or hasattr(value, "isoformat"):
                if value.tzinfo is None:
                    raise _refuse(f"header key {key}: {value} has no time zone")
                entries.append((key, value.isoformat()))
            else:
                entries.append((key, value if isinstance(value, str) else repr(value)))
        return cls(entries, [_column_of_series(str(name), frame.iloc[:, place]) for place, name in enumerate(frame.columns)])

    def to_frame(self) -> pd.DataFrame:
        """float64 columns, and columns of names as objects."""
        return pd.DataFrame({column.name: column.values if column.texts is None else pd.Series(column.texts, dtype=object)
                             for column in self.columns})

    def to_csv(self) -> str:
        """As its file, with the shortest decimals that read back as the same numbers."""
        cells = [["" if value != value else repr(value).removesuffix(".0") for value in column.values.tolist()] if column.texts is None and
                 column.values is not None else column.texts or [] for column in self.columns]
        lines = [f"# {key}: {value}" for key, value in self.header]
        lines.append(",".join(column.name for column in self.columns))
        lines += [",".join(row) for row in zip(*cells)]
        return "\n".join(lines) + "\n"

    # ---- how it travels

    def schema(self) -> session_pb2.SessionSchema:
        number, text = session_pb2.COLUMN_KIND_NUMBER, session_pb2.COLUMN_KIND_TEXT
        return session_pb2.SessionSchema(
            header=[session_pb2.HeaderEntry(key=key, value=value) for key, value in self.header],
            columns=[session_pb2.ColumnSchema(name=column.name, kind=number if column.texts is None else text) for column in self.columns])

    def content_id(self, machine: str, chunk_readings: int) -> str:
        """The request id of its upload, as core/records/chunked_session.cc makes it: the same session is stored once, whichever client sends it."""
        sha = hashlib.sha256()

        def add(text: str) -> None:
            data = text.encode()
            sha.update(b"%d:%s" % (len(data), data))

        add(machine)
        add(str(chunk_readings))
        for key, value in self.header:
            add(key)
            add(value)
        for column in self.columns:
            add(column.name)
            if column.texts is None:
                add(f"{len(column)},0")
                sha.update(_bytes_of(column.values))
            else:
                add(f"0,{len(column)}")
                for text in column.texts:
                    add(text)
        return sha.hexdigest()

    def chunk(self, seq: int, chunk_readings: int) -> session_pb2.Chunk:
        part = slice(seq * chunk_readings, (seq + 1) * chunk_readings)
        message = session_pb2.Chunk(seq=seq)
        crc = 0
        for column in self.columns:
            cells = message.columns.add()
            if column.texts is None:
                values = column.values[part]  # type: ignore[index]
                cells.values.extend(values.tolist())
                crc = crc32c(_bytes_of(values), crc)
            else:
                cells.texts.extend(column.texts[part])
                crc = crc32c(b"".join(struct.pack("<I", len(text)) + text for text in (cell.encode() for cell in column.texts[part])), crc)
        message.crc32c = crc
        return message

    @classmethod
    def from_messages(cls, schema: session_pb2.SessionSchema, chunks: Iterable[session_pb2.Chunk]) -> "Session":
        """Of what DownloadSession sends; the chunks' checksums have been compared."""
        chunks = list(chunks)
        columns = []
        for index, column in enumerate(schema.columns):
            if column.kind == session_pb2.COLUMN_KIND_TEXT:
                columns.append(Column(column.name, None, [text for chunk in chunks for text in chunk.columns[index].texts]))
            else:
                columns.append(Column(column.name, np.concatenate([np.array(chunk.columns[index].values, np.float64) for chunk in chunks])))
        return cls([(entry.key, entry.value) for entry in schema.header], columns)


def chunk_crc32c(chunk: session_pb2.Chunk, schema: session_pb2.SessionSchema) -> int:
    """What the checksum of a chunk must be (core/session/checksum.h)."""
    crc = 0
    for column, cells in zip(schema.columns, chunk.columns):
        if column.kind == session_pb2.COLUMN_KIND_TEXT:
            crc = crc32c(b"".join(struct.pack("<I", len(text)) + text for text in (cell.encode() for cell in cells.texts)), crc)
        else:
            crc = crc32c(_bytes_of(np.array(cells.values, np.float64)), crc)
    return crc


def session_hash(crcs: Iterable[int]) -> str:
    """The SHA-256 that closes a session (core/session/checksum.h)."""
    return hashlib.sha256(b"".join(struct.pack("<I", crc) for crc in crcs)).hexdigest()


def _refuse(text: str) -> InvalidArgument:
    return InvalidArgument(text, "SESSION_INVALID")


def _bytes_of(values: Any) -> bytes:
    return np.ascontiguousarray(values, dtype="<f8").tobytes()


def _column_of_cells(name: str, cells: List[str], index: int, first_line: int) -> Column:
    if name in TEXT_COLUMNS:
        return Column(name, None, cells)
    values = np.empty(len(cells), np.float64)
    try:
        if not _NUMBER_CHARACTERS.issuperset("".join(cells)):
            raise ValueError
        values[:] = [float(cell) if cell else np.nan for cell in cells]
        if np.isinf(values).any():
            raise ValueError
    except ValueError:
        row = next(row for row, cell in enumerate(cells) if cell and not _is_number(cell))
        raise _refuse(f"line {first_line + row}, column {index + 1} ({name}): {cells[row]!r}, expected a number with a decimal point") from None
    return Column(name, values)


def _is_number(cell: str) -> bool:
    try:
        return _NUMBER_CHARACTERS.issuperset(cell) and bool(np.isfinite(float(cell)))
    except ValueError:
        return False


def _column_of_series(name: str, series: pd.Series) -> Column:
    if name in TEXT_COLUMNS:
        bad = [row for row, cell in enumerate(series) if not isinstance(cell, str)]
        if bad:
            raise _refuse(f"column {name}, row {bad[0]}: {series.iloc[bad[0]]!r}, expected a text")
        return Column(name, None, list(series))
    if not pd.api.types.is_numeric_dtype(series.dtype) or pd.api.types.is_bool_dtype(series.dtype) or series.dtype.kind == "c":
        raise _refuse(f"column {name}: type {series.dtype}, expected numbers" +
                      ("; times are seconds in t_s" if pd.api.types.is_datetime64_any_dtype(series.dtype) else ""))
    values = series.to_numpy(dtype=np.float64, na_value=np.nan)
    wrong = np.flatnonzero(np.isinf(values))
    if len(wrong):
        raise _refuse(f"column {name}, row {wrong[0]}: {values[wrong[0]]}, expected a finite number")
    return Column(name, values)
