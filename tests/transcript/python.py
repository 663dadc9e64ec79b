"""What a cell, an MES and a technician do by the package `axiscal` alone. Started by tests/transcript/python, which has made the server and tokens."""
import pathlib
import sys
import time

import axiscal

ADDRESS, EXAMPLE = sys.argv[1], pathlib.Path(sys.argv[2])
MT = "integrex-i200"


def show(text, value=""):
    print(f">>> {text}")
    if str(value):
        print(str(value)[:600])


def refused(error, text, call):
    show(text)
    try:
        call()
    except error as raised:
        print(f"{type(raised).__name__} {raised.reason}: {raised}"[:300])
        return raised
    raise SystemExit(f"{text}: was not refused")


cell, bob, ann = (axiscal.connect(ADDRESS, token_file=f"{who}.token") for who in ("cell", "bob", "ann"))

print("== The cell: a controller's log as it is, and sessions")
log = cell.upload_log(MT, EXAMPLE / "fig-5.13-touch-log.txt", EXAMPLE / "fig-5.13.template")
show("cell.upload_log(...)", log)
assert log.session.instrument == "touch" and log.session.readings == 21 and not log.was_there
assert cell.upload_log(MT, EXAMPLE / "fig-5.13-touch-log.txt", EXAMPLE / "fig-5.13.template").was_there
wrong = pathlib.Path("wrong.txt")
wrong.write_bytes((EXAMPLE / "fig-5.13-touch-log.txt").read_bytes().replace(b"X-", b"X!"))
raised = refused(axiscal.InvalidArgument, "cell.upload_log(wrong)", lambda: cell.upload_log(MT, wrong, EXAMPLE / "fig-5.13.template"))
assert raised.reason == "LOG_INVALID" and raised.facts["line"], raised.facts
uploads = [cell.upload(MT, EXAMPLE / f"B-{name}.csv") for name in ("short-run1", "long-run1", "short-run2", "long-run2")]
show("cell.upload(...)", [(upload.session.id, upload.session.name, upload.session.readings) for upload in uploads])
refused(axiscal.PermissionDenied, "cell.identify(...)", lambda: cell.identify(MT, [uploads[0].session.id]))

print("\n== The MES: what is expected")
bob.set_expectations(MT, {"EZ0T": (-1000, 1000)})
show('bob.set_expectations(MT, {"EZ0T": (-1000, 1000)})')

print("\n== The technician: identify, watch")
job = bob.identify(MT, [upload.session.id for upload in uploads], ["EZ0T", "EX0T"])
stages = []
job = bob.wait(job, progress=lambda now: stages.append(f"{now.state.value} {now.progress.fraction:.0%} {now.progress.stage}".strip()))
show("bob.wait(job, progress=...)", "\n".join(dict.fromkeys(stages)))
show("job.report.errors", "\n".join(f"{error.symbol} {error.value:.1f} +- {error.sigma:.1f} {error.unit}" for error in job.report.errors))
calibration = bob.calibration(job.calibration_id)
refused(axiscal.PermissionDenied, "bob.approve(calibration)", lambda: bob.approve(calibration))

print("\n== Another person approves; the event comes")
approved = ann.approve(calibration, "agrees with the gauge")
show("ann.approve(calibration)", (approved.state.name, approved.approved_by))
since = time.monotonic()
for change in bob.watch_events(after=0):
    if change.event.kind == "out_of_tolerance":
        show("bob.watch_events(after=0)", f"{change.number} {change.what} {change.event.text}")
        break
    assert time.monotonic() - since < 60, "no event came"
frame = bob.volumetric(MT)
show("bob.volumetric(MT)", frame[["calibration", "uncorrected_rms", "after_rms", "after_rms_high", "known_share"]])
assert frame.after_rms[0] <= frame.uncorrected_rms[0]  # a length and a centre of the tool: both are taken up
drift = bob.drift(MT)
show("bob.drift(MT)", drift[["symbol", "last", "mean", "sigma", "unit"]])
assert len(drift) == 2

print("\n== A program down")
report = bob.compensate_file(MT, EXAMPLE / "fig-4.30-original.nc", "corrected.nc", [0, 0, -356.3945], unit="mm", dialect="mazak", max_correction_um=5000)
show("bob.compensate_file(...)", f"{report.blocks.corrected} blocks, {report.tool_point_error.before.max_um:.0f} -> "
     f"{report.tool_point_error.after.max_um:.2f} um")
assert b"AXISCAL COMPENSATED" in pathlib.Path("corrected.nc").read_bytes()

print("\n== A session that was bad: what stands on it is marked")
show('bob.reject(session, "the probe was loose")', bob.reject(uploads[0].session.id, "the probe was loose"))
assert bob.calibration(calibration.id).rejected_session_ids == (uploads[0].session.id,)
refused(axiscal.FailedPrecondition, "bob.identify(rejected)", lambda: bob.identify(MT, [uploads[0].session.id]))
assert bob.volumetric(MT).empty
for client in (cell, bob, ann):
    client.close()
