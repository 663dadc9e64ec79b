"""What a call fails with. proto/README.md of the checkout lists codes and reasons."""
import functools
import importlib.resources
from typing import Any, Dict, List, Mapping, Optional, Tuple, Type

import grpc
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory


class Error(Exception):
    """A call, or a step of it, failed and changed nothing.

    code: the gRPC status, "NOT_FOUND".
    reason: stable word for programs, "SESSION_NOT_FOUND"; empty where the server gave none.
    facts: what belongs to the reason, {"seq": "3"}.
    fields: (path of a field of the request, what is wrong with it).
    retry_after_s: wait that the server asks for before the call is tried again.
    """

    code = "UNKNOWN"

    def __init__(self, message: str, reason: str = "", facts: Optional[Mapping[str, str]] = None,
                 fields: Tuple[Tuple[str, str], ...] = (), retry_after_s: Optional[float] = None,
                 code: Optional[str] = None) -> None:
        super().__init__(f"{message} [{reason}]" if reason else message)
        self.message = message
        self.reason = reason
        self.facts: Dict[str, str] = dict(facts or {})
        self.fields = fields
        self.retry_after_s = retry_after_s
        if code is not None:
            self.code = code


class InvalidArgument(Error, ValueError):
    """Something given is wrong; the text names place, value and rule."""
    code = "INVALID_ARGUMENT"


class NotFound(Error, LookupError):
    """Nothing is there, or nothing that this caller may see."""
    code = "NOT_FOUND"


class AlreadyExists(Error):
    """Other content is there under this name."""
    code = "ALREADY_EXISTS"


class OutOfRange(Error):
    """A part is missing before this one."""
    code = "OUT_OF_RANGE"


class FailedPrecondition(Error):
    """Not in this state."""
    code = "FAILED_PRECONDITION"


class Aborted(Error):
    """Somebody else changed it meanwhile: read again."""
    code = "ABORTED"


class ResourceExhausted(Error):
    """A limit is reached; `retry_after_s` says when to come again."""
    code = "RESOURCE_EXHAUSTED"


class PermissionDenied(Error, PermissionError):
    """Too small a role; the text names the role."""
    code = "PERMISSION_DENIED"


class Unauthenticated(Error):
    """No identity was shown, or one that is not known."""
    code = "UNAUTHENTICATED"


class Unavailable(Error, ConnectionError):
    """The server is not there (reason NO_CONNECTION), went away (CONNECTION_LOST), stops, or its store is busy: come again later."""
    code = "UNAVAILABLE"


class DeadlineExceeded(Error, TimeoutError):
    """The time for the call is over. What it asked for may have happened: repeat it with the same request id."""
    code = "DEADLINE_EXCEEDED"


class DataLoss(Error):
    """What was stored or sent has changed on the way; nothing wrong is handed out."""
    code = "DATA_LOSS"


class Cancelled(Error):
    """The call, or the job, was cancelled."""
    code = "CANCELLED"


_CLASSES: Dict[str, Type[Error]] = {
    error.code: error
    for error in (InvalidArgument, NotFound, AlreadyExists, OutOfRange, FailedPrecondition, Aborted, ResourceExhausted, PermissionDenied,
                  Unauthenticated, Unavailable, DeadlineExceeded, DataLoss, Cancelled)
}


def make(code: str, message: str, reason: str = "", facts: Optional[Mapping[str, str]] = None,
         fields: Tuple[Tuple[str, str], ...] = (), retry_after_s: Optional[float] = None) -> Error:
    """The error of the class of `code`."""
    return _CLASSES.get(code, Error)(message, reason, facts, fields, retry_after_s, code)


@functools.lru_cache(maxsize=None)
def _details_class(name: str) -> Any:
    # google.rpc is read from a pool of its own: googleapis-common-protos, where it is installed, has its own copy in the default one.
    files = descriptor_pb2.FileDescriptorSet.FromString(importlib.resources.files("axiscal.v1").joinpath("google_rpc.desc").read_bytes())
    pool = descriptor_pool.DescriptorPool()
    for file in files.file:
        pool.Add(file)
    descriptor = pool.FindMessageTypeByName(name)
    if hasattr(message_factory, "GetMessageClass"):  # protobuf 4.22 and later
        return message_factory.GetMessageClass(descriptor)
    return message_factory.MessageFactory(pool).GetPrototype(descriptor)


def _is_of_connection(code: str, message: str) -> bool:
    """gRPC says so, or a proxy: the service sends details with each error. A stream whose server was killed ends as UNKNOWN "Stream removed"."""
    return code == "UNAVAILABLE" or message == "Stream removed" or (message.startswith("Received RST_STREAM") and code != "RESOURCE_EXHAUSTED")


def from_grpc(error: grpc.RpcError) -> Error:
    """What a failed call says of itself, with the details that the server sent."""
    code = error.code().name
    message = error.details() or "the server gave no reason"
    trailing: List[Tuple[str, Any]] = list(error.trailing_metadata() or ())
    packed = next((value for key, value in trailing if key == "grpc-status-details-bin"), None)
    reason, facts, fields, retry_after_s = "", {}, [], None
    if packed is None and _is_of_connection(code, message):
        text = (f"the connection broke off ({message}): the server ended, or the network did. What it had acknowledged is kept; repeat the call when it "
                "answers again, or at another replica of it")
        return make("UNAVAILABLE", text, "CONNECTION_LOST")
    if packed is not None:
        status = _details_class("google.rpc.Status").FromString(packed)
        message = status.message or message
        for detail in status.details:
            name = detail.type_url.rpartition("/")[2]
            if name == "google.rpc.ErrorInfo":
                info = _details_class(name).FromString(detail.value)
                reason, facts = info.reason, dict(info.metadata)
            elif name == "google.rpc.BadRequest":
                bad = _details_class(name).FromString(detail.value)
                fields += [(violation.field, violation.description) for violation in bad.field_violations]
            elif name == "google.rpc.RetryInfo":
                delay = _details_class(name).FromString(detail.value).retry_delay
                retry_after_s = delay.seconds + delay.nanos / 1e9
    return make(code, message, reason, facts, tuple(fields), retry_after_s)
