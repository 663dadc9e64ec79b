"""Sessions to and from the server (proto/README.md, "Uploading a session")."""
import dataclasses
import threading
import time
from typing import Any, Callable, Iterator, List, Optional

from axiscal import errors
from axiscal._connection import Backoff, Connection, is_broken
from axiscal.records import SessionRecord
from axiscal.session import Session, chunk_crc32c, session_hash
from axiscal.v1 import ingest_service_pb2, session_pb2


@dataclasses.dataclass(frozen=True)
class Progress:
    """How far a transfer is: readings of a session, bytes of a program that the other side has for sure."""
    done: int
    total: int
    interruptions: int = 0


ProgressCallback = Callable[[Progress], Any]


@dataclasses.dataclass(frozen=True)
class Upload:
    session: SessionRecord  # COMPLETE
    was_there: bool  # had been uploaded before: nothing was sent
    duplicate_chunks: int  # sent again although the server had them
    interruptions: int


class _Acknowledgements:
    """What the answers of one stream said: read by one thread, waited for by the one that sends."""

    def __init__(self, next_seq: int) -> None:
        self._changed = threading.Condition()
        self._next_seq = next_seq
        self._is_over = False

    def take(self, next_seq: int, is_over: bool) -> None:
        with self._changed:
            self._next_seq = max(self._next_seq, next_seq)
            self._is_over |= is_over
            self._changed.notify_all()

    def wait_for_room(self, seq: int, window: int) -> bool:
        """Until a chunk of that seq may be sent; False when the stream is over."""
        with self._changed:
            self._changed.wait_for(lambda: self._is_over or seq < self._next_seq + window)
            return not self._is_over


class _Uploader:
    def __init__(self, connection: Connection, session: Session, progress: Optional[ProgressCallback]) -> None:
        self._connection = connection
        self._session = session
        self._progress = progress
        self._chunk_readings = connection.options.chunk_readings
        self._chunk_count = -(-len(session) // self._chunk_readings)
        self._crcs: List[Optional[int]] = [None] * self._chunk_count
        self._window = 1
        self._next_seq = 0
        self._record: Any = None
        self._duplicates = 0
        self._interruptions = 0
        self._reported = -1

    def run(self, request: ingest_service_pb2.CreateSessionRequest) -> Upload:
        created = self._connection.call("Ingest", "CreateSession", request)
        self._record = created.session
        was_there = self._is_complete()
        self._window = max(1, min(self._connection.options.window_chunks, created.window_chunks, 64))
        self._next_seq = created.session.next_seq
        if not was_there:
            self._send_until_complete()
        self._report(self._chunk_count)
        return Upload(SessionRecord.from_message(self._record), was_there, self._duplicates, self._interruptions)

    def _is_complete(self) -> bool:
        return bool(self._record.state == session_pb2.SESSION_STATE_COMPLETE)

    def _send_until_complete(self) -> None:
        options = self._connection.options
        backoff, give_up = Backoff(options), time.monotonic() + options.give_up_after_s
        while True:
            before = self._next_seq
            error = self._run_stream()
            if self._is_complete():
                return
            if error is not None and not is_broken(error):
                raise error
            self._interruptions += 1
            if self._next_seq > before:
                backoff, give_up = Backoff(options), time.monotonic() + options.give_up_after_s
            # The server may know more than the last acknowledgement that came through; it may even be complete.
            while True:
                if not backoff.wait(give_up):
                    raise error or errors.make("UNAVAILABLE", "the server ends the stream before its end")
                try:
                    asked = ingest_service_pb2.GetSessionRequest(session_id=self._record.session_id)
                    self._record = self._connection.call("Ingest", "GetSession", asked).session
                    break
                except errors.Error as again:
                    if not is_broken(again):
                        raise
            self._next_seq = self._record.next_seq
            if self._is_complete():
                return

    def _run_stream(self) -> Optional[errors.Error]:
        """One stream from next_seq on, as far as it gets. None with an open session: it ended before its end."""
        acknowledged = _Acknowledgements(self._next_seq)
        duplicates = 0
        try:
            call = self._connection.open_stream("Ingest", "Upload", self._requests(self._next_seq, acknowledged))
            for response in self._connection.read_stream(call):
                acknowledged.take(response.next_seq, response.refused)
                self._next_seq = max(self._next_seq, response.next_seq)
                duplicates = response.duplicate_chunks
                if response.HasField("completed_session"):
                    self._record = response.completed_session
                self._report(self._next_seq)
            return None
        except errors.Error as error:
            return error
        finally:
            acknowledged.take(0, True)
            self._duplicates += duplicates

    def _requests(self, first_seq: int, acknowledged: _Acknowledgements) -> Iterator[ingest_service_pb2.UploadRequest]:
        header = ingest_service_pb2.UploadHeader(session_id=self._record.session_id, resume_from_seq=first_seq)
        yield ingest_service_pb2.UploadRequest(header=header)
        for seq in range(first_seq, self._chunk_count):
            if not acknowledged.wait_for_room(seq, self._window):
                return
            chunk = self._session.chunk(seq, self._chunk_readings)
            self._crcs[seq] = chunk.crc32c
            yield ingest_service_pb2.UploadRequest(chunk=chunk)
        yield ingest_service_pb2.UploadRequest(finish=ingest_service_pb2.UploadFinish(totals=self._totals()))

    def _totals(self) -> session_pb2.SessionTotals:
        crcs = [self._session.chunk(seq, self._chunk_readings).crc32c if crc is None else crc for seq, crc in enumerate(self._crcs)]
        return session_pb2.SessionTotals(chunks=self._chunk_count, readings=len(self._session), sha256=session_hash(crcs))

    def _report(self, durable_chunks: int) -> None:
        if self._progress is not None and durable_chunks != self._reported:
            self._reported = durable_chunks
            done = min(len(self._session), durable_chunks * self._chunk_readings)
            self._progress(Progress(done, len(self._session), self._interruptions))


def upload(connection: Connection, machine: str, session: Session, request_id: Optional[str],
           progress: Optional[ProgressCallback]) -> Upload:
    request = ingest_service_pb2.CreateSessionRequest(
        machine_id=machine, request_id=request_id or session.content_id(machine, connection.options.chunk_readings), schema=session.schema())
    return _Uploader(connection, session, progress).run(request)


def download(connection: Connection, session_id: int) -> Session:
    """Whole, with every checksum compared. A stream that breaks is asked for again from its beginning."""
    options = connection.options
    backoff, give_up = Backoff(options), time.monotonic() + options.give_up_after_s
    while True:
        schema: Any = None
        chunks: List[Any] = []
        totals: Any = None
        try:
            call = connection.open_stream("Ingest", "DownloadSession", ingest_service_pb2.DownloadSessionRequest(session_id=session_id))
            for message in connection.read_stream(call):
                part = message.WhichOneof("part")
                if part == "schema":
                    schema = message.schema
                elif part == "chunk":
                    chunks.append(message.chunk)
                elif part == "totals":
                    totals = message.totals
            if totals is not None:
                break
            error = errors.make("UNAVAILABLE", "the session ended before its end")
        except errors.Error as raised:
            error = raised
        if not is_broken(error) or not backoff.wait(give_up):
            raise error
    for chunk in chunks:
        if chunk_crc32c(chunk, schema) != chunk.crc32c:
            raise errors.make("DATA_LOSS", f"session {session_id}, chunk {chunk.seq}: its checksum does not fit what came")
    if len(chunks) != totals.chunks or session_hash(chunk.crc32c for chunk in chunks) != totals.sha256:
        raise errors.make("DATA_LOSS", f"session {session_id}: its checksum does not fit what came")
    return Session.from_messages(schema, chunks)
