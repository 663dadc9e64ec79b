"""One case: axiscal rewrites the program, the interpreter runs both texts, the paths are compared."""
import collections
import copy
import json
import math
import os
import re
import shutil
import subprocess

from compare import Comparison, Difference, Limits
import linuxcnc
from control import Alarm, Frame
from generate import MACHINES
from iso import Iso
from kinematics import Machine
from klartext import Klartext


FLAT_CORNER_MM = 1e-3


class Failure:
    def __init__(self, mode, scenario, text, source=(), output=(), written=""):
        self.mode, self.scenario, self.text = mode, scenario, text
        self.source, self.output, self.written = source, output, written

    def short(self):
        return self.mode + ": " + re.sub(r"[-+]?\d+\.?\d*", "#", self.text)[:100]


class Outcome:
    def __init__(self):
        self.counts = collections.Counter()
        self.failures = []


def interpret(case, text, scenario, still=False, files=None, **more):
    description = MACHINES[case["machine"]]
    axes = [a for a in "XYZABC" if a in description["axes"]]
    linear = [a for a in axes if description["axes"][a]["kind"] == "linear"]
    setup = {"frame": Frame(Machine(description, {}, case["tip"])), "start": case["start"], "offsets": copy.deepcopy(case["offsets"]),
             "lengths": {int(n): v for n, v in case["lengths"].items()}, "lathe": case.get("lathe", False),
             "unit": scenario["unit"], "skip": scenario["skip"], "either": case["block_delete"] == "either", "rollover": scenario["rollover"],
             "radii": {int(n): v for n, v in case.get("radii", {}).items()}, "increment": case.get("increment"), "harmless": case.get("harmless", ()), "still": still,
             "keeps": case.get("keeps", ()), "edges": case.get("edges", {}),
             "files": files if files is not None else {n: "\n".join(t) for n, t in case.get("files", {}).items()}, **more}
    if still:
        setup["start"] = {a: 0.0 for a in axes}
    control = Klartext(axes, linear, setup) if case["dialect"] == "heidenhain" else Iso(case["dialect"], axes, linear, setup)
    try:
        return control.run(text)
    except (KeyError, ValueError, TypeError, IndexError) as error:  # words that no control reads
        raise Alarm("line %d cannot be read: %r" % (control.line, error)) from error


def states_unit(case):
    """Whether the unit stands in front of the first axis word."""
    code = r"(?i)G70(?!\d)|G71(?!\d)" if case["dialect"] == "sinumerik" else r"(?i)G20(?!\d)|G21(?!\d)"
    if case["dialect"] == "heidenhain":
        return True
    for line in case["lines"]:
        line = re.sub(r"\(.*?\)|;.*", "", line)
        if re.search(code, line):
            return True
        if re.search(r"(?i)[XYZABC]\s*[-+=.\d]", line) and not re.match(r"\s*[O%]", line):
            return False
    return False


def scenarios(case):
    """What the program and its options leave open: each must be right."""
    units = [case["unit"]]
    if not states_unit(case) and not case.get("unit_option"):
        units = ["mm", "inch"]
    skips = {"either": [False, True], "executed": [False], "skipped": [True]}[case["block_delete"]]
    if not any(line.lstrip("0123456789 ").startswith("/") for line in case["lines"]):
        skips = skips[:1]
    rotary = [a for a, v in MACHINES[case["machine"]]["axes"].items() if v["kind"] == "rotary"]
    # machine.json says how an axis counts; where it does not, both usual ways must be right.
    stated = case.get("roll_over")
    if not rotary or stated == "none":
        rollovers = [{}]
    elif stated is None:
        rollovers = [{}, {"C": "shortest"}] if "C" in rotary else [{}]
    else:
        rollovers = [{"C": stated}]
    return [{"unit": u, "skip": s, "rollover": r} for u in units for s in skips for r in rollovers]


def described(case):
    description = copy.deepcopy(dict(MACHINES[case["machine"]], structure="test"))
    for axis, values in description["axes"].items():
        if values["kind"] == "rotary":
            stated = case.get("roll_over") if axis == "C" else "none"
            if stated and "roll_over" not in case["without"]:
                values["roll_over"] = stated
    return description


def command(case, axiscal, folder, mode):
    out = [axiscal, "compensate", "--machine", os.path.join(folder, "machine.json"), "--errors", os.path.join(folder, "errors.json"),
           "--tool-tip", " ".join("%.6f" % v for v in case["tip"]), "--dialect", case["dialect"],
           "--block-delete", case["block_delete"], "--tolerance-um", str(case["tolerance_um"]), "--on-unsupported", mode,
           "--report", os.path.join(folder, "report.json")]
    for name, values in case["offsets"].items():
        if name != "G500" and name not in case.get("unstated", ()):
            out += ["--offset", " ".join([name] + ["%s=%.6f" % item for item in values.items()])]
    if case.get("table"):
        out += ["--tool-table", os.path.join(folder, "tools")]
    for number, value in case["lengths"].items() if not case.get("table") else ():
        out += ["--tool-length", "%s=%.6f" % (number, value)]
    for number, value in case.get("edges", {}).items():
        out += ["--tool-length", "%s=%.6f" % (number, value)]
    for number, value in case.get("radii", {}).items() if not case.get("table") else ():
        out += ["--tool-radius", "D%s=%.6f" % (number, value)]
    if case.get("files"):
        out += ["--subprograms", os.path.join(folder, "subs"), "--subprograms-out", os.path.join(folder, "subs-out")]
    if case.get("radii"):
        out += ["--cutter-tolerance-um", "40"]
    if case.get("unit_option") and not states_unit(case):
        out += ["--unit", case["unit"]]
    if case.get("cycle_tolerance_um"):
        out += ["--cycle-tolerance-um", str(case["cycle_tolerance_um"])]
    if case.get("harmless"):
        out += ["--harmless-m", ",".join(str(code) for code in case["harmless"])]
    if case.get("keeps"):
        out += ["--tool-change-keeps", " ".join(case["keeps"])]
    if case.get("start_option"):
        out += ["--start", " ".join("%s=%.6f" % item for item in case["start"].items())]
    if case.get("increment"):
        out += ["--integer-words", "increments"]
    if case.get("orientation"):
        out += ["--orientation"]
    if case.get("decimals"):
        out += ["--decimals", str(case["decimals"])]
    return out + [os.path.join(folder, "in.nc"), "-o", os.path.join(folder, "out.nc")]


def tool_table(case):
    """Lengths and radii as the control's own table holds them, in mm."""
    lengths, radii, d = case["lengths"], case.get("radii", {}), case["dialect"]
    rows = sorted(set(lengths) | set(radii), key=int)
    if d == "heidenhain":
        return "BEGIN TOOL MM\n%-4s %-12s %-12s %-10s %-8s %-8s\n" % ("T", "NAME", "L", "R", "DL", "DR") + "".join(
            "%-4s %-12s %+-12.4f %+-10.4f %+-8.3f %+-8.3f\n" % (n, "MILL", lengths.get(n, 0.0), radii.get(n, 0.0), 0.0, 0.0) for n in rows) + "[END]\n"
    if d == "linuxcnc":
        return "".join("T%s P%s Z%.4f D%.4f ; tool\n" % (n, n, lengths.get(n, 0.0), 2 * radii.get(n, 0.0)) for n in rows)
    return "%\nG90\n" + "".join("G10 L10 P%s R%.4f\n" % (n, lengths.get(n, 0.0)) + (
        "G10 L12 P%s R%.4f\n" % (n, radii[n]) if n in radii else "") for n in rows) + "%\n"


def write_subprograms(case, folder):
    for name in ("subs", "subs-out"):
        place = os.path.join(folder, name)
        shutil.rmtree(place, ignore_errors=True)
        os.mkdir(place)
    for name, lines in case.get("files", {}).items():
        with open(os.path.join(folder, "subs", name), "w") as file:
            file.write("\n".join(lines) + "\n")


def read_subprograms(case, folder):
    """Files that were written; of those that were not, the originals."""
    out = {}
    for place in ("subs", "subs-out"):
        for name in sorted(os.listdir(os.path.join(folder, place))) if case.get("files") else ():
            with open(os.path.join(folder, place, name)) as file:
                out[name] = file.read()
    return out


def try_case(case, axiscal, folder, modes=("refuse", "pass")):
    outcome = Outcome()
    counts = outcome.counts
    counts["programs"] += 1
    text = "\n".join(case["lines"]) + "\n"
    description = MACHINES[case["machine"]]
    machine = Machine(description, case["errors"], case["tip"])
    with open(os.path.join(folder, "machine.json"), "w") as file:
        json.dump(described(case), file)
    with open(os.path.join(folder, "errors.json"), "w") as file:
        json.dump(case["errors"], file)
    with open(os.path.join(folder, "in.nc"), "w") as file:
        file.write(text)
    if case.get("table"):
        with open(os.path.join(folder, "tools"), "w") as file:
            file.write(tool_table(case))
    write_subprograms(case, folder)
    traces = []
    for scenario in scenarios(case):
        try:
            traces.append((scenario, interpret(case, text, scenario)))
        except Alarm as alarm:
            counts["sources that the control refuses: " + re.sub(r"[-+]?\d+\.?\d*", "#", str(alarm))] += 1
    if not traces and "malformed" not in case["features"]:
        return outcome
    for mode in modes:
        out = os.path.join(folder, "out.nc")
        if os.path.exists(out):
            os.remove(out)
        done = subprocess.run(command(case, axiscal, folder, mode), capture_output=True, text=True)
        if done.returncode != 0:
            counts[mode + ": refused"] += 1
            reason = done.stderr.strip().split("\n")
            if done.returncode < 0 or not reason or "internal" in done.stderr.lower():
                outcome.failures.append(Failure(mode, None, "axiscal ended with %d: %s" % (done.returncode, done.stderr)))
            line = reason[1] if len(reason) > 1 else reason[0]
            line = re.sub(r"^.*\(([^()]*(?:\([^()]*\))?[^()]*)\)\s*$", r"\1", line) if len(reason) > 1 else line
            counts["%s: refused for: %s" % (mode, re.sub(r"[-+]?\d*\.?\d+|\b[XYZABCUVW]\b", "#", line)[-70:])] += 1
            continue
        counts[mode + ": written"] += 1
        with open(out) as file:
            written = file.read()
        with open(os.path.join(folder, "report.json")) as file:
            report = json.load(file)
        passed = {finding["line"] for finding in report["passed"]}
        ranges = report.get("not_corrected")
        for lines in ranges or ():
            passed.update(range(lines["first"], lines["last"] + 1))
        resolution = 10.0 ** -min(case.get("decimals") or 4, 4)
        inch = "G20" in text.upper() or "G70" in text.upper() or case["unit"] == "inch"
        if inch:
            resolution *= 2.54
        end = 1.2 * resolution + 2e-5
        limits = Limits(end, case["tolerance_um"] * 1e-3 + end,
                        rounding_deg=0.6 * 10.0 ** -min(case.get("decimals") or 4, 4))
        limits.lean_mm = 1e-3 * report.get("holes", {}).get("left_max_um", 0.0)
        limits.contour_mm = 1e-3 * report.get("contours", {}).get("left_max_um", 0.0)
        if case.get("orientation"):
            limits.gross_deg = 0.05 + limits.rounding_deg
            limits.gross_mm = 1.0
            limits.tilt_rad = 1.5e-5 + math.radians(limits.rounding_deg) * 2
        not_turned = {finding["line"] for finding in report.get("orientation", {}).get("not_reached", ())}
        for scenario, source in traces:
            try:
                output = interpret(case, written, scenario, files=read_subprograms(case, folder))
            except Alarm as alarm:
                outcome.failures.append(Failure(mode, scenario, "the control stops: %s" % alarm, written=written))
                break
            comparison = Comparison(machine, limits, passed, strict=mode == "refuse" or ranges is not None, not_turned=not_turned)
            for way in [scenario["rollover"].get("C", "none")] if "C" in description["axes"] else ():
                counts["%s: read on an axis C that counts by: %s%s" % (
                    mode, way, "" if case.get("roll_over") else ", unstated")] += 1
            try:
                comparison.run(source, output)
            except Difference as difference:
                # Rounded words make a corner of some 0.00001 mm be there or not: without all of them the tool must go the same way.
                flat = Comparison(machine, limits, passed, strict=comparison.strict, not_turned=not_turned)
                try:
                    flat.run(*[interpret(case, program, scenario, files=files, least_corner_mm=FLAT_CORNER_MM) for program, files in (
                        (text, None), (written, read_subprograms(case, folder)))])
                    comparison = flat
                except (Alarm, Difference):
                    outcome.failures.append(Failure(mode, scenario, difference.text, difference.source, difference.output, written))
                    break
            finally:
                counts[mode + ": moves found corrected"] += comparison.corrected
                counts[mode + ": holes found corrected"] += comparison.holes
                counts[mode + ": moves of contours found corrected"] += comparison.contour_moves
                if comparison.vector_moves:
                    counts[mode + ": moves with a tool vector found corrected"] += comparison.vector_moves
                counts[mode + ": moves found unchanged"] += comparison.unchanged
                counts[mode + ": ways back in front of passed blocks"] += comparison.brought_back
        if case["dialect"] == "linuxcnc" and linuxcnc.is_there() and not outcome.failures and not case.get("files") and traces:
            ask_linuxcnc(case, text, written, mode, folder, outcome)
    return outcome


def ask_linuxcnc(case, text, written, mode, folder, outcome):
    """Does LinuxCNC read both texts as we do? What it refuses in the source is not asked of the output."""
    description = MACHINES[case["machine"]]
    tolerance = 4e-3 if "G20" in text.upper() or case["unit"] == "inch" else 4e-4
    for scenario in scenarios(case):
        if scenario["rollover"] or scenario["unit"] == "inch" and not states_unit(case):
            continue
        for name, program in (("source", text), ("output", written)):
            try:
                calls = linuxcnc.places(case, program, folder, scenario["skip"])
            except linuxcnc.NotRead as problem:
                if name == "source":
                    outcome.counts["LinuxCNC does not read the source: " + re.sub(r"[-+]?\d+\.?\d*", "#", str(problem))[:60]] += 1
                    break
                outcome.failures.append(Failure(mode, scenario, "LinuxCNC stops: %s" % problem, written=written))
                return
            try:
                trace = interpret(case, program, scenario, still=True)
            except Alarm:
                break
            # Where a cycle begins below R, LinuxCNC goes up to R first, by rules that are not written here; and it pecks.
            if any(e.kind == "hole" for e in trace) or any(e.kind == "raw" and e.key[0] not in ("G92", "G53") for e in trace):
                outcome.counts["LinuxCNC reads it (cycles, modes or reference moves: paths not compared)"] += 1
                continue
            found = linuxcnc.differences(trace, calls, list(description["axes"]), tolerance)
            if found:
                outcome.failures.append(Failure(mode, scenario, "%s: %s" % (name, found[0]), found[1], (), written))
                return
            outcome.counts["LinuxCNC reads the %s and goes where we go" % name] += 1


def shorten(case, outcome, axiscal, folder):
    """Drops lines while the same kind of failure stays."""
    kind = outcome.failures[0].short()
    mode = outcome.failures[0].mode

    def still(lines):
        tried = dict(case, lines=lines)
        if states_unit(tried) != states_unit(case):
            return None
        result = try_case(tried, axiscal, folder, (mode,))
        same = [f for f in result.failures if f.short()[:40] == kind[:40]]
        result.failures = same or result.failures
        return (tried, result) if same else None
    best = (case, outcome)
    step = max(1, len(case["lines"]) // 2)
    while True:
        i = 0
        while i < len(best[0]["lines"]):
            lines = best[0]["lines"]
            found = still(lines[:i] + lines[i + step:])
            if found:
                best = found
            else:
                i += step
        if step == 1:
            break
        step //= 2
    for key, value in (("decimals", None), ("tolerance_um", 10.0)):
        tried = dict(best[0])
        tried[key] = value
        result = try_case(tried, axiscal, folder, (mode,))
        if [f for f in result.failures if f.short()[:40] == kind[:40]]:
            best = (tried, result)
    return best


def place(position):
    return " ".join("%s%.4f" % item for item in position.items())


def explain(case, outcome, out):
    for failure in outcome.failures[:1]:
        print("\n== seed %s, %s on %s, --on-unsupported %s, %s" %
              (case["seed"], case["dialect"], case["machine"], failure.mode, failure.scenario), file=out)
        print("features: %s" % " ".join(case["features"]), file=out)
        print("errors: %s" % json.dumps(case["errors"]), file=out)
        print(" ".join(repr(a) if " " in a else a for a in command(case, "axiscal", ".", failure.mode)), file=out)
        print("source:\n  " + "\n  ".join(case["lines"]), file=out)
        print("written:\n  " + "\n  ".join(failure.written.rstrip().split("\n")), file=out)
        print("FAILS: " + failure.text, file=out)
        s = failure.source
        if s:
            lines = case["lines"] if s.line <= len(case["lines"]) else [""] * s.line  # of a subprogram in a file
            print("source line %d: %s" % (s.line, lines[s.line - 1]), file=out)
            if s.kind == "move":
                print("  from %s\n    to %s" % (place(s.start), place(s.end)), file=out)
        written = failure.written.split("\n")
        for o in list(failure.output)[:8]:
            print("written line %d: %s" % (o.line, written[o.line - 1] if o.line <= len(written) else ""), file=out)
            if o.kind == "move":
                print("  from %s\n    to %s" % (place(o.start), place(o.end)), file=out)
    if not outcome.failures:
        print("no failure: " + ", ".join("%s %d" % item for item in sorted(outcome.counts.items())), file=out)
