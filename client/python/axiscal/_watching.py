"""The part of the client that is about what the service watches and does by itself."""
import datetime
import time
from typing import Any, Iterable, Iterator, Mapping, Optional, Tuple

from axiscal import errors
from axiscal._connection import Backoff, Connection, is_broken, new_request_id
from axiscal.records import utc_us
from axiscal.v1 import admin_service_pb2, events_service_pb2, history_service_pb2, ingest_service_pb2, routines_service_pb2, webhooks_service_pb2
from axiscal.watching import (Cell, DeadLetter, Event, EventChange, Expectations, Finding, MachineCare, Mark, Routine, RoutineRun, Webhook, name_of,
                              scope_message)


class Watching:
    """Mixed into Client."""

    _connection: Connection

    def call(self, service: str, method: str, request: Any, deadline_s: Optional[float] = None) -> Any:
        raise NotImplementedError

    def _pages(self, service: str, method: str, request: Any, field: str) -> Iterator[Any]:
        raise NotImplementedError

    # ---- what machines need

    def care(self, group: str = "") -> Tuple[MachineCare, ...]:
        """Every machine that may be seen, or those of a group: the ones that need care first, those with most to tell before others."""
        request = history_service_pb2.ListCareRequest(page_size=1000)
        fleet = [MachineCare.from_message(message) for message in self._pages("History", "ListCare", request, "machines")]
        order = {word: place for place, word in enumerate(("now", "decide", "unknown", "good"))}
        fleet.sort(key=lambda one: (order[one.care], -one.new_events - len(one.findings), one.machine))
        return tuple(one for one in fleet if not group or group in one.groups)

    # ---- events

    def events(self, machine: str = "", open_only: bool = False) -> Iterator[Event]:
        """Newest first, of one machine or of all that may be seen."""
        request = events_service_pb2.ListEventsRequest(machine_id=machine, open_only=open_only)
        for message in self._pages("Events", "ListEvents", request, "events"):
            yield Event.from_message(message)

    def watch_events(self, after: Optional[int] = None, machine: str = "") -> Iterator[EventChange]:
        """Every change of events, without end: those behind the change `after` (0: all), or what happens from now on.

        It goes on over a restart of the server, with no change missed and none twice. Whoever keeps `number` of the last change that was dealt
        with goes on behind it after a crash of his own. Unavailable where the server is away for longer than give_up_after_s; OutOfRange
        (CHANGE_UNKNOWN) where the database is an older one than that which gave the number.
        """
        options = self._connection.options
        request = events_service_pb2.WatchEventsRequest(machine_id=machine)
        if after is not None:
            request.after_change_id = after
        backoff, give_up = Backoff(options), time.monotonic() + options.give_up_after_s
        while True:
            error: Optional[errors.Error] = None
            try:
                call = self._connection.open_stream("Events", "WatchEvents", request)
                for message in self._connection.read_stream(call):
                    backoff, give_up = Backoff(options), time.monotonic() + options.give_up_after_s
                    if message.HasField("change"):
                        yield EventChange.from_message(message.change)
                    # Only now: what was given to the caller is behind him.
                    request.after_change_id = message.up_to_change_id
            except errors.Error as raised:
                error = raised
            if error is not None and not is_broken(error):
                raise error
            if not backoff.wait(give_up):
                raise error or errors.make("UNAVAILABLE", "the stream of events has ended")

    def acknowledge_event(self, event: int, note: str) -> Event:
        """A person has seen it; the first word stays. A step is cleared by it."""
        request = events_service_pb2.AcknowledgeEventRequest(event_id=event, note=note)
        return Event.from_message(self.call("Events", "AcknowledgeEvent", request).event)

    def shelve_event(self, event: int, until: Optional[datetime.datetime], note: str) -> Event:
        """Out of sight until then; None: back at once."""
        request = events_service_pb2.ShelveEventRequest(event_id=event, note=note)
        if until is not None:
            request.until_utc_us = utc_us(until)
        return Event.from_message(self.call("Events", "ShelveEvent", request).event)

    def expectations(self, machine: str) -> Expectations:
        return Expectations.from_message(self.call("Events", "GetExpectations", events_service_pb2.GetExpectationsRequest(machine_id=machine)))

    def set_expectations(self, machine: str, tolerances: Optional[Mapping[str, Tuple[float, float]]] = None,
                         sessions: Optional[Mapping[str, int]] = None, calibration_days: Optional[int] = None, *,
                         counts_candidates: bool = False, etag: int = 0) -> Expectations:
        """Replaces all that was said before: {"EX0C": (-20, 20)} in um or urad, {"nightly": 24} in hours. Aborted where `etag` is given and
        somebody has changed it meanwhile."""
        said = events_service_pb2.Expectations(
            counts_candidates=counts_candidates,
            tolerances=[history_service_pb2.DriftLimit(symbol=symbol, low=low, high=high) for symbol, (low, high) in (tolerances or {}).items()],
            sessions=[events_service_pb2.ExpectedSession(name=name, every_hours=hours) for name, hours in (sessions or {}).items()])
        if calibration_days is not None:
            said.calibration_days = calibration_days
        request = events_service_pb2.SetExpectationsRequest(machine_id=machine, expectations=said, etag=etag)
        return Expectations.from_message(self.call("Events", "SetExpectations", request))

    # ---- marks

    def put_mark(self, machine: str, kind: str, at: datetime.datetime, symbols: Iterable[str] = (), note: str = "",
                 request_id: Optional[str] = None) -> Mark:
        """Says what has happened to a machine: "collision", "service", "refixturing". What was known of its errors ends there."""
        request = history_service_pb2.PutMarkRequest(
            request_id=request_id or new_request_id(), machine_id=machine, at_utc_us=utc_us(at),
            kind=name_of(history_service_pb2.MarkKind, "MARK_KIND_", kind), symbols=symbols, note=note)
        return Mark.from_message(self.call("History", "PutMark", request).mark)

    def marks(self, machine: str) -> Iterator[Mark]:
        """Newest first; withdrawn ones too."""
        for message in self._pages("History", "ListMarks", history_service_pb2.ListMarksRequest(machine_id=machine), "marks"):
            yield Mark.from_message(message)

    def withdraw_mark(self, mark: int) -> Mark:
        """It was a mistake and counts no more."""
        return Mark.from_message(self.call("History", "WithdrawMark", history_service_pb2.WithdrawMarkRequest(mark_id=mark)).mark)

    # ---- routines

    def put_routine(self, routine: Routine, etag: int = 0) -> Routine:
        """Makes one, or replaces the one of that name. Aborted where `etag` is given and somebody has changed it meanwhile."""
        request = routines_service_pb2.PutRoutineRequest(routine=routine.to_message(), etag=etag)
        return Routine.from_message(self.call("Routines", "PutRoutine", request).routine)

    def remove_routine(self, name: str, etag: int = 0) -> Routine:
        """Its runs stay."""
        return Routine.from_message(self.call("Routines", "RemoveRoutine", routines_service_pb2.RemoveRoutineRequest(name=name, etag=etag)).routine)

    def routines(self, machine: str = "") -> Tuple[Routine, ...]:
        """In order of names; those that work for this machine, or for any."""
        response = self.call("Routines", "ListRoutines", routines_service_pb2.ListRoutinesRequest(machine_id=machine))
        return tuple(Routine.from_message(message) for message in response.routines)

    def stop_routine(self, name: str, machine: str, note: str = "") -> Routine:
        """It begins nothing on that machine until it is resumed."""
        return self._stop_routine(name, machine, True, note)

    def resume_routine(self, name: str, machine: str, note: str = "") -> Routine:
        return self._stop_routine(name, machine, False, note)

    def _stop_routine(self, name: str, machine: str, stopped: bool, note: str) -> Routine:
        request = routines_service_pb2.StopRoutineRequest(name=name, machine_id=machine, stopped=stopped, note=note)
        return Routine.from_message(self.call("Routines", "StopRoutine", request).routine)

    def retry_routine(self, name: str, machine: str) -> RoutineRun:
        """The sessions of its newest run once more, where that failed or was stopped."""
        request = routines_service_pb2.RetryRoutineRequest(name=name, machine_id=machine)
        return RoutineRun.from_message(self.call("Routines", "RetryRoutine", request).run)

    def routine_runs(self, machine: str = "", routine: str = "") -> Iterator[RoutineRun]:
        """Newest first."""
        request = routines_service_pb2.ListRoutineRunsRequest(machine_id=machine, routine=routine)
        for message in self._pages("Routines", "ListRoutineRuns", request, "runs"):
            yield RoutineRun.from_message(message)

    # ---- webhooks

    def put_webhook(self, name: str, url: str, machine: str = "", group: str = "", note: str = "", *, disabled: bool = False,
                    new_secret: bool = False, etag: int = 0) -> Tuple[Webhook, str]:
        """Makes one, or changes the one of that name; and its secret, which is given where it is new and at no other time."""
        request = webhooks_service_pb2.PutWebhookRequest(
            webhook=webhooks_service_pb2.Webhook(name=name, url=url, scope=scope_message(machine, group), note=note, disabled=disabled),
            new_secret=new_secret, etag=etag)
        response = self.call("Webhooks", "PutWebhook", request)
        return Webhook.from_message(response.webhook), response.secret

    def remove_webhook(self, name: str, etag: int = 0) -> Webhook:
        """Its dead letters too."""
        return Webhook.from_message(self.call("Webhooks", "RemoveWebhook", webhooks_service_pb2.RemoveWebhookRequest(name=name, etag=etag)).webhook)

    def webhooks(self) -> Tuple[Webhook, ...]:
        response = self.call("Webhooks", "ListWebhooks", webhooks_service_pb2.ListWebhooksRequest())
        return tuple(Webhook.from_message(message) for message in response.webhooks)

    def test_webhook(self, name: str) -> str:
        """Sends a letter of type "test" now; what was wrong, empty where it was taken."""
        return str(self.call("Webhooks", "TestWebhook", webhooks_service_pb2.TestWebhookRequest(name=name)).error)

    def dead_letters(self, name: str) -> Iterator[DeadLetter]:
        """What could not be brought there; newest first."""
        for message in self._pages("Webhooks", "ListDeadLetters", webhooks_service_pb2.ListDeadLettersRequest(name=name), "letters"):
            yield DeadLetter.from_message(message)

    def resend_dead_letters(self, name: str, change: Optional[int] = None) -> int:
        """All of them, or one, once more; how many."""
        request = webhooks_service_pb2.ResendDeadLettersRequest(name=name)
        if change is not None:
            request.change_id = change
        return int(self.call("Webhooks", "ResendDeadLetters", request).count)

    # ---- cells, and the server itself

    def cells(self, machine: str = "") -> Iterator[Cell]:
        """The PCs beside this machine, or beside all that may be seen."""
        for message in self._pages("Ingest", "ListCells", ingest_service_pb2.ListCellsRequest(machine_id=machine), "cells"):
            yield Cell.from_message(message)

    def forget_cell(self, machine: str, name: str) -> None:
        """It is no longer there: nobody waits for it any more, and its events are cleared."""
        self.call("Ingest", "ForgetCell", ingest_service_pb2.ForgetCellRequest(machine_id=machine, name=name))

    def diagnose(self) -> Tuple[Finding, ...]:
        """What the server finds of itself: database, disk, certificates, files, descriptors, last backup, jobs, cells, webhooks. `axiscal doctor`
        looks at the way to it, too. For viewers of all machines."""
        return tuple(Finding.from_message(message) for message in self.call("Admin", "Diagnose", admin_service_pb2.DiagnoseRequest()).findings)
