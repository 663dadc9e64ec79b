"""What the service stores, as plain data: messages of proto/axiscal/v1 with tz-aware times and None for what is absent."""
import dataclasses
import datetime
import enum
from typing import Any, Dict, Optional, Tuple, Type, TypeVar, Union

from axiscal import reports
from axiscal.v1 import calibration_pb2, job_pb2, session_pb2

_EPOCH = datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)
_Enum = TypeVar("_Enum", bound=enum.Enum)


def utc(microseconds: int) -> datetime.datetime:
    """The time of microseconds since 1970-01-01 UTC."""
    return _EPOCH + datetime.timedelta(microseconds=microseconds)


def utc_us(time: datetime.datetime) -> int:
    """The other way; ValueError for a time without zone, which could mean several."""
    if time.tzinfo is None:
        raise ValueError(f"{time} has no time zone")
    return (time - _EPOCH) // datetime.timedelta(microseconds=1)


def _optional_utc(message: Any, field: str) -> Optional[datetime.datetime]:
    return utc(getattr(message, field)) if message.HasField(field) else None


def _optional(message: Any, field: str) -> Any:
    return getattr(message, field) if message.HasField(field) else None


def _word(words: Type[_Enum], enum_type: Any, prefix: str, value: int) -> _Enum:
    """A value of a newer server that is not known here is UNKNOWN."""
    name = enum_type.Name(value) if value in enum_type.values() else ""
    return words.__members__.get(name[len(prefix):], words.__members__["UNKNOWN"])


class SessionState(enum.Enum):
    OPEN = "open"  # accepts readings; no job uses it
    COMPLETE = "complete"  # never changes again
    ABORTED = "aborted"
    EXPIRED = "expired"
    UNKNOWN = "unknown"


class JobState(enum.Enum):
    QUEUED = "queued"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"
    DEAD = "dead"  # failed max_attempts times, or its server died with it ten times
    UNKNOWN = "unknown"

    @property
    def has_ended(self) -> bool:
        return self in (JobState.SUCCEEDED, JobState.FAILED, JobState.CANCELLED, JobState.DEAD)


class CalibrationState(enum.Enum):
    CANDIDATE = "candidate"
    APPROVED = "approved"  # in use; at most one of a machine
    RETIRED = "retired"
    UNKNOWN = "unknown"


UNITS: Dict[int, str] = {calibration_pb2.ESTIMATE_UNIT_UM: "um", calibration_pb2.ESTIMATE_UNIT_URAD: "urad"}


@dataclasses.dataclass(frozen=True)
class MachineRecord:
    id: str
    description_json: str  # machine.json (docs/formats.md)
    etag: int  # revision of the description
    created: datetime.datetime
    updated: datetime.datetime
    deleted: Optional[datetime.datetime]

    @classmethod
    def from_message(cls, message: Any) -> "MachineRecord":
        return cls(message.machine_id, message.description_json, message.etag, utc(message.created_utc_us), utc(message.updated_utc_us),
                   _optional_utc(message, "deleted_utc_us"))


@dataclasses.dataclass(frozen=True)
class SessionRecord:
    id: int
    machine: str
    name: str
    instrument: str
    state: SessionState
    readings: int
    created: datetime.datetime
    closed: Optional[datetime.datetime]
    measured: Optional[datetime.datetime]  # the header's `started`
    created_by: str
    sha256: str
    note: str  # what people say of it
    labels: Tuple[str, ...]
    is_rejected: bool  # it does not count
    reason: str  # why

    @classmethod
    def from_message(cls, message: Any) -> "SessionRecord":
        return cls(message.session_id, message.machine_id, message.name, message.instrument,
                   _word(SessionState, session_pb2.SessionState, "SESSION_STATE_", message.state), message.readings,
                   utc(message.created_utc_us), _optional_utc(message, "closed_utc_us"), _optional_utc(message, "measured_utc_us"),
                   message.created_by, message.sha256, message.remark.note, tuple(message.remark.labels), message.remark.is_rejected,
                   message.remark.reason)


@dataclasses.dataclass(frozen=True)
class JobProgress:
    fraction: float  # 0 to 1, never falling within an attempt
    stage: str
    detail: str


@dataclasses.dataclass(frozen=True)
class JobError:
    code: int  # gRPC status
    reason: str
    message: str


AnyReport = Union[reports.Identification, reports.Loop, reports.Rewrite, reports.ToolSetter]

_REPORTS: Dict[str, Any] = {
    "identify": reports.Identification,
    "close_loop": reports.Loop,
    "compensate": reports.Rewrite,
    "tool_setter": reports.ToolSetter,
}


@dataclasses.dataclass(frozen=True)
class Job:
    id: int
    kind: str  # identify, close_loop, compensate, tool_setter
    params: Any  # axiscal.v1.job_pb2.JobParams
    state: JobState
    progress: JobProgress
    attempt: int
    error: Optional[JobError]  # FAILED, DEAD
    calibration_id: Optional[int]  # the candidate that it made
    program_ids: Tuple[int, ...]
    report_json: str  # empty in lists
    created: datetime.datetime
    started: Optional[datetime.datetime]
    finished: Optional[datetime.datetime]
    created_by: str

    @property
    def report(self) -> AnyReport:
        """The report of a job that has succeeded (docs/formats.md). ValueError where there is none, as in lists."""
        if not self.report_json:
            raise ValueError(f"job {self.id} ({self.state.value}) has no report here")
        if self.kind not in _REPORTS:
            raise ValueError(f"job {self.id} is of the kind {self.kind!r}, whose report this version does not know")
        report: AnyReport = reports.read(_REPORTS[self.kind], self.report_json)
        return report

    @classmethod
    def from_message(cls, message: Any) -> "Job":
        error = JobError(message.error.code, message.error.reason, message.error.message) if message.HasField("error") else None
        return cls(message.job_id, message.params.WhichOneof("kind") or "", message.params,
                   _word(JobState, job_pb2.JobState, "JOB_STATE_", message.state),
                   JobProgress(message.progress.fraction, message.progress.stage, message.progress.detail), message.attempt, error,
                   _optional(message.result, "calibration_id"), tuple(message.result.program_ids), message.result.report_json,
                   utc(message.created_utc_us), _optional_utc(message, "started_utc_us"), _optional_utc(message, "finished_utc_us"),
                   message.created_by)


@dataclasses.dataclass(frozen=True)
class Estimate:
    """error = actual - nominal."""
    symbol: str
    value: Optional[float]  # in `unit`; None where the data cannot tell
    sigma: Optional[float]  # one standard uncertainty
    unit: str
    identifiable: bool


@dataclasses.dataclass(frozen=True)
class Calibration:
    id: int
    machine: str
    version: int
    state: CalibrationState
    etag: int
    created: datetime.datetime
    approved: Optional[datetime.datetime]
    approved_by: str
    retired: Optional[datetime.datetime]
    measured: datetime.datetime  # the time at which it stands in the history
    session_ids: Tuple[int, ...]
    job_id: int
    chi2_per_dof: Optional[float]
    rms_before_um: Optional[float]
    rms_after_um: Optional[float]
    estimates: Tuple[Estimate, ...]
    not_separable: Tuple[str, ...]  # "EX0B - EX0C": directions that change no reading
    model_json: str  # errors.json; empty in lists
    report_json: str  # empty in lists
    rejected_session_ids: Tuple[int, ...]  # of its sessions, those that were rejected since: it counts no more

    @property
    def report(self) -> Union[reports.Identification, reports.Loop]:
        """Of the identification, or of the loop, that made it. ValueError in lists, which have none."""
        if not self.report_json:
            raise ValueError(f"calibration {self.id} has no report here")
        return reports.read_calibration(self.report_json)

    @classmethod
    def from_message(cls, message: Any) -> "Calibration":
        estimates = tuple(Estimate(estimate.symbol, _optional(estimate, "value"), _optional(estimate, "sigma"), UNITS.get(estimate.unit, ""),
                                   estimate.identifiable) for estimate in message.estimates)
        statistics = message.statistics
        return cls(message.calibration_id, message.machine_id, message.version,
                   _word(CalibrationState, calibration_pb2.CalibrationState, "CALIBRATION_STATE_", message.state), message.etag,
                   utc(message.created_utc_us), _optional_utc(message, "approved_utc_us"), message.approved_by,
                   _optional_utc(message, "retired_utc_us"), utc(message.provenance.measured_utc_us), tuple(message.provenance.session_ids),
                   message.provenance.job_id, _optional(statistics, "chi2_per_dof"), _optional(statistics, "rms_before_um"),
                   _optional(statistics, "rms_after_um"), estimates, tuple(message.not_separable), message.model_json, message.report_json,
                   tuple(message.rejected_session_ids))


@dataclasses.dataclass(frozen=True)
class ProgramRecord:
    id: int
    name: str
    size_bytes: int
    sha256: str
    created: datetime.datetime
    kind: str
    created_by: str

    @classmethod
    def from_message(cls, message: Any) -> "ProgramRecord":
        return cls(message.program_id, message.name, message.size_bytes, message.sha256, utc(message.created_utc_us), message.kind,
                   message.created_by)


@dataclasses.dataclass(frozen=True)
class ServerInfo:
    software_version: str
    schema_version: int
    open_uploads: int
    max_uploads: int
    workers: int
    draining: bool

    @classmethod
    def from_message(cls, message: Any) -> "ServerInfo":
        return cls(message.software_version, message.schema_version, message.open_uploads, message.max_uploads, message.workers,
                   message.draining)
