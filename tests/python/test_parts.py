"""What needs no server: checksums, session files, frames, options, reports that are wrong."""
import os
import pathlib
import random
import re
import subprocess
import sys
import unittest
from unittest import mock

import grpc
import numpy as np
import pandas as pd

import axiscal
from axiscal import errors, reports
from axiscal._connection import Connection
from axiscal._crc32c import crc32c
from axiscal._options import Options
from axiscal.drift import DriftReport, points_frame
from axiscal.session import TEXT_COLUMNS
from axiscal.v1 import history_service_pb2

import server

HEADER = "# machine: mt\n# session: s\n# instrument: ballbar\n"


class Crc32c(unittest.TestCase):
    def test_known_answers(self):
        # RFC 3720, B.4; and the check value of the CRC catalogue.
        self.assertEqual(crc32c(b"123456789"), 0xE3069283)
        self.assertEqual(crc32c(bytes(32)), 0x8A9136AA)
        self.assertEqual(crc32c(b"\xff" * 32), 0x62A8AB43)
        self.assertEqual(crc32c(bytes(range(32))), 0x46DD794E)
        self.assertEqual(crc32c(b""), 0)

    def test_lanes_are_the_loop_over_bytes(self):
        draw = random.Random(1)
        data = draw.randbytes(5000)
        for length in (255, 256, 1023, 1024, 1025, 4096, 5000):
            by_bytes = 0
            for byte in data[:length]:  # below four lanes it is the loop
                by_bytes = crc32c(bytes([byte]), by_bytes)
            self.assertEqual(crc32c(data[:length]), by_bytes, length)
            self.assertEqual(crc32c(data[7:length], crc32c(data[:7])), by_bytes, length)


class SessionFiles(unittest.TestCase):
    def refused(self, data, words):
        with self.assertRaises(axiscal.InvalidArgument) as caught:
            axiscal.Session.parse(data.encode() if isinstance(data, str) else data)
        self.assertEqual(caught.exception.reason, "SESSION_INVALID")
        for word in words:
            self.assertIn(word, str(caught.exception))

    def test_wrong_files_are_refused_with_their_place(self):
        self.refused("t_s,dL_mm\n1,2\n", ["line 1", "expected header lines"])
        self.refused(HEADER + "t_s,dL_mm\n", ["no readings"])
        self.refused(HEADER + "t_s,dL_mm\n1,2\n2,3", ["line 6", "no line end"])
        self.refused(HEADER + "t_s,dL_mm\n1,2\n2,3,4\n", ["line 6", "3 cells, expected 2"])
        for cell in ("1.5.", "nan", "inf", "1_0", " 1", "0x1", "1e999", "l"):
            self.refused(HEADER + f"t_s,dL_mm\n1,2\n2,{cell}\n", ["line 6, column 2 (dL_mm)", cell])
        self.refused(HEADER.encode() + b"t_s,dL_mm\n1,\xff\n", ["line 5", "UTF-8"])
        self.refused(HEADER + "t_s,dL_mm\n1,\0\n", ["line 5", "NUL"])
        self.refused("# machine mt\nt_s\n1\n", ["line 1", "# key: value"])

    def test_files_are_read_as_they_are(self):
        text = "\ufeff" + HEADER + "# sphere S1: 1 2 3 4\nt_s,feature,dL_mm\r\n+1,S1,-2.5e-3\n2,S1,\n"
        session = axiscal.Session.parse(text.encode())
        self.assertEqual(session.get("sphere S1"), "1 2 3 4")
        self.assertEqual(session.columns[1].texts, ["S1", "S1"])
        self.assertEqual(session.columns[2].values[0], -2.5e-3)
        self.assertTrue(np.isnan(session.columns[2].values[1]))
        self.assertEqual(len(session), 2)

    def test_every_sample_comes_back_from_its_own_text(self):
        files = list(server.EXAMPLE.glob("*-run*.csv")) + list((server.SOURCE / "tests/data/loop").glob("case-00*/*/*.csv"))
        self.assertGreater(len(files), 20)
        for file in files:
            session = axiscal.Session.read(file)
            again = axiscal.Session.parse(session.to_csv().encode())
            self.assertEqual(session.content_id("mt", 1000), again.content_id("mt", 1000), file)

    def test_frames(self):
        frame = pd.DataFrame({"t_s": [0, 1], "dL_mm": [0.5, np.nan], "run": ["a", "b"]})
        session = axiscal.Session.from_frame(frame, {"machine": "mt", "session": "s", "tool_tip_mm": [0, 0, -356.4], "sigma_um": 0.3,
                                                     "note": ["one", "two"], "started": pd.Timestamp("2026-05-31T14:03:00Z")})
        self.assertEqual(session.header, [("machine", "mt"), ("session", "s"), ("tool_tip_mm", "0.0 0.0 -356.4"), ("sigma_um", "0.3"),
                                          ("note", "one"), ("note", "two"), ("started", "2026-05-31T14:03:00+00:00")])
        pd.testing.assert_frame_equal(session.to_frame(), frame.astype({"t_s": "float64"}))
        for wrong, words in (({"t_s": pd.to_datetime(["2026-01-01", "2026-01-02"])}, "seconds in t_s"), ({"dL_mm": [1.0, np.inf]}, "row 1"),
                             ({"dL_mm": ["1", "2"]}, "expected numbers"), ({"run": [1, 2]}, "expected a text"), ({"dL_mm": []}, "no readings")):
            with self.assertRaisesRegex(axiscal.InvalidArgument, words):
                axiscal.Session.from_frame(pd.DataFrame(wrong), {"machine": "mt"})
        with self.assertRaisesRegex(axiscal.InvalidArgument, "time zone"):
            axiscal.Session.from_frame(frame, {"started": pd.Timestamp("2026-05-31")})

    def test_columns_of_names_are_those_of_the_engine(self):
        text = (server.SOURCE / "core/session/instrument_format.cc").read_text()
        named = set(re.findall(r'\bName\("(\w+)"\)', text))
        self.assertEqual(named, set(TEXT_COLUMNS))


class OptionsAndAddresses(unittest.TestCase):
    def test_arguments_then_environment_then_default(self):
        with mock.patch.dict(os.environ, {"AXISCAL_CALL_DEADLINE_S": "7.5", "AXISCAL_CHUNK_READINGS": "10", "AXISCAL_USER": "cell-7"}):
            options = Options.read(chunk_readings=20)
        self.assertEqual((options.call_deadline_s, options.chunk_readings, options.user, options.give_up_after_s), (7.5, 20, "cell-7", 60.0))

    def test_wrong_ones_are_refused_by_name(self):
        for given, words in (({"call_deadline_s": 0}, "call_deadline_s = 0"), ({"chunk_readings": 5000}, "1 to 4096"),
                             ({"certificate": "a.crt"}, "together"), ({"user": "a\nb"}, "printable"), ({"ca": "missing.crt"}, "missing.crt")):
            with self.assertRaisesRegex(axiscal.InvalidArgument, words):
                Connection("127.0.0.1:1", Options.read(**given))
        with mock.patch.dict(os.environ, {"AXISCAL_CALL_DEADLINE_S": "soon"}):
            with self.assertRaisesRegex(axiscal.InvalidArgument, "AXISCAL_CALL_DEADLINE_S = 'soon'"):
                Options.read()
        with self.assertRaisesRegex(TypeError, "no option colour"):
            axiscal.connect("127.0.0.1:1", colour="red")
        with self.assertRaisesRegex(axiscal.InvalidArgument, "AXISCAL_SERVER"):
            axiscal.connect()

    def test_a_token_is_never_sent_readable(self):
        with server.Folder() as folder:
            token = folder / "a.token"
            token.write_text("axt_secret\n")
            with self.assertRaisesRegex(axiscal.InvalidArgument, "readable"):
                axiscal.connect("axiscal.shop:7410", token_file=token)
            token.write_text("two words\n")
            with self.assertRaisesRegex(axiscal.InvalidArgument, "one token"):
                axiscal.connect("127.0.0.1:1", token_file=token)

    def test_no_server(self):
        with self.assertRaises(axiscal.Unavailable) as caught:
            axiscal.connect("127.0.0.1:1", connect_deadline_s=0.2)
        self.assertEqual(caught.exception.reason, "NO_CONNECTION")
        self.assertIsInstance(caught.exception, ConnectionError)
        with axiscal.connect("127.0.0.1:1", connect_deadline_s=0, call_deadline_s=0.3) as client:
            with self.assertRaises(axiscal.Unavailable) as caught:
                client.server_info()
            self.assertEqual(caught.exception.reason, "NO_CONNECTION")


class Ended(grpc.RpcError):
    """A call that ended without the service's details."""

    def __init__(self, code, details):
        self._code, self._details = code, details

    def code(self):
        return self._code

    def details(self):
        return self._details

    def trailing_metadata(self):
        return ()


class BrokenConnections(unittest.TestCase):
    def test_what_to_do_is_said(self):
        for code, details in ((grpc.StatusCode.UNKNOWN, "Stream removed"), (grpc.StatusCode.UNAVAILABLE, "Socket closed"),
                              (grpc.StatusCode.CANCELLED, "Received RST_STREAM with error code 8")):
            error = errors.from_grpc(Ended(code, details))
            self.assertIsInstance(error, axiscal.Unavailable)
            self.assertEqual(error.reason, "CONNECTION_LOST")
            self.assertRegex(str(error), "repeat the call")
        for code, details in ((grpc.StatusCode.UNKNOWN, "else"), (grpc.StatusCode.CANCELLED, "by the caller"),
                              (grpc.StatusCode.RESOURCE_EXHAUSTED, "Received RST_STREAM with error code 11")):
            self.assertEqual(errors.from_grpc(Ended(code, details)).reason, "")


class Frames(unittest.TestCase):
    def test_types_are_the_same_when_empty(self):
        full = history_service_pb2.QueryDriftResponse()
        series = full.series.add(symbol="EX0C", unit=1)
        series.points.add(first_utc_us=1, last_utc_us=1_700_000_000_123_456, count=2, min_value=-1, max_value=2, mean_value=0.5, sigma=0.25,
                          last_calibration_id=7)
        series.points.add(last_utc_us=2, count=1)
        full.series[0].points[1].sigma = 0.0
        full.series.add(symbol="EA0B", unit=2).points.add(count=1)
        frame, empty = points_frame(full), points_frame(history_service_pb2.QueryDriftResponse())
        self.assertEqual(list(frame.dtypes), list(empty.dtypes))
        self.assertEqual(list(frame.columns), list(empty.columns))
        self.assertEqual(str(frame.dtypes["last"]), "datetime64[ns, UTC]")
        self.assertEqual(frame.loc[0, "last"], pd.Timestamp("2023-11-14T22:13:20.123456Z"))
        self.assertEqual(list(frame["symbol"] + " " + frame["unit"]), ["EX0C um", "EX0C um", "EA0B urad"])
        self.assertEqual(frame["sigma"].tolist()[:2], [0.25, 0.0])
        self.assertTrue(np.isnan(frame["sigma"].iloc[2]))

    def test_findings(self):
        response = history_service_pb2.FindDriftResponse(calibration_ids=[1, 2], calibrations=3)
        finding = response.findings.add(kind=history_service_pb2.DRIFT_FINDING_KIND_STEP, text="it jumped", at_utc_us=5_000_000, certainty=0.997)
        finding.amounts.add(symbol="EX0C", unit=1, size=21, sigma=0.5)
        finding.amounts.add(symbol="EB0C", unit=2, size=14, sigma=0.25)
        response.findings.add(kind=history_service_pb2.DRIFT_FINDING_KIND_NOISE, text="noisy", after_utc_us=1)
        report = DriftReport.from_message(response)
        frame, empty = report.to_frame(), DriftReport.from_message(history_service_pb2.FindDriftResponse()).to_frame()
        self.assertEqual(list(frame.dtypes), list(empty.dtypes))
        self.assertEqual(frame["kind"].tolist(), ["step", "step", "noise"])
        self.assertEqual(frame["finding"].tolist(), [0, 0, 1])
        self.assertEqual(str(frame.dtypes["after"]), "datetime64[ns, UTC]")
        self.assertTrue(pd.isna(frame.loc[0, "after"]) and pd.isna(frame.loc[2, "certainty"]))
        self.assertEqual(frame.loc[0, "at"], pd.Timestamp("1970-01-01T00:00:05Z"))


class WrongReports(unittest.TestCase):
    def test_the_wrong_member_is_named(self):
        for text, words in (("{", "report"), ("[]", "object"), ('{"errors": 5}', "report.errors"), ('{"errors": [{"value": 1}]}', r"report.errors\[0\].symbol"),
                            ('{"rank": "4"}', "report.rank"), ('{"rank": true}', "report.rank")):
            with self.assertRaisesRegex(axiscal.InvalidArgument, words):
                reports.read(reports.Identification, text)

    def test_members_of_newer_servers_are_left_out(self):
        report = reports.read(reports.Identification, '{"rank": 4, "news": 1, "errors": [{"symbol": "EX0C", "value": 3, "sigma": null}]}')
        self.assertEqual((report.rank, report.errors[0].value, report.errors[0].sigma), (4, 3.0, None))


class Package(unittest.TestCase):
    def test_types(self):
        """mypy --strict finds nothing in what the wheel holds, and its users see the types (py.typed)."""
        root = pathlib.Path(axiscal.__file__).parent
        self.assertTrue((root / "py.typed").is_file())
        with server.Folder() as folder:
            user = folder / "user.py"
            user.write_text("import axiscal\nreveal_type(axiscal.connect('x').identify('mt', [1]).calibration_id)\naxiscal.connect('x').job('1')\n")
            config = ["--config-file", str(server.SOURCE / "client/python/pyproject.toml"), "--cache-dir", str(folder / "cache")]
            run = lambda *words: subprocess.run([sys.executable, "-m", "mypy", *config, *words], cwd=root.parent, capture_output=True, text=True)
            whole = run("axiscal")
            self.assertEqual(whole.returncode, 0, whole.stdout + whole.stderr)
            told = subprocess.run([sys.executable, "-m", "mypy", *config, str(user)], cwd=folder, capture_output=True, text=True,
                                  env={**os.environ, "MYPYPATH": str(root.parent)}).stdout
            self.assertRegex(told, r"Revealed type is .*(Union\[builtins.int, None\]|Optional\[builtins.int\])")
            self.assertIn('Argument 1 to "job" of "Client" has incompatible type "str"', told)


if __name__ == "__main__":
    unittest.main()
