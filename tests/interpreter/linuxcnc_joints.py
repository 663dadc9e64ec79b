#!/usr/bin/env python3
"""Tool centre point control against LinuxCNC: its interpreter (rs274) and its compiled five-axis kinematics, of Debian's linuxcnc-uspace, of a
rotary-tilting table. G43.4 H1 stands for G43 H1 and the kinematics (M428), G49 for G49 and axis positions (M429).

A program of tool points is posted by LinuxCNC's kinematics: axis positions, block by block. Both programs are corrected for a machine with
errors, one in the workpiece's frame, the other in that of the axes, and LinuxCNC takes both to joints. They are the same, to what rs274 prints.

  tests/interpreter/linuxcnc_joints.py AXISCAL
"""
import ctypes
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)

import linuxcnc  # noqa: E402

MODULES = "/usr/lib/linuxcnc/modules"
DEMOS = "/usr/share/doc/linuxcnc/examples/sample-configs/sim/axis/vismach/5axis/table-rotary-tilting/demos"
LENGTH_MM = 87.5  # of tool 1
# Where the tilting axis turns, beside the rotary one: the pins of the kinematics.
ASIDE_MM, UP_MM = 20.0, 10.0
# Words have six decimals here, but rs274 prints four: half of the last one for each of two poses, in three axes.
ROUNDING_MM = 1.01e-4 * math.sqrt(3)
ERRORS = {"EX0C": 30.0, "EY0C": -25.0, "EA0C": 60.0, "EZ0A": 22.0, "EY0A": 17.0, "EX0B": 17.0, "EZ0B": 22.0, "EC0Y": 40.0, "EB0Z": -35.0}


class Kinematics:
    """xyzac-trt-kins or xyzbc-trt-kins: joints of a pose."""

    def __init__(self, tilting, folder):
        name = "xyz%sc-trt-kins" % tilting.lower()
        library = os.path.join(folder, "hal_pins.so")
        if not os.path.exists(library):
            subprocess.run([os.environ.get("CC", "cc"), "-shared", "-fPIC", "-O1", "-w", "-o", library, os.path.join(HERE, "hal_pins.c")], check=True)
        pins = ctypes.CDLL(library, mode=ctypes.RTLD_GLOBAL)
        pins.set_pin.argtypes = [ctypes.c_char_p, ctypes.c_double]
        self.module = ctypes.CDLL(os.path.join(MODULES, name + ".so"))
        if self.module.rtapi_app_main() != 0:
            raise RuntimeError(name + " does not begin")
        self.set = lambda pin, value: pins.set_pin(("%s.%s" % (name, pin)).encode(), value) or self.missing(pin)
        self.set("x-offset" if tilting == "B" else "y-offset", ASIDE_MM)
        self.set("z-offset", UP_MM)

    @staticmethod
    def missing(pin):
        raise RuntimeError("the kinematics have no pin " + pin)

    def joints(self, pose, length):
        """Of a pose whose Z has the tool's length."""
        self.set("tool-offset", length)
        values = (ctypes.c_double * 9)(*[pose[a] for a in "XYZABC"])
        joints, flags = (ctypes.c_double * 16)(), ctypes.c_ulong(0)
        self.module.kinematicsInverse(values, joints, ctypes.byref(flags), ctypes.byref(ctypes.c_ulong(0)))
        return list(joints[:5])


def machine(tilting):
    aside = [ASIDE_MM, 0, UP_MM] if tilting == "B" else [0, ASIDE_MM, UP_MM]
    return {"id": "trt", "structure": "wC'%s'bXYZt" % tilting, "axes": dict(
        {a: {"kind": "linear", "direction": [float(a == b) for b in "XYZ"]} for a in "XYZ"}, **{
            tilting: {"kind": "rotary", "roll_over": "none", "direction": [0, 1, 0] if tilting == "B" else [1, 0, 0], "point_mm": aside},
            "C": {"kind": "rotary", "roll_over": "none", "direction": [0, 0, 1], "point_mm": [0, 0, 0]}}),
        "tool_branch": ["X", "Y", "Z"], "work_branch": [tilting, "C"], "tool_direction": [0, 0, -1]}


def drawn(tilting, seed):
    rng = random.Random(seed)
    lines = ["G21 G90 G17 G94 G54", "G43.4 H1", "G0 X0. Y0. Z60. %s0. C0." % tilting]
    for _ in range(200):
        lines.append("G1 X%.4f Y%.4f Z%.4f %s%.4f C%.4f F800." % (
            rng.uniform(-60, 60), rng.uniform(-60, 60), rng.uniform(0, 60), tilting, rng.uniform(-80, 80), rng.uniform(-170, 170)))
    return lines + ["G49", "M2"]


class Shop:
    def __init__(self, axiscal, folder, tilting):
        self.axiscal, self.folder, self.tilting = axiscal, folder, tilting
        self.kinematics = Kinematics(tilting, folder)
        self.case = {"offsets": {"G54": {"X": 12.5, "Y": -7.25, "Z": 33.0}}, "lengths": {"1": LENGTH_MM}}
        self.write("machine.json", json.dumps(machine(tilting)))
        self.write("errors.json", json.dumps({k: v for k, v in ERRORS.items() if k[3] in "XYZ%sC" % tilting}))

    def write(self, name, text):
        with open(os.path.join(self.folder, name), "w") as file:
            file.write(text)

    def run(self, *arguments):
        done = subprocess.run([self.axiscal] + list(arguments) + [
            "--machine", "machine.json", "--errors", "errors.json", "--tool-tip", "0 0 0", "--dialect", "fanuc", "--unit", "mm",
            "--tool-length", "H1=%s" % LENGTH_MM, "--offset", "G54 " + " ".join("%s=%s" % item for item in self.case["offsets"]["G54"].items()),
            # One block stays one block: ends are compared.
            "--tolerance-um", "100000", "--decimals", "6", "--tool-change-keeps", "%s C" % self.tilting, "--start", "X=0 Y=0 Z=150 %s=0 C=0" % self.tilting],
            capture_output=True, text=True, cwd=self.folder)
        if done.returncode != 0:
            raise RuntimeError(" ".join(arguments) + ": " + done.stderr)
        return done.stdout

    def corrected(self, name, lines):
        self.write(name, "\n".join(lines) + "\n")
        self.run("compensate", name, "-o", "out-" + name)
        self.run("verify", name, "out-" + name)
        with open(os.path.join(self.folder, "out-" + name)) as file:
            return file.read().split("\n")

    def poses(self, lines):
        return [place for place, _, _ in linuxcnc.places(self.case, "\n".join(lines).replace("G43.4", "G43") + "\n", self.folder, False)]

    def joints(self, lines):
        """Of each move. What is in force at it, the text says: rs274 makes one move of each block with axis words here."""
        is_tool_point, length, out = False, 0.0, []
        poses = iter(self.poses(lines))
        for line in lines:
            words = re.sub(r"\(.*?\)|;.*", "", line).upper()
            if re.search(r"\bG(43.4|49)\b", words):
                is_tool_point = "G43.4" in words
                length = LENGTH_MM if is_tool_point else 0.0
            if re.search(r"[XYZABC]\s*[-+.\d]", words):
                pose = next(poses)
                out.append(self.kinematics.joints(pose, length) if is_tool_point else [pose[a] for a in "XYZ%sC" % self.tilting])
        if next(poses, None) is not None:
            raise RuntimeError("rs274 moves more often than the program has blocks with axis words")
        return out

    def posted(self, lines):
        """The program with axis positions that LinuxCNC's kinematics say: the tool's length is in both."""
        out, joints = ["G21 G90 G17 G94 G54", "G43 H1"], self.joints(lines)
        offset = [self.case["offsets"]["G54"][a] for a in "XYZ"] + [0.0, 0.0]
        offset[2] += LENGTH_MM
        for at in joints:
            out.append("G1 " + " ".join("%s%.6f" % (a, v - o) for a, v, o in zip("XYZ%sC" % self.tilting, at, offset)) + " F1000.")
        return out + ["M2"], joints

    def compare(self, title, lines):
        axes, joints = self.posted(lines)
        from_points = self.joints(self.corrected("points.ngc", lines))
        from_axes = self.joints(self.corrected("axes.ngc", axes))
        if not len(joints) == len(from_points) == len(from_axes):
            raise RuntimeError("%s: %d moves, corrected %d and %d" % (title, len(joints), len(from_points), len(from_axes)))
        apart = max(math.dist(a[:3], b[:3]) for a, b in zip(from_points, from_axes))
        moved = max(math.dist(a[:3], b[:3]) for a, b in zip(from_points, joints))
        turned = max(abs(a - b) for p, q in zip(from_points, from_axes) for a, b in zip(p[3:], q[3:]))
        print("%-28s %6d moves, corrected by up to %6.1f um; both ways to the same joints within %.2f um" % (
            title, len(joints), 1e3 * moved, 1e3 * apart))
        return apart < ROUNDING_MM and moved > 0.05 and turned < 1e-6


def main():
    axiscal = os.path.abspath(sys.argv[1])
    if not linuxcnc.is_there() or not os.path.isdir(MODULES):
        print("linuxcnc-uspace is not here")
        return 77
    good = True
    with tempfile.TemporaryDirectory() as folder:
        for tilting in "AB":
            shop = Shop(axiscal, folder, tilting)
            for seed in (1, 2):
                good &= shop.compare("%s-C table, drawn %d" % (tilting, seed), drawn(tilting, seed))
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
