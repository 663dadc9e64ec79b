"""Client of the Axiscal calibration service for machine tools.

    import axiscal

    with axiscal.connect("axiscal.shop:7410", ca="ca.crt", token_file="cell-7.token") as client:
        client.upload("mt", "tuesday.csv")

connect() says what can be set, Client what can be asked, axiscal.errors what a call may fail with.
"""
from axiscal._client import Client, connect
from axiscal._logs import StoredLog
from axiscal._options import Options
from axiscal._upload import Progress, Upload
from axiscal._version import VERSION as __version__
from axiscal.drift import DriftFinding, DriftReport, Forecast
from axiscal.errors import (Aborted, AlreadyExists, Cancelled, DataLoss, DeadlineExceeded, Error, FailedPrecondition, InvalidArgument, NotFound,
                            OutOfRange, PermissionDenied, ResourceExhausted, Unauthenticated, Unavailable)
from axiscal.records import (Calibration, CalibrationState, Estimate, Job, JobError, JobProgress, JobState, MachineRecord, ProgramRecord,
                             ServerInfo, SessionRecord, SessionState)
from axiscal.session import Column, Session
from axiscal.watching import (Cell, DeadLetter, Event, EventChange, Expectations, Finding, MachineCare, Mark, Routine, RoutineRun, StandingFinding,
                              Webhook)

__all__ = [
    "Aborted", "AlreadyExists", "Calibration", "CalibrationState", "Cancelled", "Cell", "Client", "Column", "DataLoss", "DeadLetter",
    "DeadlineExceeded", "DriftFinding", "DriftReport", "Error", "Estimate", "Event", "EventChange", "Expectations", "FailedPrecondition", "Finding",
    "Forecast", "InvalidArgument", "Job", "JobError", "JobProgress", "JobState", "MachineCare", "MachineRecord", "Mark", "NotFound", "Options",
    "OutOfRange", "PermissionDenied", "ProgramRecord", "Progress", "ResourceExhausted", "Routine", "RoutineRun", "ServerInfo", "Session", "SessionRecord",
    "SessionState", "StandingFinding", "StoredLog", "Unauthenticated", "Unavailable", "Upload", "Webhook", "__version__", "connect",
]
