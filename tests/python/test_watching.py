"""What the service watches and does by itself, from Python: events over restarts, marks, routines, webhooks; and a cell, a technician, an approver
and an MES, each with its own token, from the log to the program."""
import base64
import datetime
import hashlib
import hmac
import http.server
import json
import subprocess
import threading
import unittest

import axiscal
from axiscal.v1 import access_service_pb2, ingest_service_pb2

import server

UTC = datetime.timezone.utc
HEADER = dict(axiscal.Session.read(server.EXAMPLE / "B-short-run1.csv").header)
FRAME = axiscal.Session.read(server.EXAMPLE / "B-short-run1.csv").to_frame()


def week(number, name):
    """Session of a tool that grows by 0.01 mm a week, seen where B stands at 90 deg."""
    moved = FRAME.copy()
    moved.loc[1, ["cx_mm", "cz_mm"]] += [-0.01 * number, 0.01 * number]
    day = datetime.datetime(2026, 1, 5, tzinfo=UTC) + datetime.timedelta(weeks=number)
    return axiscal.Session.from_frame(moved, {**HEADER, "session": name, "started": day})


def calibrate(client, number):
    """An approved calibration; what EZ0T is then, um."""
    job = client.identify(server.MACHINE, [client.upload(server.MACHINE, week(number, f"week-{number}")).session.id], ["EZ0T"])
    calibration = client.approve(client.calibration(client.wait(job).calibration_id))
    return calibration.estimates[0].value


class Receiver:
    """An address that is told of events: keeps letters whose signature is right, and answers as `status` says."""

    def __init__(self):
        receiver = self
        self.secret, self.status, self.letters, self.came = "", 204, {}, threading.Condition()

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                signed = b".".join([self.headers["webhook-id"].encode(), self.headers["webhook-timestamp"].encode(), body])
                key = base64.b64decode(receiver.secret.removeprefix("whsec_"))
                right = "v1," + base64.b64encode(hmac.new(key, signed, hashlib.sha256).digest()).decode()
                is_right = hmac.compare_digest(right, self.headers["webhook-signature"])
                self.send_response(receiver.status if is_right else 401)
                self.end_headers()
                if is_right and receiver.status < 300:
                    with receiver.came:
                        receiver.letters[self.headers["webhook-id"]] = json.loads(body)
                        receiver.came.notify_all()

            def log_message(self, *_):
                pass

        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.address = "127.0.0.1:%d" % self._server.server_port
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def wait_for(self, words):
        """A letter that has them somewhere."""
        with self.came:
            if not self.came.wait_for(lambda: any(words in json.dumps(letter) for letter in self.letters.values()), 60):
                raise AssertionError(f"no letter has {words}: {self.letters}")

    def close(self):
        self._server.shutdown()
        self._server.server_close()


class Watching(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = server.Folder()
        cls.folder = folder.__enter__()
        cls.addClassCleanup(folder.__exit__)
        cls.receiver = Receiver()
        cls.addClassCleanup(cls.receiver.close)
        cls.server = server.Server(cls.folder / "a.db", "--webhooks-allowed", cls.receiver.address).__enter__()
        cls.addClassCleanup(cls.server.__exit__)
        cls.client = axiscal.connect(cls.server.address)
        cls.addClassCleanup(cls.client.close)
        cls.client.create_machine(server.EXAMPLE / "machine.json")
        cls.value_um = calibrate(cls.client, 0)

    def test_a_stream_of_events_goes_on_over_kills_of_the_server(self):
        rounds = 5
        limits = {"in": (self.value_um - 500, self.value_um + 500), "out": (self.value_um + 500, self.value_um + 600)}
        self.client.set_expectations(server.MACHINE, {"EZ0T": limits["in"]})
        stream = self.client.watch_events(after=0)
        seen = []
        for number in range(rounds):
            goes_out = number % 2 == 0
            self.client.set_expectations(server.MACHINE, {"EZ0T": limits["out" if goes_out else "in"]})
            while not seen or (seen[-1].event.subject, seen[-1].what) != ("EZ0T", "raised" if goes_out else "cleared"):
                seen.append(next(stream))
            self.server.kill()
            self.server.start()
        stream.close()
        numbers = [change.number for change in seen]
        self.assertEqual(numbers, sorted(set(numbers)))
        again = self.client.watch_events(after=numbers[1])  # whoever kept the second number
        self.assertEqual([next(again).number for _ in numbers[2:]], numbers[2:])
        again.close()
        stored = {event.id: event for event in self.client.events(server.MACHINE)}
        self.assertLessEqual({change.event.id for change in seen}, set(stored))
        with self.assertRaises(axiscal.OutOfRange) as caught:
            next(self.client.watch_events(after=10 ** 9))
        self.assertEqual(caught.exception.reason, "CHANGE_UNKNOWN")

    def test_a_persons_word(self):
        said = self.client.set_expectations(server.MACHINE, {"EZ0T": (0, 1)}, sessions={"nightly": 24}, calibration_days=90)
        self.assertEqual(self.client.expectations(server.MACHINE), said)
        self.assertEqual((said.tolerances, said.sessions, said.calibration_days), ({"EZ0T": (0.0, 1.0)}, {"nightly": 24}, 90))
        with self.assertRaises(axiscal.Aborted):
            self.client.set_expectations(server.MACHINE, etag=said.etag - 1 or said.etag + 1)
        stream = self.client.watch_events(after=0)
        event = next(change.event for change in stream if change.event.kind == "out_of_tolerance" and change.event.cleared is None)
        stream.close()
        seen = self.client.acknowledge_event(event.id, "seen")
        self.assertEqual((seen.acknowledged_note, seen.text), ("seen", event.text))
        until = datetime.datetime.now(UTC).replace(microsecond=0) + datetime.timedelta(days=1)
        self.assertEqual(self.client.shelve_event(event.id, until, "service").shelved_until, until)
        self.assertIsNone(self.client.shelve_event(event.id, None, "back").shelved_until)

    def test_marks(self):
        at = datetime.datetime(2026, 1, 6, 12, tzinfo=UTC)
        mark = self.client.put_mark(server.MACHINE, "collision", at, ["EZ0T"], "the tool hit the chuck", request_id="hit")
        self.assertEqual(self.client.put_mark(server.MACHINE, "collision", at, ["EZ0T"], "the tool hit the chuck", request_id="hit"), mark)
        self.assertEqual((mark.kind, mark.at, mark.symbols, mark.withdrawn), ("collision", at, ("EZ0T",), None))
        self.assertEqual(next(self.client.marks(server.MACHINE)), mark)
        self.assertIsNotNone(self.client.withdraw_mark(mark.id).withdrawn)
        with self.assertRaisesRegex(ValueError, "must be one of collision, service, refixturing"):
            self.client.put_mark(server.MACHINE, "storm", at)
        with self.assertRaises(axiscal.InvalidArgument):
            self.client.put_mark(server.MACHINE, "service", at, ["EX9Q"])

    def test_a_routine_runs_when_its_session_comes(self):
        server.axiscal("--server", self.server.address, "admin", "principal", "add", "night")
        server.axiscal("--server", self.server.address, "admin", "role", "add", "night", "technician", "--all")
        with self.assertRaises(axiscal.NotFound):
            self.client.put_routine(axiscal.Routine("nightly", "nobody", ("CR",), machine=server.MACHINE))
        put = self.client.put_routine(axiscal.Routine("nightly", "night", ("routine",), machine=server.MACHINE, declared_errors=("EZ0T",)))
        self.assertEqual((put.work, put.within_hours, put.etag), ("identify", 24, 1))
        self.assertEqual(self.client.routines(server.MACHINE), (put,))
        session = self.client.upload(server.MACHINE, week(1, "routine")).session
        stream = self.client.watch_events(after=0)
        told = next(change for change in stream if change.what == "raised" and change.event.kind == "routine_proposes")
        stream.close()
        run = next(self.client.routine_runs(server.MACHINE, "nightly"))
        self.assertEqual((run.state, run.session_ids, run.principal), ("proposed", (session.id,), "night"))
        self.assertIn(str(run.calibration_id), told.event.text + told.event.advice + str(told.event.calibration))
        self.assertEqual(self.client.stop_routine("nightly", server.MACHINE, "service").stopped, (server.MACHINE,))
        self.assertEqual(self.client.resume_routine("nightly", server.MACHINE).stopped, ())
        with self.assertRaises(axiscal.FailedPrecondition) as caught:
            self.client.retry_routine("nightly", server.MACHINE)
        self.assertEqual(caught.exception.reason, "RUN_NOT_FAILED")
        self.assertEqual(self.client.remove_routine("nightly").name, "nightly")
        self.assertEqual(self.client.routines(), ())

    def test_a_cell_and_what_the_server_finds_of_itself(self):
        report = ingest_service_pb2.CellReport(machine_id=server.MACHINE, name="cell-7", version="1", silent_after_s=60, problem="a file was refused",
                                               waiting_files=2, waiting_bytes=30, quarantined_files=1, quarantined_bytes=4, max_bytes=500)
        self.client.call("Ingest", "ReportCell", ingest_service_pb2.ReportCellRequest(report=report))
        cell, = self.client.cells(server.MACHINE)
        self.assertEqual((cell.machine, cell.name, cell.is_silent, cell.problem), (server.MACHINE, "cell-7", False, "a file was refused"))
        self.assertEqual((cell.waiting_files, cell.waiting_bytes, cell.quarantined_files, cell.quarantined_bytes, cell.max_bytes), (2, 30, 1, 4, 500))
        self.assertEqual(cell.silent_after, datetime.timedelta(minutes=1))
        self.assertLess(abs(datetime.datetime.now(UTC) - cell.reported), datetime.timedelta(minutes=10))
        found = {finding.what: finding for finding in self.client.diagnose()}
        self.assertEqual((found["cells"].state, found["files of cells"].state), ("ok", "warning"))
        self.assertIn("cell-7 of integrex-i200: a file was refused", found["files of cells"].text)
        self.assertIn("axiscal spool list", found["files of cells"].advice)
        self.assertEqual((found["database"].state, found["database"].advice), ("ok", ""))
        self.client.forget_cell(server.MACHINE, "cell-7")
        self.assertEqual(list(self.client.cells()), [])
        with self.assertRaises(axiscal.NotFound):
            self.client.forget_cell(server.MACHINE, "cell-7")

    def test_webhooks_are_told_and_keep_what_was_not_taken(self):
        url = f"http://{self.receiver.address}/axiscal"
        webhook, self.receiver.secret = self.client.put_webhook("mes", url, machine=server.MACHINE)
        self.assertTrue(self.receiver.secret.startswith("whsec_"))
        self.assertEqual((webhook.machine, webhook.group), (server.MACHINE, ""))
        with self.assertRaisesRegex(axiscal.InvalidArgument, "webhook.url: 127.0.0.1 is a loopback address, which webhooks.allowed"):
            self.client.put_webhook("other", "http://127.0.0.1:9/", machine=server.MACHINE)
        self.assertEqual(self.client.test_webhook("mes"), "")
        self.receiver.wait_for('"type": "test"')
        self.client.set_expectations(server.MACHINE, {"EZ0T": (-2, -1)})
        self.receiver.wait_for("its tolerance is -2 .. -1 um")
        self.receiver.status = 503
        self.assertIn("503", self.client.test_webhook("mes"))
        self.receiver.status = 204
        self.assertEqual(list(self.client.dead_letters("mes")), [])
        with self.assertRaises(axiscal.NotFound):
            self.client.resend_dead_letters("mes", 1)
        with self.assertRaises(axiscal.InvalidArgument):
            self.client.put_webhook("loop", "http://user:word@127.0.0.1/")
        self.assertEqual(self.client.webhooks()[0].name, "mes")
        self.assertEqual(self.client.remove_webhook("mes").name, "mes")
        self.assertEqual(self.client.webhooks(), ())


class Care(unittest.TestCase):
    def test_what_a_machine_needs(self):
        with server.Folder() as folder, server.Server(folder / "a.db") as running, axiscal.connect(running.address) as client:
            self.assertEqual(client.care(), ())
            client.create_machine(server.EXAMPLE / "machine.json")
            value_um = calibrate(client, 0)
            client.set_expectations(server.MACHINE, {"EZ0T": (value_um + 500, value_um + 600)})
            stream = client.watch_events(after=0)
            next(change for change in stream if change.event.kind == "out_of_tolerance")
            stream.close()
            client.create_machine({**json.loads((server.EXAMPLE / "machine.json").read_text()), "id": "a-new-one"})
            client.call("Access", "ChangeGroup",
                        access_service_pb2.ChangeGroupRequest(group="turning", machine_id=server.MACHINE, belongs=True))
            sick, new = client.care()
            self.assertEqual((sick.machine, sick.care, sick.groups, sick.version), (server.MACHINE, "now", ("turning",), 1))
            self.assertGreaterEqual(sick.new_events, 1)
            self.assertIn("EZ0T is", sick.newest_event)
            self.assertEqual(sick.measured, datetime.datetime(2026, 1, 5, tzinfo=UTC))
            self.assertLess(sick.rms_after_um, sick.rms_before_um)
            self.assertEqual((new.machine, new.care, new.calibration, new.findings), ("a-new-one", "unknown", None, ()))
            self.assertEqual([one.machine for one in client.care("turning")], [server.MACHINE])
            self.assertEqual(client.care("nowhere"), ())


class Roles(unittest.TestCase):
    """What a cell, a technician, an approver and an MES do, with roles on."""

    def test_from_the_session_to_the_program(self):
        with server.Folder() as folder:
            make = lambda *words: subprocess.run([server.SOURCE / "deploy/make-certs", folder / "pki", *words], check=True, capture_output=True)
            make("ca")
            make("server", "localhost", "127.0.0.1")
            database, ca = folder / "a.db", folder / "pki/ca.crt"
            certificate = next((folder / "pki").rglob("localhost.crt"))

            def admin(*words):
                return server.axiscal("--db", database, "admin", *words)

            server.axiscal("--db", database, "machine", "add", server.EXAMPLE / "machine.json")
            for name, role in (("cell-7", "cell"), ("bob", "technician"), ("ann", "approver"), ("mes", "viewer")):
                admin("principal", "add", name)
                admin("role", "add", name, role, "--machine", server.MACHINE)
                admin("token", "add", name, "-o", folder / f"{name}.token")
            flags = ["--tls-certificate", certificate, "--tls-key", certificate.with_suffix(".key"), "--tls-client-ca", ca]
            with server.Server(database, *map(str, flags)) as running:
                cell, bob, ann, mes = (axiscal.connect(running.address, ca=str(ca), token_file=folder / f"{name}.token")
                                       for name in ("cell-7", "bob", "ann", "mes"))
                uploads = [cell.upload(server.MACHINE, server.EXAMPLE / f"B-{run}.csv") for run in server.RUNS]
                with self.assertRaises(axiscal.PermissionDenied):
                    cell.identify(server.MACHINE, [uploads[0].session.id])
                job = bob.wait(bob.identify(server.MACHINE, [upload.session.id for upload in uploads], ["EZ0T", "EX0T"]))
                candidate = bob.calibration(job.calibration_id)
                with self.assertRaises(axiscal.PermissionDenied) as caught:
                    bob.approve(candidate)
                self.assertEqual(caught.exception.reason, "ROLE_MISSING")
                ann.approve(candidate, "agrees with the drawing")
                bob.set_expectations(server.MACHINE, {"EZ0T": (-100, 100)})
                stream = mes.watch_events(after=0, machine=server.MACHINE)
                change = next(change for change in stream if change.event.kind == "out_of_tolerance")
                stream.close()
                self.assertEqual((change.event.machine, change.event.subject), (server.MACHINE, "EZ0T"))
                with self.assertRaises(axiscal.PermissionDenied):
                    mes.acknowledge_event(change.event.id, "no")
                self.assertEqual(bob.acknowledge_event(change.event.id, "the tool setter was moved").acknowledged_by, "bob")
                report = bob.compensate_file(server.MACHINE, server.EXAMPLE / "fig-4.30-original.nc", folder / "corrected.nc",
                                             tool_tip_mm=[0, 0, -356.3945], unit="mm", max_correction_um=5000)
                self.assertLess(report.tool_point_error.after.max_um, 1)
                self.assertEqual(set(mes.drift(server.MACHINE)["symbol"]), {"EZ0T", "EX0T"})
                for client in (cell, bob, ann, mes):
                    client.close()


if __name__ == "__main__":
    unittest.main()
