"""The Python client against a server: what it sends, how it survives, whom it is."""
import datetime
import multiprocessing
import os
import subprocess
import threading
import unittest

import numpy as np
import pandas as pd

import axiscal
from axiscal import reports
from axiscal.v1 import access_service_pb2, jobs_service_pb2, job_pb2, tables_service_pb2

import server

TIP = [0, 0, -356.3945]
CASE = server.SOURCE / "tests/data/loop/case-003"
PROGRAM = server.EXAMPLE / "fig-4.30-original.nc"


def in_child(address, queue):
    """In a child process: connects anew."""
    try:
        with axiscal.connect(address) as client:
            queue.put(client.server_info().software_version)
    except Exception as error:  # pylint: disable=broad-except
        queue.put(f"{type(error).__name__}: {error}")


class WithServer(unittest.TestCase):
    """One server for all tests of a class, each with a machine of its own where it needs one."""

    @classmethod
    def setUpClass(cls):
        folder = server.Folder()
        cls.folder = folder.__enter__()
        cls.addClassCleanup(folder.__exit__)
        cls.server = server.Server(cls.folder / "a.db", "--workers", "2").__enter__()
        cls.addClassCleanup(cls.server.__exit__)
        cls.client = axiscal.connect(cls.server.address)
        cls.addClassCleanup(cls.client.close)
        cls.client.create_machine(server.EXAMPLE / "machine.json")

    def upload_runs(self, names=server.RUNS):
        return [self.client.upload(server.MACHINE, server.EXAMPLE / f"B-{name}.csv").session.id for name in names]


class Sessions(WithServer):
    def test_the_same_session_is_stored_once_by_either_client(self):
        file = server.EXAMPLE / "C-run1.csv"
        by_python = self.client.upload(server.MACHINE, file)
        self.assertFalse(by_python.was_there)
        self.assertEqual(by_python.session.state, axiscal.SessionState.COMPLETE)
        server.axiscal("--server", self.server.address, "upload", file)
        server.axiscal("--server", self.server.address, "upload", server.EXAMPLE / "C-run2.csv")
        by_command_line = self.client.upload(server.MACHINE, server.EXAMPLE / "C-run2.csv")
        self.assertTrue(by_command_line.was_there)
        names = [session.name for session in self.client.sessions(server.MACHINE) if session.name.startswith("C-")]
        self.assertEqual(sorted(names), ["C-run1", "C-run2"])

    def test_every_sample_comes_back_as_it_was(self):
        self.client.create_machine(CASE / "machine.json")
        for file in [server.EXAMPLE / "B-short-run1.csv", *CASE.glob("*/*.csv")]:
            session = axiscal.Session.read(file)
            stored = self.client.upload(session.get("machine"), session).session
            self.assertEqual(stored.readings, len(session))
            again = self.client.download(stored.id)
            self.assertEqual(again.content_id("mt", 1000), session.content_id("mt", 1000))
            self.assertEqual(stored.sha256, self.client.session(stored.id).sha256)

    def test_times_are_in_utc(self):
        session = axiscal.Session.read(server.EXAMPLE / "B-short-run1.csv")
        header = {**dict(session.header), "session": "dated", "started": datetime.datetime(2026, 5, 31, 16, tzinfo=datetime.timezone(datetime.timedelta(hours=2)))}
        stored = self.client.upload(server.MACHINE, axiscal.Session.from_frame(session.to_frame(), header)).session
        self.assertEqual(stored.measured, datetime.datetime(2026, 5, 31, 14, tzinfo=datetime.timezone.utc))
        self.assertLess(abs(stored.created - datetime.datetime.now(datetime.timezone.utc)), datetime.timedelta(minutes=10))

    def test_a_bad_reading_is_refused_with_its_place_and_nothing_is_there(self):
        frame = axiscal.Session.read(server.EXAMPLE / "B-short-run1.csv").to_frame()
        frame.loc[1, "cz_mm"] += 400
        header = {**dict(axiscal.Session.read(server.EXAMPLE / "B-short-run1.csv").header), "session": "bad"}
        with self.assertRaises(axiscal.InvalidArgument) as caught:
            self.client.upload(server.MACHINE, axiscal.Session.from_frame(frame, header))
        self.assertEqual(caught.exception.reason, "SESSION_INVALID")
        self.assertIn("cz_mm", str(caught.exception))
        complete = [session.name for session in self.client.sessions(server.MACHINE, axiscal.SessionState.COMPLETE)]
        self.assertNotIn("bad", complete)
        with self.assertRaises(axiscal.NotFound) as caught:
            self.client.upload("nobody", axiscal.Session.from_frame(frame, {**header, "machine": "nobody"}))
        self.assertEqual(caught.exception.reason, "MACHINE_NOT_FOUND")

    def test_an_upload_goes_on_where_the_stream_was_cut(self):
        session = axiscal.Session.read(max(CASE.glob("fit/*.csv"), key=os.path.getsize))
        self.client.create_machine(CASE / "machine.json")
        header = {**dict(session.header), "session": "cut"}
        session = axiscal.Session.from_frame(session.to_frame(), header)
        proxy = server.CuttingProxy(self.server.address, [9_000, 14_000, 20_000])
        self.addCleanup(proxy.close)
        told = []
        with axiscal.connect(proxy.address, chunk_readings=20, window_chunks=4, connect_deadline_s=0, first_backoff_s=0.02) as client:
            upload = client.upload(session.get("machine"), session, told.append)
        self.assertEqual(proxy.was_cut, 3)
        self.assertGreaterEqual(upload.interruptions, 1)
        self.assertEqual(upload.session.readings, len(session))
        self.assertEqual([progress.done for progress in told], sorted(progress.done for progress in told))
        self.assertEqual((told[-1].done, told[-1].total), (len(session), len(session)))
        self.assertEqual(self.client.download(upload.session.id).content_id("x", 1), session.content_id("x", 1))

    def test_an_exception_of_progress_ends_the_upload_and_it_can_go_on(self):
        session = axiscal.Session.read(max(CASE.glob("check/*.csv"), key=os.path.getsize))
        self.client.create_machine(CASE / "machine.json")
        session = axiscal.Session.from_frame(session.to_frame(), {**dict(session.header), "session": "stopped"})

        def stop(progress):
            raise KeyError("enough")

        with axiscal.connect(self.server.address, chunk_readings=20) as client:
            with self.assertRaisesRegex(KeyError, "enough"):
                client.upload(session.get("machine"), session, stop)
            upload = client.upload(session.get("machine"), session)
        self.assertEqual((upload.was_there, upload.session.readings), (False, len(session)))

    def test_threads_share_a_client(self):
        session = axiscal.Session.read(server.EXAMPLE / "B-long-run1.csv")
        ids = []

        def send(number):
            part = axiscal.Session.from_frame(session.to_frame(), {**dict(session.header), "session": f"thread-{number % 3}"})
            ids.append(self.client.upload(server.MACHINE, part).session.id)

        threads = [threading.Thread(target=send, args=(number,)) for number in range(12)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual((len(ids), len(set(ids))), (12, 3))


class Jobs(WithServer):
    def test_identify_with_progress_report_and_approval(self):
        sessions = self.upload_runs()
        job = self.client.identify(server.MACHINE, sessions, ["EZ0T", "EX0T"], request_id="tuesday")
        self.assertEqual(self.client.identify(server.MACHINE, sessions, ["EZ0T", "EX0T"], request_id="tuesday").id, job.id)
        with self.assertRaises(axiscal.InvalidArgument) as caught:
            self.client.identify(server.MACHINE, sessions, ["EZ0T"], request_id="tuesday")
        self.assertEqual(caught.exception.reason, "REQUEST_ID_REUSED")
        told = []
        job = self.client.wait(job, told.append)
        self.assertEqual(told[-1].state, axiscal.JobState.SUCCEEDED)
        report = job.report
        self.assertIsInstance(report, reports.Identification)
        calibration = self.client.calibration(job.calibration_id)
        self.assertEqual(calibration.report, report)
        self.assertEqual([(error.symbol, error.value) for error in report.errors],
                         [(estimate.symbol, estimate.value) for estimate in calibration.estimates])
        self.assertEqual(calibration.session_ids, tuple(sessions))
        approved = self.client.approve(calibration, reason="measured twice")
        self.assertEqual(self.client.approved_calibration(server.MACHINE), approved)
        asked = access_service_pb2.ListAuditRequest(resource=f"calibrations/{calibration.id}")
        self.assertIn("measured twice", self.client.call("Access", "ListAudit", asked).entries[0].detail)
        with self.assertRaises(axiscal.Aborted) as caught:
            self.client.retire(calibration)  # as it was read before it was approved
        self.assertEqual(caught.exception.reason, "ETAG_MISMATCH")
        listed = next(self.client.jobs(server.MACHINE))
        with self.assertRaisesRegex(ValueError, "no report"):
            listed.report

    def test_residuals_are_a_row_for_each_number(self):
        sessions = self.upload_runs()
        job = self.client.wait(self.client.identify(server.MACHINE, sessions, ["EZ0T", "EX0T"]))
        table = self.client.residuals(job.calibration_id)
        self.assertEqual(list(table.columns), ["session", "reading", "row", "Z_mm", "Y_mm", "X_mm", "B_deg", "C_deg", "time_s", "temperature_celsius",
                                               "before_um", "after_um", "is_set_aside"])
        self.assertEqual(list(table["session"].unique()), sessions)
        one = self.client.residuals(job.calibration_id, session=sessions[1])
        pd.testing.assert_frame_equal(one, table[table["session"] == sessions[1]].reset_index(drop=True))
        measured = self.client.download(sessions[1]).to_frame()
        np.testing.assert_allclose(one[one["row"] == 0]["B_deg"], measured["B_deg"], atol=1e-9)
        # Set-ups are fitted without judging noise again, so that the rms is that of the report to some digits.
        self.assertAlmostEqual(float(np.sqrt((table["after_um"] ** 2).mean())), job.report.fit.rms_um, delta=0.05 * job.report.fit.rms_um)
        self.assertGreater(float(np.sqrt((table["before_um"] ** 2).mean())), 100 * job.report.fit.rms_um)
        with self.assertRaises(axiscal.NotFound):
            self.client.residuals(job.calibration_id, session=4711)

    def test_lists_are_held_to_what_is_asked(self):
        session = axiscal.Session.read(server.EXAMPLE / "B-short-run1.csv")
        day = datetime.datetime(2025, 5, 31, 14, tzinfo=datetime.timezone.utc)
        header = {**dict(session.header), "session": "of-2025", "started": day}
        stored = self.client.upload(server.MACHINE, axiscal.Session.from_frame(session.to_frame(), header)).session
        self.upload_runs()
        hour = datetime.timedelta(hours=1)
        self.assertEqual([one.id for one in self.client.sessions(server.MACHINE, start=day, end=day + hour)], [stored.id])
        self.assertEqual([one.id for one in self.client.sessions(name="of-2025", instrument=stored.instrument)], [stored.id])
        self.assertEqual(list(self.client.sessions(name="of-2025", end=day)), [])
        with self.assertRaises(axiscal.InvalidArgument) as caught:
            list(self.client.sessions(start=day, end=day))
        self.assertEqual(caught.exception.reason, "RANGE_INVALID")
        job = self.client.wait(self.client.identify(server.MACHINE, [stored.id], ["EZ0T"]))
        self.assertEqual([one.id for one in self.client.calibrations(session=stored.id)], [job.calibration_id])
        self.assertEqual([one.id for one in self.client.calibrations(server.MACHINE, start=day, end=day + hour)], [job.calibration_id])
        self.assertIn(job.id, [one.id for one in self.client.jobs(kind="identify", start=job.created)])
        self.assertEqual(list(self.client.jobs(kind="compensate", end=day)), [])
        with self.assertRaises(axiscal.InvalidArgument):
            list(self.client.jobs(kind="idnetify"))

    def test_a_job_that_fails_says_why(self):
        sessions = self.upload_runs(("short-run1",))
        with self.assertRaises(axiscal.Error) as caught:
            self.client.wait(self.client.identify(server.MACHINE, sessions, ["EQ9Q"]))
        self.assertTrue(caught.exception.reason)
        self.assertIn("EQ9Q", str(caught.exception))
        with self.assertRaises(axiscal.NotFound) as caught:
            list(self.client.watch(4711))
        self.assertEqual(caught.exception.reason, "JOB_NOT_FOUND")

    def test_compensation_gives_the_bytes_of_the_command_line(self):
        sessions = self.upload_runs()
        job = self.client.wait(self.client.identify(server.MACHINE, sessions, ["EZ0T", "EX0T"]))
        number = job.calibration_id
        target, other = self.folder / "python.nc", self.folder / "cli.nc"
        report = self.client.compensate_file(server.MACHINE, PROGRAM, target, TIP, calibration=number, unit="mm", max_correction_um=5000)
        server.axiscal("--server", self.server.address, "compensate", "--machine", server.MACHINE, "--calibration", number, "--unit", "mm", "--dialect", "fanuc",
                       "--tool-tip", " ".join(map(str, TIP)), "--max-correction-um", 5000, PROGRAM, "-o", other)
        self.assertEqual(target.read_bytes(), other.read_bytes())
        self.assertEqual((report.blocks.corrected, report.blocks.refused), (10, 0))
        self.assertGreater(report.tool_point_error.before.max_um, 1000)
        self.assertLess(report.tool_point_error.after.max_um, 1)
        self.assertGreater(report.correction["Z"].max_um, 1000)
        # What the machine's profile says need not be said again.
        profile = ("--server", self.server.address, "machine", "profile", "put", server.MACHINE)
        server.axiscal(*profile, "--dialect", "fanuc", "--unit", "mm", "--tool-tip", " ".join(map(str, TIP)))
        third = self.folder / "profile.nc"
        report = self.client.compensate_file(server.MACHINE, PROGRAM, third, calibration=number, max_correction_um=5000)
        self.assertEqual(third.read_bytes(), other.read_bytes())
        self.assertIn("of the machine's profile: --tool-tip, --dialect, --unit", report.notes)
        with self.assertRaisesRegex(axiscal.InvalidArgument, "tool_tip_mm"):
            self.client.compensate_file(server.MACHINE, PROGRAM, third, calibration=number, max_correction_um=5000, without_profile=True)
        server.axiscal(*profile)
        # Refused: the correction is too large without a word. What was there stays, and nothing lies about.
        before = sorted(path.name for path in self.folder.iterdir())
        with self.assertRaises(axiscal.FailedPrecondition):
            self.client.compensate_file(server.MACHINE, PROGRAM, target, TIP, calibration=number, unit="mm")
        self.assertEqual(target.read_bytes(), other.read_bytes())
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), before)
        with self.assertRaisesRegex(axiscal.InvalidArgument, "unit = 'metre'"):
            self.client.compensate_file(server.MACHINE, PROGRAM, target, TIP, unit="metre")

    def test_programs_go_up_and_down(self):
        large = self.folder / "large.nc"
        large.write_bytes(b"".join(b"N%d G01 X%d.5 F100\n" % (line, line) for line in range(60_000)))
        told = []
        record = self.client.put_program(large, told.append)
        self.assertEqual(record.size_bytes, large.stat().st_size)
        self.assertEqual(self.client.put_program(large).id, record.id)
        self.client.get_program(record.id, self.folder / "back.nc", told.append)
        self.assertEqual((self.folder / "back.nc").read_bytes(), large.read_bytes())
        self.assertEqual(told[-1].done, record.size_bytes)
        self.assertIn("large.nc", [program.name for program in self.client.programs()])

    def test_reports_carry_every_member(self):
        """Nothing that the server writes into a report is lost in the dataclasses."""
        sessions = self.upload_runs()
        job = self.client.wait(self.client.identify(server.MACHINE, sessions, ["EZ0T", "EX0T"], monte_carlo_runs=20))
        texts = [(reports.Identification, job.report_json)]
        self.client.create_machine(CASE / "machine.json")
        ids = {kind: [self.client.upload(axiscal.Session.read(file).get("machine"), file).session.id for file in sorted((CASE / kind).glob("*.csv"))]
               for kind in ("fit", "check")}
        machine = axiscal.Session.read(next((CASE / "fit").glob("*.csv"))).get("machine")
        loop = self.client.wait(self.client.close_loop(machine, ids["fit"], ids["check"]))
        self.assertEqual(loop.report.verdict, "extended")
        self.assertIn("EXX:backlash", [effect.name for effect in loop.report.effects])
        texts.append((reports.Loop, loop.report_json))
        program = self.client.put_program(PROGRAM)
        params = job_pb2.CompensateParams(machine_id=server.MACHINE, program_id=program.id, calibration_id=job.calibration_id, tool_tip_mm=TIP,
                                          options=job_pb2.RewriteOptions(max_correction_mm=5, unit=job_pb2.PROGRAM_UNIT_MILLIMETRE))
        kept = self.client.wait(self.client.create_job(job_pb2.JobParams(compensate=params)))
        texts.append((reports.Rewrite, kept.report_json))
        for cls, text in texts:
            self.assertEqual(lost(reports._parse(text), reports.read(cls, text), cls.__name__), [])


def lost(document, value, place):
    """Members of a JSON document that the dataclass made of it does not have, or has otherwise."""
    if isinstance(document, dict):
        found = []
        for name, member in document.items():
            if hasattr(value, "__dataclass_fields__"):
                fields = {field.metadata.get("member", field.name): field.name for field in value.__dataclass_fields__.values()}
                inner = getattr(value, fields[name]) if name in fields else getattr(value, "form", {}).get(name, KeyError)
            else:
                inner = value.get(name, KeyError)
            found += [f"{place}.{name}"] if inner is KeyError else lost(member, inner, f"{place}.{name}")
        return found
    if isinstance(document, list):
        if len(document) != len(value):
            return [f"{place}: {len(document)} items, {len(value)}"]
        return [each for index, item in enumerate(document) for each in lost(item, value[index], f"{place}[{index}]")]
    return [] if document == value else [f"{place}: {document!r}, {value!r}"]


class History(WithServer):
    def test_drift(self):
        frame = axiscal.Session.read(server.EXAMPLE / "B-short-run1.csv").to_frame()
        header = dict(axiscal.Session.read(server.EXAMPLE / "B-short-run1.csv").header)
        days = pd.date_range("2026-01-05", periods=4, freq="7D", tz="UTC")
        empty = self.client.drift(server.MACHINE)
        for number, day in enumerate(days):
            moved = frame.copy()  # a tool that grows by 0.01 mm a week is seen where B stands at 90 deg
            moved.loc[1, ["cx_mm", "cz_mm"]] += [-0.01 * number, 0.01 * number]
            session = axiscal.Session.from_frame(moved, {**header, "session": f"week-{number}", "started": day})
            job = self.client.identify(server.MACHINE, [self.client.upload(server.MACHINE, session).session.id], ["EZ0T"])
            self.client.approve(self.client.calibration(self.client.wait(job).calibration_id))
        table = self.client.drift(server.MACHINE, ["EZ0T"])
        self.assertEqual(list(table.dtypes), list(empty.dtypes))
        self.assertEqual(len(empty), 0)
        self.assertEqual(list(table["last"]), list(days))
        self.assertEqual(set(table["unit"]), {"um"})
        self.assertEqual(set(table["count"]), {1})
        np.testing.assert_allclose(np.diff(table["mean"]), 10.0, atol=0.01)
        self.assertTrue((table["sigma"] > 0).all())
        later = self.client.drift(server.MACHINE, ["EZ0T"], start=days[1].to_pydatetime(), end=days[3].to_pydatetime())
        self.assertEqual(list(later["last"]), list(days[1:3]))
        with self.assertRaisesRegex(ValueError, "time zone"):
            self.client.drift(server.MACHINE, start=datetime.datetime(2026, 1, 1))
        with self.assertRaises(axiscal.InvalidArgument) as caught:
            self.client.drift(server.MACHINE, max_points=100_001)
        self.assertEqual(caught.exception.fields[0][0], "max_points")
        told = self.client.find_drift(server.MACHINE, {"EZ0T": (-5000, 5000)})
        self.assertEqual((len(told.calibration_ids), told.calibrations, len(told.forecasts)), (4, 4, 1))
        self.assertEqual((told.forecasts[0].symbol, told.forecasts[0].high), ("EZ0T", 5000.0))
        self.assertTrue(told.forecasts[0].text)
        self.assertEqual(str(told.to_frame().dtypes["at"]), "datetime64[ns, UTC]")

    def test_any_call(self):
        formats = self.client.call("Tables", "ListTableFormats", tables_service_pb2.ListTableFormatsRequest()).formats
        self.assertGreater(len(formats), 3)
        with self.assertRaisesRegex(axiscal.InvalidArgument, "no such service"):
            self.client.call("Nothing", "GetJob", jobs_service_pb2.GetJobRequest())


class Restarts(unittest.TestCase):
    def test_calls_and_watches_live_over_a_restart(self):
        with server.Folder() as folder, server.Server(folder / "a.db") as running:
            with axiscal.connect(running.address, call_deadline_s=60) as client:
                client.create_machine(server.EXAMPLE / "machine.json")
                running.kill()
                again = threading.Thread(target=running.start)
                again.start()
                self.assertEqual([machine.id for machine in client.machines()], [server.MACHINE])
                again.join()
                upload = client.upload(server.MACHINE, server.EXAMPLE / "B-short-run1.csv")
                job = client.identify(server.MACHINE, [upload.session.id], ["EZ0T"], monte_carlo_runs=3000)
                watch = client.watch(job)
                next(watch)
                running.kill()
                again = threading.Thread(target=running.start)
                again.start()
                self.assertEqual(list(watch)[-1].state, axiscal.JobState.SUCCEEDED)
                again.join()

    def test_deadlines(self):
        with server.Folder() as folder, server.Server(folder / "a.db") as running:
            with axiscal.connect(running.address, call_deadline_s=0.3) as client:
                client.create_machine(server.EXAMPLE / "machine.json")
                running.process.send_signal(19)  # SIGSTOP: it is there and says nothing
                # The signal is sent before every thread stands still; the parent is told when they all do.
                os.waitid(os.P_PID, running.process.pid, os.WSTOPPED)
                try:
                    with self.assertRaises((axiscal.DeadlineExceeded, axiscal.Unavailable)) as caught:
                        client.server_info()
                    self.assertIsInstance(caught.exception, (TimeoutError, ConnectionError))
                finally:
                    running.process.send_signal(18)

    def test_fork_is_refused_and_spawn_works(self):
        with server.Folder() as folder, server.Server(folder / "a.db") as running:
            with axiscal.connect(running.address) as client:
                version = client.server_info().software_version
                for method, expected in (("fork", "RuntimeError: gRPC began in the parent"), ("spawn", version)):
                    context = multiprocessing.get_context(method)
                    queue = context.Queue()
                    child = context.Process(target=in_child, args=(running.address, queue))
                    child.start()
                    self.assertTrue(queue.get(timeout=60).startswith(expected))
                    child.join()
                self.assertEqual(client.server_info().software_version, version)
            with self.assertRaisesRegex(ValueError, "closed"):
                client.server_info()


class Identities(unittest.TestCase):
    def test_tls_and_tokens(self):
        with server.Folder() as folder:
            make = lambda *words: subprocess.run([server.SOURCE / "deploy/make-certs", folder / "pki", *words], check=True, capture_output=True)
            make("ca")
            make("server", "localhost", "127.0.0.1")
            make("client", "cell-7")
            pki = folder / "pki"
            database = folder / "a.db"

            def admin(*words):
                return server.axiscal("--db", database, "admin", *words)

            for name, role in (("cell-7", "cell"), ("bob", "viewer"), ("ann", "admin")):
                admin("principal", "add", name)
                admin("role", "add", name, role, "--all")
            for name in ("bob", "ann"):
                admin("token", "add", name, "-o", folder / f"{name}.token")
            certificate = next(pki.rglob("localhost.crt"))
            flags = ["--tls-certificate", certificate, "--tls-key", certificate.with_suffix(".key"), "--tls-client-ca", pki / "ca.crt"]
            with server.Server(database, *map(str, flags)) as running:
                ca = str(pki / "ca.crt")
                token = folder / "now.token"
                token.write_bytes((folder / "ann.token").read_bytes())
                with axiscal.connect(running.address, ca=ca, token_file=token) as client:
                    client.create_machine(server.EXAMPLE / "machine.json")
                    token.write_bytes((folder / "bob.token").read_bytes())  # read again for each call
                    self.assertEqual(client.machine(server.MACHINE).id, server.MACHINE)
                    with self.assertRaises(axiscal.PermissionDenied) as caught:
                        client.upload(server.MACHINE, server.EXAMPLE / "B-short-run1.csv")
                    self.assertEqual(caught.exception.reason, "ROLE_MISSING")
                    self.assertIsInstance(caught.exception, PermissionError)
                    token.unlink()
                    with self.assertRaises(axiscal.Unauthenticated) as caught:
                        client.machine(server.MACHINE)
                    self.assertEqual(caught.exception.reason, "IDENTITY_MISSING")
                    token.write_text("axt_wrong\n")
                    with self.assertRaises(axiscal.Unauthenticated) as caught:
                        client.machine(server.MACHINE)
                    self.assertEqual(caught.exception.reason, "TOKEN_INVALID")
                own = next(pki.rglob("cell-7.crt"))
                with axiscal.connect(running.address, ca=ca, certificate=own, key=own.with_suffix(".key")) as client:
                    self.assertFalse(client.upload(server.MACHINE, server.EXAMPLE / "B-short-run1.csv").was_there)
                with self.assertRaisesRegex(axiscal.Unavailable, "name its authority"):
                    axiscal.connect(running.address, connect_deadline_s=0.5)


if __name__ == "__main__":
    unittest.main()
