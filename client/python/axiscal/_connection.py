"""The channel, and calls over it that are tried again."""
import os
import random
import secrets
import threading
import time
import uuid
from typing import Any, Callable, Dict, Iterator, List, Optional, Tuple

import grpc

from axiscal import errors
from axiscal._options import Options, read_token, require_safe_token
from axiscal.v1 import (access_service_pb2_grpc, admin_service_pb2_grpc, calibrations_service_pb2_grpc, events_service_pb2_grpc,
                        history_service_pb2_grpc, ingest_service_pb2_grpc, jobs_service_pb2_grpc, machines_service_pb2_grpc,
                        programs_service_pb2_grpc, routines_service_pb2_grpc, tables_service_pb2_grpc, webhooks_service_pb2_grpc)

_STUBS: Dict[str, Callable[[Any], Any]] = {
    "Access": access_service_pb2_grpc.AccessStub,
    "Admin": admin_service_pb2_grpc.AdminStub,
    "Calibrations": calibrations_service_pb2_grpc.CalibrationsStub,
    "Events": events_service_pb2_grpc.EventsStub,
    "History": history_service_pb2_grpc.HistoryStub,
    "Ingest": ingest_service_pb2_grpc.IngestStub,
    "Jobs": jobs_service_pb2_grpc.JobsStub,
    "Machines": machines_service_pb2_grpc.MachinesStub,
    "Programs": programs_service_pb2_grpc.ProgramsStub,
    "Routines": routines_service_pb2_grpc.RoutinesStub,
    "Tables": tables_service_pb2_grpc.TablesStub,
    "Webhooks": webhooks_service_pb2_grpc.WebhooksStub,
}

_KEEPALIVE_MS, _KEEPALIVE_TIMEOUT_MS = 30_000, 10_000
# gRPC's own wait between attempts to connect would grow to two minutes.
_FIRST_RECONNECT_MS, _MAX_RECONNECT_MS = 100, 1_000
# The server keeps its messages below 4 MiB but for drift, where 100,000 points of each of 1000 errors may come in one.
_MAX_MESSAGE_BYTES = 1 << 30
# After a deadline: how long a server that is there may take to say so.
_PROBE_S = 1.0

# gRPC's threads do not live on in a child of os.fork(): calls there would wait for ever.
_grpc_began_in: Optional[int] = None


def new_request_id() -> str:
    """An id under which a call that creates may be repeated."""
    return uuid.uuid4().hex


def is_broken(error: errors.Error) -> bool:
    """Whether a stream that ended so may be resumed."""
    return error.code in ("UNAVAILABLE", "DEADLINE_EXCEEDED")


class Backoff:
    """Waits that double, each between half and all of its size so that many clients do not come back together."""

    def __init__(self, options: Options) -> None:
        self._next_s = options.first_backoff_s
        self._max_s = options.max_backoff_s

    def wait(self, until: float) -> bool:
        """False, without waiting, where the time would be over."""
        wait_s = self._next_s * random.uniform(0.5, 1.0)
        if time.monotonic() + wait_s >= until:
            return False
        time.sleep(wait_s)
        self._next_s = min(2 * self._next_s, self._max_s)
        return True


class Connection:
    """Safe from any thread. The channel is opened by the first call."""

    def __init__(self, address: str, options: Options) -> None:
        require_safe_token(address, options)
        self.address = address
        self.options = options
        self._credentials = _credentials(options)
        self._trace_id = secrets.token_hex(16)
        self._lock = threading.Lock()
        self._channel: Optional[Any] = None
        self._stubs: Dict[str, Any] = {}
        self._is_closed = False

    def wait_until_connected(self, seconds: float) -> None:
        """Unavailable, NO_CONNECTION when the server is not there in time."""
        if self._answers(seconds, wait_for_ready=True):
            return
        why = f"no server at {self.address} within {seconds:g} s"
        if self.options.ca is None:
            why += "; one with TLS answers only to clients that name its authority (ca)"
        else:
            why += f"; or its certificate is not from {self.options.ca}, has another name, or it wants a certificate (or another one) from here"
        self.close()
        raise errors.make("UNAVAILABLE", why, "NO_CONNECTION")

    def _answers(self, seconds: float, wait_for_ready: bool) -> bool:
        """Asks for the server's health, which is open to all. gRPC's own watch of the connection is a thread that polls and outlives close()."""
        ask = self.channel().unary_unary("/grpc.health.v1.Health/Check", lambda request: b"", lambda response: b"")
        try:
            ask(None, timeout=seconds, wait_for_ready=wait_for_ready)
        except grpc.RpcError as error:
            return error.code() not in (grpc.StatusCode.DEADLINE_EXCEEDED, grpc.StatusCode.UNAVAILABLE)
        return True

    def channel(self) -> Any:
        global _grpc_began_in
        if _grpc_began_in not in (None, os.getpid()):
            raise RuntimeError("gRPC began in the parent of this process and does not work in a child of os.fork(): "
                               "use multiprocessing's start method 'spawn', or connect after the fork only")
        with self._lock:
            if self._is_closed:
                raise ValueError("the client is closed")
            if self._channel is None:
                _grpc_began_in = os.getpid()
                arguments: List[Tuple[str, Any]] = [("grpc.keepalive_time_ms", _KEEPALIVE_MS),
                                                    ("grpc.keepalive_timeout_ms", _KEEPALIVE_TIMEOUT_MS),
                                                    ("grpc.initial_reconnect_backoff_ms", _FIRST_RECONNECT_MS),
                                                    ("grpc.min_reconnect_backoff_ms", _FIRST_RECONNECT_MS),
                                                    ("grpc.max_reconnect_backoff_ms", _MAX_RECONNECT_MS),
                                                    ("grpc.max_receive_message_length", _MAX_MESSAGE_BYTES)]
                if self._credentials is None:
                    self._channel = grpc.insecure_channel(self.address, arguments)
                else:
                    self._channel = grpc.secure_channel(self.address, self._credentials, arguments)
            return self._channel

    def close(self) -> None:
        """Ends calls that are under way, too."""
        with self._lock:
            channel, self._channel, self._is_closed = self._channel, None, True
            self._stubs.clear()
        if channel is not None:
            channel.close()

    def stub(self, service: str) -> Any:
        channel = self.channel()
        with self._lock:
            if service not in self._stubs:
                if service not in _STUBS:
                    raise errors.InvalidArgument(f"{service}: no such service, expected one of {', '.join(_STUBS)}")
                self._stubs[service] = _STUBS[service](channel)
            return self._stubs[service]

    def metadata(self) -> Tuple[Tuple[str, str], ...]:
        # W3C Trace Context: each attempt is a step of this connection's trace, in the server's log and in the jobs that it creates.
        metadata: List[Tuple[str, str]] = [("axiscal-user", self.options.user),
                                           ("traceparent", f"00-{self._trace_id}-{secrets.token_hex(8)}-01")]
        if self.options.token_file is not None:
            try:
                metadata.append(("authorization", "Bearer " + read_token(self.options.token_file)))
            except errors.InvalidArgument:
                pass  # as no token, while the file is being replaced: the server says what it misses
        return tuple(metadata)

    def call(self, service: str, method: str, request: Any, deadline_s: Optional[float] = None) -> Any:
        """A call that is tried again while the answer is UNAVAILABLE, as the same message with the same request id."""
        end = time.monotonic() + (self.options.call_deadline_s if deadline_s is None else deadline_s)
        backoff = Backoff(self.options)
        function = getattr(self.stub(service), method)
        while True:
            try:
                return function(request, timeout=max(0.0, end - time.monotonic()), metadata=self.metadata(), wait_for_ready=True)
            except grpc.RpcError as raw:
                error = self.error(raw)
                if error.code != "UNAVAILABLE" or error.reason == "NO_CONNECTION" or not backoff.wait(end):
                    raise error from None

    def open_stream(self, service: str, method: str, requests: Any) -> Any:
        """The call of a stream, not tried again here."""
        function = getattr(self.stub(service), method)
        return function(requests, timeout=self.options.stream_deadline_s, metadata=self.metadata(), wait_for_ready=False)

    def send_stream(self, service: str, method: str, requests: Any) -> Any:
        """The one answer to a stream that is sent, not tried again here."""
        try:
            return self.open_stream(service, method, requests)
        except grpc.RpcError as raw:
            raise self.error(raw) from None

    def read_stream(self, call: Any) -> Iterator[Any]:
        """The answers of `call`; an error as ours. Leaving the loop early ends the call."""
        try:
            yield from call
        except grpc.RpcError as raw:
            raise self.error(raw) from None
        finally:
            call.cancel()

    def error(self, raw: grpc.RpcError) -> errors.Error:
        error = errors.from_grpc(raw)
        if error.code == "DEADLINE_EXCEEDED" and not error.reason and not self._is_closed and not self._answers(_PROBE_S, False):
            return errors.make("UNAVAILABLE", f"no connection to {self.address}", "NO_CONNECTION")
        return error


def _credentials(options: Options) -> Optional[grpc.ChannelCredentials]:
    def read(path: Optional[str]) -> Optional[bytes]:
        if path is None:
            return None
        try:
            with open(path, "rb") as stream:
                return stream.read()
        except OSError as error:
            raise errors.InvalidArgument(f"{path}: {error.strerror}") from None

    if options.ca is None:
        return None
    return grpc.ssl_channel_credentials(read(options.ca), read(options.key), read(options.certificate))
