"""NC programs to and from the server, byte for byte."""
import hashlib
import os
import pathlib
import tempfile
import time
from typing import Any, BinaryIO, Callable, Iterator, Optional

from axiscal import errors, reports
from axiscal._connection import Backoff, Connection, new_request_id
from axiscal._crc32c import crc32c
from axiscal._upload import Progress, ProgressCallback
from axiscal.records import ProgramRecord
from axiscal.session import PathLike
from axiscal.v1 import job_pb2, programs_service_pb2

_PART_BYTES = 256 << 10  # proto/axiscal/v1/programs_service.proto


def read_bytes(path: PathLike) -> bytes:
    try:
        return pathlib.Path(path).read_bytes()
    except OSError as error:
        raise errors.InvalidArgument(f"{os.fspath(path)}: {error.strerror}") from None


def _parts(data: bytes) -> Iterator[bytes]:
    for offset in range(0, len(data), _PART_BYTES):
        yield data[offset:offset + _PART_BYTES]


def write_whole(path: PathLike, fill: Callable[[BinaryIO], Any]) -> Any:
    """Makes `path` of what `fill` writes, on the disk and whole, or leaves it as it was."""
    target = pathlib.Path(path)
    try:
        handle, name = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    except OSError as error:
        raise errors.InvalidArgument(f"{os.fspath(path)}: {error.strerror}") from None
    try:
        with os.fdopen(handle, "wb") as stream:
            result = fill(stream)
            stream.flush()
            os.fsync(stream.fileno())
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(name, 0o666 & ~mask)  # as of any new file: mkstemp's are for their owner alone
        os.replace(name, target)
    except BaseException:
        os.unlink(name)
        raise
    return result


def send_whole(connection: Connection, service: str, method: str, request: Any, header: Any, data: bytes,
               progress: Optional[ProgressCallback]) -> Any:
    """What answers a header (made for `data`) and then the bytes; sent again whole where the stream breaks. `request` makes its messages."""
    def requests(interruptions: int) -> Iterator[Any]:
        yield request(header=header)
        sent = 0
        for part in _parts(data):
            yield request(data=part)
            sent += len(part)
            if progress is not None:
                progress(Progress(sent, len(data), interruptions))

    backoff = Backoff(connection.options)
    give_up = time.monotonic() + connection.options.give_up_after_s
    interruptions = 0
    while True:
        try:
            return connection.send_stream(service, method, requests(interruptions))
        except errors.Error as error:
            is_cut = error.code == "UNAVAILABLE" or error.reason == "STREAM_INCOMPLETE"
            if not is_cut or not backoff.wait(give_up):
                raise
        interruptions += 1


def put(connection: Connection, path: PathLike, progress: Optional[ProgressCallback]) -> ProgramRecord:
    data = read_bytes(path)
    header = programs_service_pb2.PutProgramHeader(name=pathlib.Path(path).name, size_bytes=len(data), sha256=hashlib.sha256(data).hexdigest(),
                                                   request_id=new_request_id())
    response = send_whole(connection, "Programs", "PutProgram", programs_service_pb2.PutProgramRequest, header, data, progress)
    return ProgramRecord.from_message(response.program)


def get(connection: Connection, program_id: int, path: PathLike, progress: Optional[ProgressCallback]) -> ProgramRecord:
    def fill(stream: BinaryIO) -> ProgramRecord:
        options = connection.options
        sha, received, record, interruptions = hashlib.sha256(), 0, None, 0
        backoff, give_up = Backoff(options), time.monotonic() + options.give_up_after_s
        while True:
            error: Optional[errors.Error] = None
            try:
                request = programs_service_pb2.GetProgramRequest(program_id=program_id, offset_bytes=received)
                for message in connection.read_stream(connection.open_stream("Programs", "GetProgram", request)):
                    if message.WhichOneof("part") == "program":
                        record = ProgramRecord.from_message(message.program)
                        continue
                    stream.write(message.data)
                    sha.update(message.data)
                    received += len(message.data)
                    give_up = time.monotonic() + options.give_up_after_s
                    if progress is not None and record is not None:
                        progress(Progress(received, record.size_bytes, interruptions))
            except errors.Error as raised:
                error = raised
            if error is None and record is not None and received == record.size_bytes:
                break
            if error is not None and error.code != "UNAVAILABLE":
                raise error
            if not backoff.wait(give_up):
                raise error or errors.make("UNAVAILABLE", "the program ended before its end")
            interruptions += 1
        if sha.hexdigest() != record.sha256:
            raise errors.make("DATA_LOSS", f"program {program_id}: its checksum does not fit what came")
        return record

    record: ProgramRecord = write_whole(path, fill)
    return record


def compensate(connection: Connection, params: job_pb2.CompensateParams, source: PathLike, target: PathLike) -> reports.Rewrite:
    """Not tried again by itself: what came of a broken stream is no program."""
    data = read_bytes(source)

    def requests() -> Iterator[Any]:
        header = programs_service_pb2.RewriteProgramHeader(params=params, size_bytes=len(data), crc32c=crc32c(data))
        yield programs_service_pb2.RewriteProgramRequest(header=header)
        for part in _parts(data):
            yield programs_service_pb2.RewriteProgramRequest(data=part)

    def fill(stream: BinaryIO) -> reports.Rewrite:
        crc, received, result = 0, 0, None
        for message in connection.read_stream(connection.open_stream("Programs", "RewriteProgram", requests())):
            if message.WhichOneof("part") == "result":
                result = message.result
                continue
            stream.write(message.data)
            crc = crc32c(message.data, crc)
            received += len(message.data)
        if result is None or result.size_bytes != received or result.crc32c != crc:
            raise errors.make("DATA_LOSS", "the rewritten program's size and checksum do not fit what came")
        return reports.read(reports.Rewrite, result.report_json)

    report: reports.Rewrite = write_whole(target, fill)
    return report
