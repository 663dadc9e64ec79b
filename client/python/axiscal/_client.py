"""The client: one object, safe from any thread, whose calls block."""
import datetime
import json
import os
import time
from typing import Any, Callable, Iterable, Iterator, Mapping, Optional, Sequence, Tuple, Union

import grpc
import pandas as pd

from axiscal import _logs, _programs, _upload, errors, reports
from axiscal._connection import Backoff, Connection, is_broken, new_request_id
from axiscal._logs import StoredLog
from axiscal._options import Options
from axiscal._upload import ProgressCallback, Upload
from axiscal._watching import Watching
from axiscal.drift import DriftReport, points_frame, residuals_frame, volumetric_frame
from axiscal.records import (Calibration, CalibrationState, Job, JobState, MachineRecord, ProgramRecord, ServerInfo, SessionRecord,
                             SessionState, utc_us)
from axiscal.session import PathLike, Session
from axiscal.v1 import (admin_service_pb2, calibration_pb2, calibrations_service_pb2, history_service_pb2, ingest_service_pb2, job_pb2,
                        jobs_service_pb2, machines_service_pb2, programs_service_pb2, session_pb2, volumetric_pb2)

_UNITS = {None: job_pb2.PROGRAM_UNIT_UNSPECIFIED, "mm": job_pb2.PROGRAM_UNIT_MILLIMETRE, "inch": job_pb2.PROGRAM_UNIT_INCH}
_ON_UNSUPPORTED = {"refuse": job_pb2.ON_UNSUPPORTED_REFUSE, "pass": job_pb2.ON_UNSUPPORTED_PASS, "stop": job_pb2.ON_UNSUPPORTED_STOP}
MM_PER_UM = 1e-3
# The most that QueryDrift gives of one error; docs of the field in proto/axiscal/v1/history_service.proto.
MAX_POINTS = 100_000


class Client(Watching):
    """Made by connect(); a context manager, which closes the connection.

    Calls have a deadline, wait for the server to be there and are tried again while it is UNAVAILABLE; a failed call changed nothing.
    What creates takes a `request_id`: the same id again gives what was made then, so that a call may be repeated after a crash.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def close(self) -> None:
        self._connection.close()

    def call(self, service: str, method: str, request: Any, deadline_s: Optional[float] = None) -> Any:
        """Any call of proto/axiscal/v1 that is no stream: call("Tables", "MakeTable", tables_service_pb2.MakeTableRequest(...))."""
        return self._connection.call(service, method, request, deadline_s)

    def _pages(self, service: str, method: str, request: Any, field: str) -> Iterator[Any]:
        while True:
            response = self.call(service, method, request)
            yield from getattr(response, field)
            if not response.next_page_token:
                return
            request.page_token = response.next_page_token

    # ---- machines

    def create_machine(self, description: Union[PathLike, Mapping[str, Any]]) -> MachineRecord:
        """Of a machine.json, or its content as a dict. The same description again gives the machine that is there."""
        if isinstance(description, Mapping):
            text = json.dumps(description)
        else:
            try:
                with open(description, encoding="utf-8") as stream:
                    text = stream.read()
            except OSError as error:
                raise errors.InvalidArgument(f"{os.fspath(description)}: {error.strerror}") from None
        response = self.call("Machines", "CreateMachine", machines_service_pb2.CreateMachineRequest(description_json=text))
        return MachineRecord.from_message(response.machine)

    def machine(self, machine: str) -> MachineRecord:
        response = self.call("Machines", "GetMachine", machines_service_pb2.GetMachineRequest(machine_id=machine))
        return MachineRecord.from_message(response.machine)

    def machines(self) -> Iterator[MachineRecord]:
        """In the order of their ids."""
        for message in self._pages("Machines", "ListMachines", machines_service_pb2.ListMachinesRequest(), "machines"):
            yield MachineRecord.from_message(message)

    # ---- sessions

    def upload(self, machine: str, session: Union[Session, PathLike], progress: Optional[ProgressCallback] = None,
               request_id: Optional[str] = None) -> Upload:
        """Stores a session, or a session file, durably; resumed where the server stands when the stream breaks.

        Without a request id it is the session's content, so that the same session is stored once, whoever crashed in between.
        InvalidArgument names the place of what is wrong; then the session stays out of sight.
        """
        return _upload.upload(self._connection, machine, session if isinstance(session, Session) else Session.read(session), request_id, progress)

    def upload_log(self, machine: str, log: PathLike, template: PathLike, plan: Optional[PathLike] = None, *, session_name: str = "",
                   start_s: Optional[float] = None, progress: Optional[ProgressCallback] = None) -> StoredLog:
        """Stores a controller's log as it is; the server reduces it to a session and keeps both (docs/logs.md).

        template: a file, or the name of a known format ("dprnt", "linuxcnc-probe", "sinumerik-write"). plan: the file of the plan that was run.
        InvalidArgument (LOG_INVALID; `facts` has line, column, name) where it is wrong: then nothing is stored. The same log is stored once.
        """
        return _logs.put(self._connection, machine, log, template, plan, session_name, start_s, progress)

    def session(self, session_id: int) -> SessionRecord:
        response = self.call("Ingest", "GetSession", ingest_service_pb2.GetSessionRequest(session_id=session_id))
        return SessionRecord.from_message(response.session)

    def annotate(self, session_id: int, note: str = "", labels: Sequence[str] = ()) -> SessionRecord:
        """Replaces a session's note and labels."""
        request = ingest_service_pb2.AnnotateSessionRequest(session_id=session_id, note=note, labels=labels)
        return SessionRecord.from_message(self.call("Ingest", "AnnotateSession", request).session)

    def reject(self, session_id: int, reason: str, is_rejected: bool = True) -> Tuple[int, ...]:
        """Says that a session does not count, or counts again; the calibrations that stand on it, which are marked."""
        request = ingest_service_pb2.RejectSessionRequest(session_id=session_id, is_rejected=is_rejected, reason=reason)
        return tuple(self.call("Ingest", "RejectSession", request).calibration_ids)

    def sessions(self, machine: str = "", state: Optional[SessionState] = None, *, instrument: str = "", name: str = "", label: str = "",
                 start: Optional[datetime.datetime] = None, end: Optional[datetime.datetime] = None) -> Iterator[SessionRecord]:
        """Newest first. start <= measured < end; where a file does not say when it was measured, created."""
        number = 0 if state is None else session_pb2.SessionState.Value(f"SESSION_STATE_{state.name}")
        request = ingest_service_pb2.ListSessionsRequest(machine_id=machine, state=number, instrument=instrument, name=name, label=label)
        _set_span(request, start, end)
        for message in self._pages("Ingest", "ListSessions", request, "sessions"):
            yield SessionRecord.from_message(message)

    def download(self, session_id: int) -> Session:
        """A complete session, every checksum compared."""
        return _upload.download(self._connection, session_id)

    # ---- jobs

    def identify(self, machine: str, sessions: Sequence[int], declared_errors: Sequence[str] = (), *, monte_carlo_runs: Optional[int] = None,
                 budget_json: str = "", held_calibration: Optional[int] = None, request_id: Optional[str] = None) -> Job:
        """Queues the fit of the machine's declared errors, or of `declared_errors`, to sessions; the result is a candidate calibration."""
        params = job_pb2.IdentifyParams(machine_id=machine, session_ids=sessions, declared_errors=declared_errors, budget_json=budget_json)
        if monte_carlo_runs is not None:
            params.monte_carlo_runs = monte_carlo_runs
        if held_calibration is not None:
            params.held_calibration_id = held_calibration
        return self.create_job(job_pb2.JobParams(identify=params), request_id)

    def close_loop(self, machine: str, fit: Sequence[int], check: Sequence[int] = (), *, max_effects: Optional[int] = None,
                   request_id: Optional[str] = None) -> Job:
        """Queues the search for what the declared model lacks, proved on the check sessions; the result is a candidate calibration."""
        params = job_pb2.CloseLoopParams(machine_id=machine, fit_session_ids=fit, check_session_ids=check)
        if max_effects is not None:
            params.max_effects = max_effects
        return self.create_job(job_pb2.JobParams(close_loop=params), request_id)

    def create_job(self, params: job_pb2.JobParams, request_id: Optional[str] = None, *, priority: int = 0,
                   deadline: Optional[datetime.datetime] = None) -> Job:
        """Any kind of job. The same request id with the same params gives the job that was made with it.

        priority: -10 to 10, higher ones run first. deadline: what has not ended by then fails (JOB_TOO_LATE)."""
        request = jobs_service_pb2.CreateJobRequest(request_id=request_id or new_request_id(), params=params, priority=priority)
        if deadline is not None:
            request.deadline_utc_us = utc_us(deadline)
        return Job.from_message(self.call("Jobs", "CreateJob", request).job)

    def job(self, job_id: int) -> Job:
        return Job.from_message(self.call("Jobs", "GetJob", jobs_service_pb2.GetJobRequest(job_id=job_id)).job)

    def jobs(self, machine: str = "", state: Optional[JobState] = None, *, kind: str = "", start: Optional[datetime.datetime] = None,
             end: Optional[datetime.datetime] = None) -> Iterator[Job]:
        """Newest first, without reports. start <= created < end. kind: as Job.kind."""
        number = 0 if state is None else job_pb2.JobState.Value(f"JOB_STATE_{state.name}")
        request = jobs_service_pb2.ListJobsRequest(machine_id=machine, state=number, kind=kind)
        _set_span(request, start, end)
        for message in self._pages("Jobs", "ListJobs", request, "jobs"):
            yield Job.from_message(message)

    def cancel_job(self, job_id: int) -> Job:
        return Job.from_message(self.call("Jobs", "CancelJob", jobs_service_pb2.CancelJobRequest(job_id=job_id)).job)

    def watch(self, job: Union[Job, int]) -> Iterator[Job]:
        """The job now and after each change, until it has ended; goes on over a restart of the server."""
        job_id = job.id if isinstance(job, Job) else job
        options = self._connection.options
        backoff, give_up = Backoff(options), time.monotonic() + options.give_up_after_s
        while True:
            error: Optional[errors.Error] = None
            try:
                call = self._connection.open_stream("Jobs", "WatchJob", jobs_service_pb2.WatchJobRequest(job_id=job_id))
                for message in self._connection.read_stream(call):
                    now = Job.from_message(message.job)
                    yield now
                    backoff, give_up = Backoff(options), time.monotonic() + options.give_up_after_s
                    if now.state.has_ended:
                        return
            except errors.Error as raised:
                error = raised
            if error is not None and not is_broken(error):
                raise error
            if not backoff.wait(give_up):
                raise error or errors.make("UNAVAILABLE", f"the watch of job {job_id} ended before the job")

    def wait(self, job: Union[Job, int], progress: Optional[Callable[[Job], Any]] = None) -> Job:
        """The job as it succeeded; `progress` is called with it after each change. Where it failed, an error of its code and reason; Cancelled
        where it was cancelled."""
        last: Optional[Job] = None
        for last in self.watch(job):
            if progress is not None:
                progress(last)
        assert last is not None
        if last.state is JobState.SUCCEEDED:
            return last
        if last.error is not None:
            code = next((status.name for status in grpc.StatusCode if status.value[0] == last.error.code), "UNKNOWN")
            raise errors.make(code, f"job {last.id}: {last.error.message}", last.error.reason)
        raise errors.make("CANCELLED", f"job {last.id} was cancelled")

    # ---- calibrations

    def calibration(self, calibration_id: int) -> Calibration:
        request = calibrations_service_pb2.GetCalibrationRequest(calibration_id=calibration_id)
        return Calibration.from_message(self.call("Calibrations", "GetCalibration", request).calibration)

    def approved_calibration(self, machine: str) -> Calibration:
        """The one in use. NotFound where there is none."""
        request = calibrations_service_pb2.GetCalibrationRequest(approved_of_machine_id=machine)
        return Calibration.from_message(self.call("Calibrations", "GetCalibration", request).calibration)

    def calibrations(self, machine: str = "", state: Optional[CalibrationState] = None, *, session: Optional[int] = None,
                     start: Optional[datetime.datetime] = None, end: Optional[datetime.datetime] = None) -> Iterator[Calibration]:
        """Newest first, without model and report; those that stand on `session`. start <= measured < end."""
        number = 0 if state is None else calibration_pb2.CalibrationState.Value(f"CALIBRATION_STATE_{state.name}")
        request = calibrations_service_pb2.ListCalibrationsRequest(machine_id=machine, state=number, session_id=session)
        _set_span(request, start, end)
        for message in self._pages("Calibrations", "ListCalibrations", request, "calibrations"):
            yield Calibration.from_message(message)

    def residuals(self, calibration_id: int, session: Optional[int] = None) -> pd.DataFrame:
        """What a calibration leaves of each number that its sessions, or one of them, read: a row for each.

        Columns: session, reading (from 1), row (int64; 0, or 0 to 2 for x, y, z), a column for each axis ("X_mm", "C_deg"; where it was taken),
        time_s, temperature_celsius (float64, NaN where the file has none), before_um, after_um (float64; measured - predicted, without and with
        the calibration's errors, set-ups fitted in both), is_set_aside (bool; the whole reading where one of its numbers is).
        """
        request = calibrations_service_pb2.ListResidualsRequest(calibration_id=calibration_id, session_id=session, page_size=10_000)
        pages = []
        while True:
            page = self.call("Calibrations", "ListResiduals", request)
            pages.append(page)
            if not page.next_page_token:
                return residuals_frame(pages)
            request.page_token = page.next_page_token

    def volumetric(self, machine: str, box: Optional[Mapping[str, Tuple[float, float]]] = None) -> pd.DataFrame:
        """How far the tool point is off over a box before and after each calibration of a machine, the oldest first; no rows where there is none.

        box: {"X": (0, 200), "C": (0, 360)}, mm and degrees, as of a part; other axes, or all, go over what was measured. Columns: calibration
        (int64), measured (datetime64[ns, UTC]), state, known_share (share of the box that was measured; elsewhere it is extrapolated), poses
        (int64), and for each of uncorrected, before, after and each of rms, median, p95, max: "after_rms", and "after_rms_low", "after_rms_high"
        (95 %), um, float64, NaN where nothing is known; problem (why, else empty). Work offset and tool centre are taken up.
        """
        spans = [volumetric_pb2.AxisSpan(axis=axis, from_mm_or_deg=low, to_mm_or_deg=high) for axis, (low, high) in (box or {}).items()]
        request = calibrations_service_pb2.ListVolumetricErrorsRequest(machine_id=machine, box=spans, page_size=100)
        return volumetric_frame(list(self._pages("Calibrations", "ListVolumetricErrors", request, "errors")))

    def compare(self, calibration_id: int, with_calibration: Optional[int] = None,
                box: Optional[Mapping[str, Tuple[float, float]]] = None) -> calibrations_service_pb2.CompareCalibrationsResponse:
        """What a calibration says otherwise than another one (none named: the one in use), and how far the tool point would move over `box` (as of
        volumetric) if it took the other's place. All differences are of calibration_id less the other; docs/compare.md. NotFound where none is in use."""
        spans = [volumetric_pb2.AxisSpan(axis=axis, from_mm_or_deg=low, to_mm_or_deg=high) for axis, (low, high) in (box or {}).items()]
        request = calibrations_service_pb2.CompareCalibrationsRequest(
            calibration_id=calibration_id, with_calibration_id=with_calibration, box=spans)
        response: calibrations_service_pb2.CompareCalibrationsResponse = self.call("Calibrations", "CompareCalibrations", request)
        return response

    def approve(self, calibration: Calibration, reason: str = "") -> Calibration:
        """Puts it in use, as it was read: Aborted where somebody has changed it meanwhile. The reason stands in the audit."""
        request = calibrations_service_pb2.ApproveCalibrationRequest(
            calibration_id=calibration.id, etag=calibration.etag, reason=reason)
        return Calibration.from_message(self.call("Calibrations", "ApproveCalibration", request).calibration)

    def retire(self, calibration: Calibration, reason: str = "") -> Calibration:
        """Takes it out of use, or gives a candidate up. The reason stands in the audit."""
        request = calibrations_service_pb2.RetireCalibrationRequest(
            calibration_id=calibration.id, etag=calibration.etag, reason=reason)
        return Calibration.from_message(self.call("Calibrations", "RetireCalibration", request).calibration)

    # ---- history

    def drift(self, machine: str, symbols: Iterable[str] = (), start: Optional[datetime.datetime] = None,
              end: Optional[datetime.datetime] = None, max_points: int = MAX_POINTS) -> pd.DataFrame:
        """The identified errors of a machine over time, a row for each point, ordered by symbol and time; no rows where there is nothing.

        Columns: symbol, unit (object; "um", "urad"), first, last (datetime64[ns, UTC]), count, calibration (int64), min, max, mean, sigma
        (float64; sigma is one standard uncertainty of the last estimate, NaN where it has none). With `count` 1 a point is one estimate;
        where an error has more than max_points they are gathered, and min and max keep what is farthest out. start <= time < end.
        """
        request = history_service_pb2.QueryDriftRequest(machine_id=machine, symbols=symbols, max_points=max_points)
        if start is not None:
            request.from_utc_us = utc_us(start)
        if end is not None:
            request.to_utc_us = utc_us(end)
        return points_frame(self.call("History", "QueryDrift", request))

    def find_drift(self, machine: str, limits: Optional[Mapping[str, Tuple[float, float]]] = None, *,
                   counts_candidates: bool = False) -> DriftReport:
        """Steps, wear, seasons, in words and numbers (docs/drift.md), and when errors leave their limits: {"EX0C": (-20, 20)}, um or urad."""
        request = history_service_pb2.FindDriftRequest(
            machine_id=machine, counts_candidates=counts_candidates,
            limits=[history_service_pb2.DriftLimit(symbol=symbol, low=low, high=high) for symbol, (low, high) in (limits or {}).items()])
        return DriftReport.from_message(self.call("History", "FindDrift", request))

    # ---- programs

    def compensate_file(self, machine: str, source: PathLike, target: PathLike, tool_tip_mm: Optional[Sequence[float]] = None, *,
                        calibration: Optional[int] = None, unit: Optional[str] = None, dialect: Optional[str] = None,
                        max_correction_um: Optional[float] = None, on_unsupported: str = "refuse", time_s: Optional[float] = None,
                        temperature_celsius: Optional[float] = None, tables_are_off: bool = False, without_profile: bool = False,
                        options: Optional[job_pb2.RewriteOptions] = None) -> reports.Rewrite:
        """Writes `target`, the NC program of `source` corrected for the machine's approved calibration or a named one; nothing is stored.

        tool_tip_mm: the nominal tool point at home, machine frame. unit: "mm" or "inch" of a program that does not state it. What is not stated here,
        tool_tip_mm and options too, the profile of the machine says (`programs` of its description), but without_profile; a note of the report says
        what that was.
        tables_are_off: the control uses none of the tables that were handed out of this machine's calibrations, without which it is refused. options: all else
        of axiscal.v1.job_pb2.RewriteOptions. FailedPrecondition with line and reason where a block cannot be corrected; then, as with any other
        error, `target` stays as it was.
        """
        rewrite = job_pb2.RewriteOptions()
        if options is not None:
            rewrite.CopyFrom(options)
        if unit not in _UNITS:
            raise errors.InvalidArgument(f"unit = {unit!r}, must be 'mm' or 'inch'")
        if on_unsupported not in _ON_UNSUPPORTED:
            raise errors.InvalidArgument(f"on_unsupported = {on_unsupported!r}, must be one of {', '.join(_ON_UNSUPPORTED)}")
        if unit is not None:
            rewrite.unit = _UNITS[unit]
        rewrite.on_unsupported = _ON_UNSUPPORTED[on_unsupported]
        if dialect is not None:
            rewrite.dialect = dialect
        if max_correction_um is not None:
            rewrite.max_correction_mm = max_correction_um * MM_PER_UM
        tip = () if tool_tip_mm is None else [float(value) for value in tool_tip_mm]
        params = job_pb2.CompensateParams(machine_id=machine, tool_tip_mm=tip, options=rewrite, without_profile=without_profile)
        if calibration is not None:
            params.calibration_id = calibration
        if time_s is not None:
            params.time_s = time_s
        if temperature_celsius is not None:
            params.temperature_celsius = temperature_celsius
        params.tables_are_off = tables_are_off
        return _programs.compensate(self._connection, params, source, target)

    def put_program(self, path: PathLike, progress: Optional[ProgressCallback] = None) -> ProgramRecord:
        """Stores an NC program; the same bytes again give the program that is there."""
        return _programs.put(self._connection, path, progress)

    def get_program(self, program_id: int, path: PathLike, progress: Optional[ProgressCallback] = None) -> ProgramRecord:
        """Writes a program to `path`, its checksum compared; resumed when the stream breaks."""
        return _programs.get(self._connection, program_id, path, progress)

    def programs(self) -> Iterator[ProgramRecord]:
        """Newest first."""
        for message in self._pages("Programs", "ListPrograms", programs_service_pb2.ListProgramsRequest(), "programs"):
            yield ProgramRecord.from_message(message)

    # ---- the server

    def server_info(self) -> ServerInfo:
        return ServerInfo.from_message(self.call("Admin", "GetServerInfo", admin_service_pb2.GetServerInfoRequest()))


def _set_span(request: Any, start: Optional[datetime.datetime], end: Optional[datetime.datetime]) -> None:
    if start is not None:
        request.from_utc_us = utc_us(start)
    if end is not None:
        request.to_utc_us = utc_us(end)


def connect(address: Optional[str] = None, **options: Any) -> Client:
    """A client of the server at `address` ("axiscal.shop:7410", "unix:/run/axiscal.sock"), or of AXISCAL_SERVER.

    options: the fields of axiscal.Options, each of which the environment may give as well. Unavailable (NO_CONNECTION) when the server is not
    there within connect_deadline_s.
    """
    address = address or os.environ.get("AXISCAL_SERVER")
    if not address:
        raise errors.InvalidArgument("no address: give one, or set AXISCAL_SERVER")
    connection = Connection(address, Options.read(**options))
    if connection.options.connect_deadline_s > 0:
        connection.wait_until_connected(connection.options.connect_deadline_s)
    return Client(connection)
