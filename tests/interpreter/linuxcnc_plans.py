#!/usr/bin/env python3
"""Every measuring program that Axiscal writes for LinuxCNC runs in LinuxCNC's own interpreter (rs274 of Debian's linuxcnc-uspace): all tests
that each example machine can run, and the programs of a tool setter's rods and start angles. Positions that a plan commands are where rs274 sends the axes,
in the plan's order; touches are probing moves, as many as the plan has.

  tests/interpreter/linuxcnc_plans.py AXISCAL [EXAMPLE...]
"""
import csv
import glob
import json
import os
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLES = os.path.join(HERE, "..", "..", "deploy", "examples")
sys.path.insert(0, HERE)

import linuxcnc  # noqa: E402

WITHIN = 2e-4  # mm or deg: four decimals of the program, four of rs274


def run(axiscal, folder, *arguments):
    done = subprocess.run([axiscal] + list(arguments), capture_output=True, text=True, cwd=folder)
    return done.returncode, done.stdout, done.stderr


def must(axiscal, folder, *arguments):
    code, out, err = run(axiscal, folder, *arguments)
    if code != 0:
        raise RuntimeError(" ".join(arguments) + ": " + err)
    return out


def with_travel(machine):
    """Tests along linear axes go over their travel; axes that tilt need one."""
    for axis in machine["axes"].values():
        if axis["kind"] == "linear":
            axis.setdefault("travel_mm", [-600, 600])
        elif not axis.get("roll_over"):
            axis.setdefault("travel_deg", [-180, 180])
    return machine


def rows_of(text):
    lines = [line for line in text.split("\n") if line and not line.startswith("#")]
    return list(csv.DictReader(lines))


def visits(places, rows, axes):
    """The index of the first row that no place, from that of the row before on, is at; None: all are visited in order."""
    at = 0
    for index, row in enumerate(rows):
        def is_there(place):
            return all(abs(place[a] - float(row[column])) <= WITHIN for a, column in axes.items())
        while at < len(places) and not is_there(places[at][0]):
            at += 1
        if at == len(places):
            return index
    return None


class Programs:
    def __init__(self, axiscal, folder):
        self.axiscal, self.folder = axiscal, folder
        self.run_by, self.failed = {}, []

    def read(self, name):
        with open(os.path.join(self.folder, name)) as file:
            return file.read()

    def check(self, title, program, rows, instrument):
        """A program that was written, by rs274."""
        probed = []
        try:
            places = linuxcnc.places({"offsets": {}, "lengths": {}}, program, self.folder, False, probed)
        except linuxcnc.NotRead as refusal:
            self.failed.append("%s: %s" % (title, refusal))
            return
        columns = list(rows[0])
        if instrument in ("touch", "centres", "tool-setter", "tool-curve"):
            touches = len(rows) * (5 if instrument == "centres" else 1)
            if len(probed) != touches:
                self.failed.append("%s: %d probing moves, the plan has %d" % (title, len(probed), touches))
        else:
            axes = {c[0]: c for c in columns if re.fullmatch(r"[XYZABC]_(mm|deg)", c)}
            missed = visits(places, rows, axes)
            if missed is not None:
                self.failed.append("%s: rs274 never goes to line %d of the plan" % (title, missed + 1))
        self.run_by[instrument] = self.run_by.get(instrument, 0) + 1

    def machine(self, name, machine):
        """All sessions of the first machine; of the others the first session of each test: another structure, the same pattern."""
        is_first, seen = not self.run_by, set()
        with open(os.path.join(self.folder, "machine.json"), "w") as file:
            json.dump(with_travel(machine), file)
        listed = json.loads(must(self.axiscal, self.folder, "plan", "--machine", "machine.json", "--list", "--json"))
        for test in listed["tests"]:
            session = test["session"]
            if not is_first and test["test"] in seen:
                continue
            seen.add(test["test"])
            must(self.axiscal, self.folder, "plan", "--machine", "machine.json", session, "-o", "plan.csv")
            code, _, err = run(self.axiscal, self.folder, "plan", "--machine", "machine.json", session, "-o", "plan.ngc",
                               "--dialect", "linuxcnc")
            if code != 0 and "beyond the travel" in err:  # of a machine that states it; nothing is written
                print("%s %s: %s" % (name, session, err.strip()))
                continue
            if code != 0:
                self.failed.append("%s %s: not written: %s" % (name, session, err.strip()))
                continue
            plan = self.read("plan.csv")
            instrument = re.search(r"(?m)^# instrument: (\S+)$", plan).group(1)
            self.check("%s %s" % (name, session), self.read("plan.ngc"), rows_of(plan), instrument)

    def tool_setter(self):
        beam = [part for axis in ("X 100", "Y -20", "Z -510") for part in ("--beam-at", axis)]
        mill = {"id": "mill", "axes": {a: {"kind": "linear", "direction": [float(a == b) for b in "XYZ"]} for a in "XYZ"},
                "tool_branch": ["X", "Y", "Z"], "work_branch": [], "tool_direction": [0, 0, -1]}
        with open(os.path.join(self.folder, "machine.json"), "w") as file:
            json.dump(mill, file)
        for test, tools in (("tool-setter", "fang-tool-setter/tool-setter-aligned.csv"), ("tool-curve", "fang-round-insert/cutter.json")):
            path = os.path.abspath(os.path.join(EXAMPLES, tools))
            extra = ["--starts", "12"] if test == "tool-curve" else []
            if test == "tool-setter":
                with open(path) as file:
                    text = re.sub(r"(?m)^# machine: .*$", "# machine: mill", file.read())
                path = os.path.join(self.folder, "rods.csv")
                with open(path, "w") as file:
                    file.write(text)
            common = ["plan", "--machine", "machine.json", test, "--tools", path] + extra
            must(self.axiscal, self.folder, *common, "-o", "plan.csv")
            must(self.axiscal, self.folder, *common, "-o", "plan.ngc", "--dialect", "linuxcnc", *beam)
            self.check(test, self.read("plan.ngc"), rows_of(self.read("plan.csv")), test)


def main():
    axiscal = os.path.abspath(sys.argv[1])
    if not linuxcnc.is_there():
        print("linuxcnc-uspace is not here")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        programs = Programs(axiscal, folder)
        for path in sorted(glob.glob(os.path.join(EXAMPLES, "*", "**", "machine.json"), recursive=True)):
            name = os.path.relpath(os.path.dirname(path), EXAMPLES)
            with open(path) as file:
                if len(sys.argv) == 2 or name in sys.argv[2:]:
                    programs.machine(name, json.load(file))
        programs.tool_setter()
    print("run by rs274: " + ", ".join("%s %d" % item for item in sorted(programs.run_by.items())))
    for failure in programs.failed:
        print(failure)
    # A machine that runs no test would pass by silence.
    expected = {"ballbar", "rtest", "centres", "touch", "length", "direction", "tracker", "tool-setter", "tool-curve"}
    missing = expected - set(programs.run_by)
    if missing:
        print("no program of: " + ", ".join(sorted(missing)))
    return 1 if programs.failed or missing else 0


if __name__ == "__main__":
    sys.exit(main())
