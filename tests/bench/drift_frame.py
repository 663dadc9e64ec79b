#!/usr/bin/python3
"""Speed of drift in Python: 100,000 points of one error, one for each calibration, from the server's answer into a DataFrame.

  tests/bench/drift_frame.py     after a build of build/release; prints medians of nine

The points are written into the server's database, as nobody identifies 100,000 times for a benchmark.
"""
import os
import pathlib
import sqlite3
import statistics
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


def fill(database):
    """Approved and retired calibrations, an hour apart, each with one estimate."""
    with sqlite3.connect(database) as store:
        rows = range(1, POINTS + 1)
        store.executemany(
            "INSERT INTO calibration (id, machine_id, version, machine_revision, state, etag, measured_at_utc_us, model_json, options_json, report_json,"
            " engine_version, rank, created_by, created_at_utc_us, approved_by, approved_at_utc_us, retired_at_utc_us)"
            " VALUES (?, 1, ?, 1, 3, 2, ?, '{}', '{}', '{}', 'bench', 1, 'bench', 1, 'bench', 1, 2)",
            ((row, row, BEGIN_US + row * HOUR_US) for row in rows))
        store.executemany("INSERT INTO estimate VALUES (1, 'EX0C', ?, ?, 0, 1, 1, ?, 0.5)",
                          ((BEGIN_US + row * HOUR_US, row, row * 1e-3) for row in rows))
        store.execute(
            f"INSERT INTO estimate_week SELECT machine_id, symbol, measured_at_utc_us / {WEEK_US}, unit, count(*), 0, min(estimated_um_urad),"
            " max(estimated_um_urad), sum(estimated_um_urad), min(measured_at_utc_us), max(measured_at_utc_us), 0.5, max(calibration_id)"
            f" FROM estimate GROUP BY symbol, measured_at_utc_us / {WEEK_US}")
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
