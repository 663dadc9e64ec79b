"""What the service watches and does by itself, as plain data: what machines need, events, marks, expectations, routines, webhooks, cells."""
import dataclasses
import datetime
from typing import Any, Dict, Optional, Tuple

from axiscal.drift import Amount
from axiscal.records import UNITS, utc
from axiscal.v1 import access_service_pb2, admin_service_pb2, events_service_pb2, history_service_pb2, routines_service_pb2


def _optional(message: Any, field: str) -> Any:
    return getattr(message, field) if message.HasField(field) else None


def _time(message: Any, field: str) -> Optional[datetime.datetime]:
    return utc(getattr(message, field)) if message.HasField(field) else None


def _word(enum_type: Any, prefix: str, value: int) -> str:
    """ "out_of_tolerance"; a value of a newer server that is not known here is "unknown"."""
    return str(enum_type.Name(value))[len(prefix):].lower() if value in enum_type.values() else "unknown"


def name_of(enum_type: Any, prefix: str, word: str) -> str:
    """The other way, as the protos name it; ValueError for no such word."""
    words = [_word(enum_type, prefix, value) for value in enum_type.values() if value != 0]
    if word not in words:
        raise ValueError(f"{word!r}, must be one of {', '.join(words)}")
    return prefix + word.upper()


def scope_message(machine: str, group: str) -> access_service_pb2.Scope:
    """Of one machine, or a group, or of all where neither is given."""
    if machine and group:
        raise ValueError("give a machine or a group, not both")
    if machine:
        return access_service_pb2.Scope(machine=machine)
    return access_service_pb2.Scope(group=group) if group else access_service_pb2.Scope(all=True)


@dataclasses.dataclass(frozen=True)
class StandingFinding:
    """What the calibration in use cannot know of."""
    kind: str  # step, suspect, unstable (docs/drift.md)
    text: str
    at: datetime.datetime  # of the calibration with which it was found


@dataclasses.dataclass(frozen=True)
class MachineCare:
    """What a machine needs, at a glance."""
    machine: str
    care: str  # now (it has new events, or findings), decide (newer candidates wait), unknown (nothing is in use), good
    findings: Tuple[StandingFinding, ...]
    new_events: int  # that stand, are not on the shelf, and that nobody has acknowledged
    newest_event: str  # the words of the newest of these
    calibration: Optional[int]  # in use
    version: Optional[int]  # its, within the machine
    measured: Optional[datetime.datetime]  # when it holds
    rms_before_um: Optional[float]  # of its residuals
    rms_after_um: Optional[float]
    waiting: int  # candidates that were measured later than what is in use
    is_followed: bool  # the findings are of now
    groups: Tuple[str, ...]  # that it is in

    @classmethod
    def from_message(cls, message: Any) -> "MachineCare":
        used = message.in_use if message.HasField("in_use") else None
        findings = tuple(
            StandingFinding(_word(history_service_pb2.DriftFindingKind, "DRIFT_FINDING_KIND_", finding.kind), finding.text, utc(finding.at_utc_us))
            for finding in message.findings)
        return cls(message.machine_id, _word(history_service_pb2.Care, "CARE_", message.care), findings, message.new_events, message.newest_event,
                   used.calibration_id if used else None, used.version if used else None, utc(used.measured_utc_us) if used else None,
                   _optional(used, "rms_before_um") if used else None, _optional(used, "rms_after_um") if used else None, message.waiting,
                   message.is_followed, tuple(message.groups))


@dataclasses.dataclass(frozen=True)
class Event:
    """What people should hear of (docs/events.md)."""
    id: int
    machine: str
    kind: str  # out_of_tolerance, limit_forecast, step, suspect, unstable, wear, scatter, calibration_old, session_missed, model_lacks, ...
    subject: str  # the error, session or routine that it is about; empty: the machine
    text: str
    advice: str
    amounts: Tuple[Amount, ...]
    certainty: Optional[float]  # 0 to 1
    calibration: Optional[int]  # that shows it
    begins: Optional[datetime.datetime]
    ends: Optional[datetime.datetime]
    raised: datetime.datetime
    cleared: Optional[datetime.datetime]  # None: it stands
    cleared_why: str
    acknowledged: Optional[datetime.datetime]
    acknowledged_by: str
    acknowledged_note: str
    shelved_until: Optional[datetime.datetime]

    @classmethod
    def from_message(cls, message: Any) -> "Event":
        return cls(message.event_id, message.machine_id, _word(events_service_pb2.EventKind, "EVENT_KIND_", message.kind), message.subject,
                   message.text, message.advice,
                   tuple(Amount(amount.symbol, amount.size, amount.sigma, UNITS.get(amount.unit, "")) for amount in message.amounts),
                   _optional(message, "certainty"), _optional(message, "calibration_id"), _time(message, "from_utc_us"),
                   _time(message, "to_utc_us"), utc(message.raised_utc_us), _time(message, "cleared_utc_us"), message.cleared_why,
                   _time(message, "acknowledged_utc_us"), message.acknowledged_by, message.acknowledged_note,
                   _time(message, "shelved_until_utc_us"))


@dataclasses.dataclass(frozen=True)
class EventChange:
    """What became of an event."""
    number: int  # numbers only grow: whoever keeps the last one goes on behind it
    what: str  # raised, updated, cleared, acknowledged, shelved, back
    at: datetime.datetime
    by: str  # empty: the service itself
    note: str
    event: Event

    @classmethod
    def from_message(cls, message: Any) -> "EventChange":
        return cls(message.change_id, _word(events_service_pb2.EventChangeKind, "EVENT_CHANGE_KIND_", message.what), utc(message.at_utc_us),
                   message.by, message.note, Event.from_message(message.event))


@dataclasses.dataclass(frozen=True)
class Expectations:
    """What is expected of a machine (docs/events.md)."""
    tolerances: Dict[str, Tuple[float, float]]  # error -> low, high, um or urad as the error is
    sessions: Dict[str, int]  # name -> comes at least every so many hours
    calibration_days: Optional[int]  # how old what is in use may be
    counts_candidates: bool
    etag: int

    @classmethod
    def from_message(cls, response: Any) -> "Expectations":
        said = response.expectations
        return cls({limit.symbol: (limit.low, limit.high) for limit in said.tolerances},
                   {session.name: session.every_hours for session in said.sessions}, _optional(said, "calibration_days"),
                   said.counts_candidates, response.etag)


@dataclasses.dataclass(frozen=True)
class Mark:
    """What a person says has happened to a machine."""
    id: int
    machine: str
    at: datetime.datetime
    kind: str  # collision, service, refixturing
    symbols: Tuple[str, ...]  # the errors that it can have moved; empty: all
    note: str
    created_by: str
    created: datetime.datetime
    withdrawn_by: str  # empty: it counts
    withdrawn: Optional[datetime.datetime]

    @classmethod
    def from_message(cls, message: Any) -> "Mark":
        return cls(message.mark_id, message.machine_id, utc(message.at_utc_us),
                   _word(history_service_pb2.MarkKind, "MARK_KIND_", message.kind), tuple(message.symbols), message.note, message.created_by,
                   utc(message.created_utc_us), message.withdrawn_by, _time(message, "withdrawn_utc_us"))


@dataclasses.dataclass(frozen=True)
class Routine:
    """What runs by itself when sessions have come (docs/routines.md). What the server fills in has a default."""
    name: str
    principal: str  # that it acts as
    sessions: Tuple[str, ...]  # names of sessions to fit
    machine: str = ""  # for this machine, or
    group: str = ""  # for those of this group
    check_sessions: Tuple[str, ...] = ()  # close_loop: names of sessions to prove on
    within_hours: int = 24
    at_utc_minute: Optional[int] = None  # waits for that minute of a UTC day
    work: str = "identify"  # or close_loop
    declared_errors: Tuple[str, ...] = ()
    max_effects: Optional[int] = None
    budget_json: str = ""
    monte_carlo_runs: Optional[int] = None
    monte_carlo_seed: Optional[int] = None
    approve_within_um: Optional[float] = None  # None: it proposes
    disabled: bool = False
    note: str = ""
    etag: int = 0
    stopped: Tuple[str, ...] = ()  # machines on which a person has stopped it

    @classmethod
    def from_message(cls, message: Any) -> "Routine":
        return cls(message.name, message.principal, tuple(message.sessions), message.scope.machine, message.scope.group,
                   tuple(message.check_sessions), message.within_hours, _optional(message, "at_utc_minute"),
                   _word(routines_service_pb2.RoutineWork, "ROUTINE_WORK_", message.work), tuple(message.declared_errors),
                   _optional(message, "max_effects"), message.budget_json, _optional(message, "monte_carlo_runs"),
                   _optional(message, "monte_carlo_seed"), _optional(message, "approve_within_um"), message.disabled, message.note, message.etag,
                   tuple(stop.machine_id for stop in message.stops))

    def to_message(self) -> routines_service_pb2.Routine:
        """What a person says of it."""
        message = routines_service_pb2.Routine(
            name=self.name, scope=scope_message(self.machine, self.group), principal=self.principal, sessions=self.sessions,
            check_sessions=self.check_sessions, within_hours=self.within_hours,
            work=name_of(routines_service_pb2.RoutineWork, "ROUTINE_WORK_", self.work), declared_errors=self.declared_errors,
            budget_json=self.budget_json, disabled=self.disabled, note=self.note)
        for field in ("at_utc_minute", "max_effects", "monte_carlo_runs", "monte_carlo_seed", "approve_within_um"):
            value = getattr(self, field)
            if value is not None:
                setattr(message, field, value)
        return message


@dataclasses.dataclass(frozen=True)
class RoutineRun:
    id: int
    routine: str
    machine: str
    principal: str
    state: str  # waiting, running, agrees, proposed, approved, failed, stopped
    session_ids: Tuple[int, ...]
    check_session_ids: Tuple[int, ...]
    job_id: Optional[int]
    calibration_id: Optional[int]
    text: str  # what came out, or why it failed
    began: datetime.datetime
    ended: Optional[datetime.datetime]

    @classmethod
    def from_message(cls, message: Any) -> "RoutineRun":
        return cls(message.run_id, message.routine, message.machine_id, message.principal,
                   _word(routines_service_pb2.RoutineRunState, "ROUTINE_RUN_STATE_", message.state), tuple(message.session_ids),
                   tuple(message.check_session_ids), _optional(message, "job_id"), _optional(message, "calibration_id"), message.text,
                   utc(message.began_utc_us), _time(message, "ended_utc_us"))


@dataclasses.dataclass(frozen=True)
class Webhook:
    """An address that is told of events (docs/events.md)."""
    name: str
    url: str
    machine: str  # of this machine, or
    group: str  # of those of this group; both empty: of all
    disabled: bool
    note: str
    etag: int
    up_to_change: int  # changes up to this one were sent, or are dead letters
    tries: int
    last_error: str
    last_sent: Optional[datetime.datetime]
    dead_letters: int

    @classmethod
    def from_message(cls, message: Any) -> "Webhook":
        return cls(message.name, message.url, message.scope.machine, message.scope.group, message.disabled, message.note, message.etag,
                   message.up_to_change_id, message.tries, message.last_error, _time(message, "last_sent_utc_us"), message.dead_letters)


@dataclasses.dataclass(frozen=True)
class DeadLetter:
    change: int
    event: int
    machine: str
    tries: int
    error: str
    tried: datetime.datetime
    is_wanted: bool  # it is tried once more

    @classmethod
    def from_message(cls, message: Any) -> "DeadLetter":
        return cls(message.change_id, message.event_id, message.machine_id, message.tries, message.error, utc(message.tried_utc_us),
                   message.is_wanted)


@dataclasses.dataclass(frozen=True)
class Cell:
    """A PC beside a machine that brings its files (docs/cell.md), as it last said that it stands."""
    machine: str
    name: str
    is_silent: bool  # not heard for longer than `silent_after`
    problem: str  # what wants a person there; empty: nothing
    reported: datetime.datetime
    reported_by: str
    silence: datetime.timedelta  # since then, without the time that no server had the database
    silent_after: datetime.timedelta
    version: str
    waiting_files: int
    waiting_bytes: int
    quarantined_files: int
    quarantined_bytes: int
    max_bytes: int

    @classmethod
    def from_message(cls, message: Any) -> "Cell":
        report = message.report
        return cls(report.machine_id, report.name, message.is_silent, report.problem, utc(message.reported_utc_us), message.reported_by,
                   datetime.timedelta(microseconds=message.silence_us), datetime.timedelta(seconds=report.silent_after_s), report.version,
                   report.waiting_files, report.waiting_bytes, report.quarantined_files, report.quarantined_bytes, report.max_bytes)


@dataclasses.dataclass(frozen=True)
class Finding:
    """What the server says of one thing that was looked at (docs/operations.md, "Doctor")."""
    what: str
    state: str  # ok, warning, failed, unknown
    text: str
    advice: str  # what to do; empty where it is well

    @classmethod
    def from_message(cls, message: Any) -> "Finding":
        return cls(message.what, _word(admin_service_pb2.FindingState, "FINDING_STATE_", message.state), message.text, message.advice)
