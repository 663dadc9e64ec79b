"""Controllers' logs to the server, as they are (docs/logs.md)."""
import dataclasses
import hashlib
import pathlib
from typing import Optional, Tuple

from axiscal import _programs, errors
from axiscal._connection import Connection
from axiscal._upload import ProgressCallback
from axiscal.records import SessionRecord
from axiscal.session import PathLike
from axiscal.v1 import ingest_service_pb2

# Names of formats that need no template; ingest_service.proto, LogForm.template_text.
KNOWN_FORMATS = ("dprnt", "linuxcnc-probe", "sinumerik-write")


@dataclasses.dataclass(frozen=True)
class StoredLog:
    """What became of a log."""
    session: SessionRecord
    was_there: bool  # it had been stored before
    log_program_id: int  # get_program() gives the log back, byte for byte
    notes: Tuple[str, ...]  # for people: what was missing and what was filled in
    first_line: int  # of the log: of the first reading
    last_line: int  # of the last one
    cut_line: int  # the log stopped within it, and no reading was made of it; 0: it did not


def _text(path: PathLike) -> str:
    try:
        return _programs.read_bytes(path).decode("utf-8")
    except UnicodeDecodeError as error:
        raise errors.InvalidArgument(f"{path}: byte {error.start + 1} is no UTF-8") from None


def put(connection: Connection, machine: str, path: PathLike, template: PathLike, plan: Optional[PathLike], session_name: str,
        start_s: Optional[float], progress: Optional[ProgressCallback]) -> StoredLog:
    data = _programs.read_bytes(path)
    form = ingest_service_pb2.LogForm(session_name=session_name)
    if str(template) in KNOWN_FORMATS:
        form.template_text = str(template)
    else:
        form.template_text, form.template_name = _text(template), pathlib.Path(template).name
    if plan is not None:
        form.plan_text, form.plan_name = _text(plan), pathlib.Path(plan).name
    if start_s is not None:
        form.start_s = start_s
    name, sha256 = pathlib.Path(path).name, hashlib.sha256(data).hexdigest()
    # As the C++ client has it: the same log, read in the same way, is the same request, whoever crashed in between.
    start = "" if start_s is None else f"{start_s:.17g}"
    texts = ("log", machine, name, form.template_text, form.template_name, form.plan_text, form.plan_name, session_name, start, sha256)
    request_id = hashlib.sha256("".join(f"{len(text.encode())}:{text}" for text in texts).encode()).hexdigest()
    header = ingest_service_pb2.PutLogHeader(machine_id=machine, name=name, size_bytes=len(data), sha256=sha256, request_id=request_id, form=form)
    response = _programs.send_whole(connection, "Ingest", "PutLog", ingest_service_pb2.PutLogRequest, header, data, progress)
    return StoredLog(SessionRecord.from_message(response.session), response.was_there, response.log.program_id, tuple(response.notes),
                     response.first_line, response.last_line, response.cut_line)
