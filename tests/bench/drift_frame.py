#!/usr/bin/python3
"""Speed of drift in Python: 100,000 points of one error, one for each calibration, from the server's answer into a DataFrame.

  tests/bench/drift_frame.py     after a build of build/release; prints medians of nine

The points are written into the server's database, as nobody identifies 100,000 times for a benchmark.
"""
import os
import pathlib
import sqlite3
import statistics
import struct
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = ROOT / "build/release"
os.environ.update(AXISCALD=str(BUILD / "bin/axiscald"), AXISCAL=str(BUILD / "bin/axiscal"), AXISCAL_SOURCE=str(ROOT))
sys.dont_write_bytecode = True
sys.path[:0] = [str(BUILD / "python/package"), str(ROOT / "tests/python")]

import axiscal  # noqa: E402
from axiscal.drift import points_frame  # noqa: E402
from axiscal.v1 import history_service_pb2  # noqa: E402

import server  # noqa: E402

POINTS = 100_000
RUNS = 9
HOUR_US = 3_600_000_000
WEEK_US = 168 * HOUR_US
BEGIN_US = 1_500_000_000_000_000
# The columns that a row's checksum is of.
ESTIMATE = "machine_id, symbol, measured_at_utc_us, calibration_id, position, unit, identifiable, estimated_um_urad, sigma_um_urad"
WEEK = ("machine_id, symbol, week, unit, estimate_count, not_identifiable_count, min_um_urad, max_um_urad, sum_um_urad, first_at_utc_us, last_at_utc_us,"
        " last_sigma_um_urad, last_calibration_id")


def crc32c_table():
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
        yield byte


CRC32C = tuple(crc32c_table())


def row_crc32c(*values):
    """The server's checksum of a row (server/storage/row_checksum.h): it shows no row without it."""
    crc = 0xFFFFFFFF
    for value in values:
        if isinstance(value, int):
            packed = struct.pack("<Bq", 1, value)
        elif isinstance(value, float):
            packed = struct.pack("<Bd", 2, value + 0.0)
        else:
            text = value.encode()
            packed = struct.pack("<BQ", 3, len(text)) + text
        for byte in packed:
            crc = crc >> 8 ^ CRC32C[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def fill(database):
    """Approved and retired calibrations, an hour apart, each with one estimate."""
    with sqlite3.connect(database) as store:
        store.create_function("row_crc32c", -1, row_crc32c, deterministic=True)
        rows = range(1, POINTS + 1)
        store.executemany(
            "INSERT INTO calibration (id, machine_id, version, machine_revision, state, etag, measured_at_utc_us, model_json, options_json, report_json,"
            " engine_version, rank, created_by, created_at_utc_us, approved_by, approved_at_utc_us, retired_at_utc_us)"
            " VALUES (?, 1, ?, 1, 3, 2, ?, '{}', '{}', '{}', 'bench', 1, 'bench', 1, 'bench', 1, 2)",
            ((row, row, BEGIN_US + row * HOUR_US) for row in rows))
        store.executemany(f"INSERT INTO estimate ({ESTIMATE}) VALUES (1, 'EX0C', ?, ?, 0, 1, 1, ?, 0.5)",
                          ((BEGIN_US + row * HOUR_US, row, row * 1e-3) for row in rows))
        store.execute(f"UPDATE estimate SET crc32c = row_crc32c({ESTIMATE}, 0)")
        store.execute(
            f"INSERT INTO estimate_week ({WEEK}) SELECT machine_id, symbol, measured_at_utc_us / {WEEK_US}, unit, count(*), 0, min(estimated_um_urad),"
            " max(estimated_um_urad), sum(estimated_um_urad), min(measured_at_utc_us), max(measured_at_utc_us), 0.5, max(calibration_id)"
            f" FROM estimate GROUP BY symbol, measured_at_utc_us / {WEEK_US}")
        store.execute(f"UPDATE estimate_week SET crc32c = row_crc32c({WEEK})")
    store.close()


def medians_s(run):
    """By the clock, and of this process's own CPU time, which others on the machine do not lengthen."""
    times = []
    for _ in range(RUNS):
        begin, cpu_begin = time.perf_counter(), time.process_time()
        result = run()
        times.append((time.perf_counter() - begin, time.process_time() - cpu_begin))
    clock, cpu = (statistics.median(column) for column in zip(*times))
    return f"{clock:.3f} s (CPU {cpu:.3f} s)", result


def main():
    with server.Folder() as folder:
        database = folder / "bench.db"
        with server.Server(database) as running, axiscal.connect(running.address) as client:
            client.create_machine(server.EXAMPLE / "machine.json")
        fill(database)
        with server.Server(database) as running, axiscal.connect(running.address) as client:
            whole, frame = medians_s(lambda: client.drift(server.MACHINE))
            request = history_service_pb2.QueryDriftRequest(machine_id=server.MACHINE, max_points=POINTS)
            answer = client.call("History", "QueryDrift", request).SerializeToString()
        assert len(frame) == POINTS and frame["mean"].iloc[-1] == POINTS * 1e-3
        into_frame, _ = medians_s(lambda: points_frame(history_service_pb2.QueryDriftResponse.FromString(answer)))
    print(f"{POINTS} points, {len(answer)} bytes: answer into frame {into_frame}; client.drift(), server and network included, {whole}")


if __name__ == "__main__":
    main()
