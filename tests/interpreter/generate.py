"""Random programs of six dialects, with the shop floor that they run on. A program is a list of lines; everything that a
run needs beside them stands in a dictionary (see `draw`), so that a failure can be written down and tried again."""
import copy
import math
import os
import random

from kinematics import Machine

MACHINES = {
    "mill": {
        "id": "mill", "axes": {
            "X": {"kind": "linear", "direction": [-1, 0, 0]}, "Y": {"kind": "linear", "direction": [0, 1, 0]},
            "Z": {"kind": "linear", "direction": [0, 0, 1]}},
        "tool_branch": ["Y", "Z"], "work_branch": ["X"], "tool_direction": [0, 0, -1]},
    "head-table": {
        "id": "head-table", "axes": {
            "X": {"kind": "linear", "direction": [1, 0, 0]}, "Y": {"kind": "linear", "direction": [0, 1, 0]},
            "Z": {"kind": "linear", "direction": [0, 0, 1]},
            "B": {"kind": "rotary", "direction": [0, 1, 0], "point_mm": [0, 0, 0]},
            "C": {"kind": "rotary", "direction": [0, 0, 1], "point_mm": [-120, 0, 0]}},
        "tool_branch": ["Z", "Y", "X", "B"], "work_branch": ["C"], "tool_direction": [0, 0, -1]},
    "trunnion": {
        "id": "trunnion", "axes": {
            "X": {"kind": "linear", "direction": [1, 0, 0]}, "Y": {"kind": "linear", "direction": [0, -1, 0]},
            "Z": {"kind": "linear", "direction": [0, 0, 1]},
            "A": {"kind": "rotary", "direction": [1, 0, 0], "point_mm": [0, 0, -30]},
            "C": {"kind": "rotary", "direction": [0, 0, 1], "point_mm": [0, 0, 0]}},
        "tool_branch": ["X", "Z"], "work_branch": ["Y", "A", "C"], "tool_direction": [0, 0, -1]},
    "fork-head": {
        "id": "fork-head", "axes": {
            "X": {"kind": "linear", "direction": [1, 0, 0]}, "Y": {"kind": "linear", "direction": [0, 1, 0]},
            "Z": {"kind": "linear", "direction": [0, 0, 1]},
            "C": {"kind": "rotary", "direction": [0, 0, 1], "point_mm": [0, 0, 0]},
            "B": {"kind": "rotary", "direction": [0, 1, 0], "point_mm": [0, 0, 25]}},
        "tool_branch": ["X", "Y", "Z", "C", "B"], "work_branch": [], "tool_direction": [0, 0, -1]},
}
DIALECTS = ["fanuc", "mazak", "haas", "linuxcnc", "sinumerik", "heidenhain"]
RANGE = {"X": (-150, 150), "Y": (-120, 120), "Z": (-60, 90), "A": (-60, 60), "B": (-60, 60), "C": (0, 350)}


# What the product is known to do wrong, and why it is not drawn: `run --with NAME` draws it.
KNOWN = {}
# The same of programs in tests/data/nc.
KNOWN_SAMPLES = {}


def draw_errors(rng, description):
    """Errors of the size that machines have; a third of the machines have constant ones alone."""
    axes, errors, terms = description["axes"], {}, []
    linear = [a for a in axes if axes[a]["kind"] == "linear"]
    rotary = [a for a in axes if axes[a]["kind"] == "rotary"]

    def um(size):
        return round(rng.uniform(-size, size), 2)
    for axis in rotary:
        across = [c for c in "XYZ" if abs(axes[axis]["direction"]["XYZ".index(c)]) < 0.5]
        for c in across:
            if rng.random() < 0.7:
                errors["E%s0%s" % (c, axis)] = um(60)
            if rng.random() < 0.7:
                errors["E%s0%s" % ("ABC"["XYZ".index(c)], axis)] = um(80)
    for symbol in ("EC0Y", "EA0Z", "EB0Z"):
        if rng.random() < 0.6 and symbol[3] in axes:
            errors[symbol] = um(80)
    if rng.random() < 0.3:
        errors["EX0T"] = um(20)
    if rng.random() < 0.65:
        for axis in linear:
            if rng.random() < 0.6:
                terms.append({"symbol": "E%s%s" % (rng.choice("XYZ"), axis), "shape": "linear", "variable": axis,
                              "amplitude": um(80)})
            if rng.random() < 0.3:
                terms.append({"symbol": "E%s%s" % (rng.choice("ABC"), axis), "shape": "linear", "variable": axis,
                              "amplitude": um(120)})
            if rng.random() < 0.3:
                terms.append({"symbol": "E%s%s" % (rng.choice("XYZ"), axis), "shape": "harmonic", "variable": axis,
                              "period_mm": rng.choice([40, 100, 250]), "amplitude": abs(um(6)) + 0.1,
                              "phase_deg": um(180)})
            if rng.random() < 0.2:
                terms.append({"symbol": "E%s%s" % (rng.choice("XYZ"), axis), "shape": "quadratic", "variable": axis,
                              "amplitude": um(15)})
        for axis in rotary:
            if rng.random() < 0.6:
                terms.append({"symbol": "E%s%s" % (rng.choice("XYZ"), axis), "shape": "harmonic", "variable": axis,
                              "order": rng.choice([1, 2, 3]), "amplitude": abs(um(15)) + 0.1, "phase_deg": um(180)})
            if rng.random() < 0.4:
                terms.append({"symbol": "E%s%s" % (rng.choice("ABC"), axis), "shape": "harmonic", "variable": axis,
                              "order": rng.choice([1, 2]), "amplitude": abs(um(40)) + 0.1, "phase_deg": um(180)})
    seen, unique = set(), []
    for term in terms:
        if (term["symbol"], term["shape"]) not in seen:
            seen.add((term["symbol"], term["shape"]))
            unique.append(term)
    if not errors and not unique:
        errors["EC0Y"] = 50.0
    if unique:
        errors["terms"] = unique
    return errors


class Writer:
    """Writes blocks and knows where the nominal axes then stand (`m`: axis positions; None: not known)."""

    def __init__(self, rng, case):
        self.rng, self.case = rng, case
        self.dialect = case["dialect"]
        self.axes = list(MACHINES[case["machine"]]["axes"])
        self.axes.sort(key="XYZABC".index)
        self.linear = [a for a in self.axes if a in "XYZ"]
        self.rotary = [a for a in self.axes if a in "ABC"]
        self.lines = []
        self.features = case["features"]
        self.offsets = copy.deepcopy(case["offsets"])  # as the program leaves them
        self.inch = False
        self.incremental = False
        self.m = {a: None for a in self.axes}
        self.spindle = None  # number of the tool
        self.wcs = "" if self.dialect == "sinumerik" else "PRESET" if self.dialect == "heidenhain" else "G54"
        self.preset = {a: 0.0 for a in self.axes}
        self.trans = {a: 0.0 for a in self.axes}
        self.length = 0.0
        self.tcp = False
        self.motion = None
        self.feed = None
        self.plane = 17
        self.g93 = False
        self.centre_absolute = False
        self.n = 0
        self.numbering = rng.choice(["none", "all", "all", "some"])
        self.packed = rng.random() < 0.15
        self.gap = not self.packed and rng.random() < 0.05  # "X 10."
        self.g_two = rng.random() < 0.3                      # G01
        self.habit = rng.choice(["fixed", "fixed", "trim", "trim", "lead", "plus", "whole"])
        if case.get("increment"):
            self.habit = "increments"
        self.decimals = rng.choice([3, 3, 4]) if self.habit != "increments" else 3
        self.case_lower = rng.random() < 0.05
        self.sub_number = 100 * rng.randrange(10, 80)
        self.tail = []  # subprograms behind the end
        self.pole = None

    # -- numbers and lines
    def scale(self, axis):
        return 25.4 if self.inch and axis in self.linear else 1.0

    def places(self, axis="X"):
        if self.habit == "increments" and axis in self.rotary:
            return 3
        return self.decimals + 1 if self.inch else self.decimals

    def offset(self, axis):
        value = self.offsets.get(self.wcs, {}).get(axis, 0.0) + self.preset[axis] + self.trans[axis]
        return value + (self.length if axis == "Z" and not self.tcp else 0.0)

    def number(self, value, places=None, is_axis=False):
        is_axis |= places is None
        places = self.places() if places is None else places
        text = "%.*f" % (places, value)
        if float(text) == 0:
            text = text.lstrip("-")
        if self.habit == "increments" and is_axis and self.rng.random() < 0.7:
            return "%d" % round(value * 10 ** places)
        if self.habit in ("trim", "lead", "plus", "whole"):
            text = text.rstrip("0")
            if self.habit == "lead" and text.lstrip("-").startswith("0.") and len(text.lstrip("-")) > 2:
                text = text.replace("0.", ".", 1)
            if self.habit in ("whole",) and text.endswith(".") and len(text) < 5:
                text = text[:-1]
        if self.habit == "plus" and not text.startswith("-"):
            text = "+" + text
        return text

    def block(self, words, comment=None):
        words = [w for w in words if w]
        if self.numbering == "all" or (self.numbering == "some" and self.rng.random() < 0.4):
            self.n += 10
            words = ["N%d" % self.n] + words
        text = ("" if self.packed else " ").join(words)
        if comment:
            text += (" " if text else "") + self.comment(comment)
        self.lines.append(text.lower() if self.case_lower and "(" not in text else text)

    def comment(self, text):
        return "; " + text if self.dialect == "sinumerik" else "(" + text + ")"

    def plain(self, text):
        """A block of codes: numbered like the others."""
        self.block(text.split(" "))

    # -- words
    def go(self, targets, absolute_only=False):
        """Axis words to the wanted axis positions (rounded to the words); moves `m`."""
        words = []
        for axis, want in targets.items():
            scale = self.scale(axis)
            if self.incremental:
                value = round((want - self.m[axis]) / scale, self.places(axis))
                self.m[axis] += value * scale
                words.append(self.axis_word(axis, value))
            elif self.dialect == "sinumerik" and not absolute_only and self.m[axis] is not None and self.rng.random() < 0.06:
                value = round((want - self.m[axis]) / scale, self.places())
                self.m[axis] += value * scale
                words.append("%s=IC(%s)" % (axis, self.number(value)))
            else:
                value = round((want - self.offset(axis)) / scale, self.places(axis))
                self.m[axis] = value * scale + self.offset(axis)
                words.append(self.axis_word(axis, value))
        return words

    def axis_word(self, axis, value):
        if self.dialect == "sinumerik":
            r = self.rng.random()
            if r < 0.06:
                return "%s=%s" % (axis, self.number(value))
            if r < 0.1 and not self.incremental:
                return "%s=AC(%s)" % (axis, self.number(value))
        return axis + (" " if self.gap else "") + self.number(value, self.places(axis), True)

    def g(self, code):
        return ("G%02d" if self.g_two else "G%d") % code

    def motion_word(self, code, always=False):
        if self.motion == code and not always and self.rng.random() < 0.75:
            return ""
        self.motion = code
        return self.g(code)

    def feed_word(self, minutes=None):
        if self.g93:
            return "F%s" % self.number(1.0 / max(minutes, 1e-3), 3)
        if self.feed is None or self.rng.random() < 0.2:
            self.feed = self.rng.choice([200, 400, 800, 1500.5, 3000])
            if self.inch:
                self.feed = self.rng.choice([10, 20.5, 60])
            return "F%s" % self.number(self.feed, 1) if self.feed % 1 else "F%d" % self.feed
        return ""

    # -- parts that every control has; Klartext overrides them
    def rapid(self, targets):
        words = self.go(targets)
        self.block([self.motion_word(0)] + words)

    def feed_move(self, targets, minutes=None, code=""):
        before = dict(self.m)
        words = self.go(targets)
        if minutes is None and self.g93:
            minutes = max(0.01, sum(abs(self.m[a] - before[a]) for a in targets if before[a] is not None) / 500)
        self.block([self.motion_word(1)] + words + [self.feed_word(minutes), code])

    def arc(self, clockwise, centre, end, more=None, form="centre"):
        """`centre`, `end`: in the plane, axis positions; `more`: further axes."""
        first, second, i, j = {17: ("X", "Y", "I", "J"), 18: ("Z", "X", "K", "I"), 19: ("Y", "Z", "J", "K")}[self.plane]
        start = (self.m[first], self.m[second])
        radius = math.dist(start, centre)
        a0 = math.atan2(start[1] - centre[1], start[0] - centre[0])
        a1 = math.atan2(end[1] - centre[1], end[0] - centre[0])
        sweep = (a1 - a0) % (2 * math.pi)
        if clockwise:
            sweep = 2 * math.pi - sweep
        targets = {first: end[0], second: end[1]}
        is_full = math.dist(start, end) < 1e-9
        if is_full and self.rng.random() < 0.5:
            targets = {}
        targets.update(more or {})
        words = self.go(targets, absolute_only=True)
        scale = self.length_scale()
        if form == "radius" and not is_full:
            value = radius / scale * (-1 if sweep > math.pi else 1)
            words.append(("CR=" if self.dialect == "sinumerik" else "R") + self.number(value))
        else:
            for axis, letter, c, s in ((first, i, centre[0], start[0]), (second, j, centre[1], start[1])):
                if self.centre_absolute:
                    words.append(letter + self.number((c - self.offset(axis)) / scale))
                elif self.dialect == "sinumerik" and self.rng.random() < 0.1:
                    words.append("%s=AC(%s)" % (letter, self.number((c - self.offset(axis)) / scale)))
                elif abs(c - s) > 1e-9 or self.rng.random() < 0.3:
                    words.append(letter + self.number((c - s) / scale))
        minutes = max(0.02, radius * abs(sweep) / 500) if self.g93 else None
        self.block([self.motion_word(2 if clockwise else 3)] + words + [self.feed_word(minutes)])

    def length_scale(self):
        return 25.4 if self.inch else 1.0


def near(rng, value, low, high, most):
    return min(high, max(low, value + rng.uniform(-most, most)))


class Program(Writer):
    def targets(self, axes):
        out = {}
        for a in axes:
            low, high = RANGE[a]
            for _ in range(20):
                value = rng_value(self.rng, low, high)
                if a not in self.rotary or self.m[a] is None or abs(abs(value - self.m[a]) - 180) > 1:
                    break
            out[a] = value
        return out

    def some_axes(self):
        rng = self.rng
        axes = rng.sample(self.linear, rng.choice([1, 1, 2, 2, 3]))
        if self.rotary and rng.random() < 0.3:
            axes += rng.sample(self.rotary, rng.choice([1, 1, 2]))
            if self.dialect == "linuxcnc" and not self.g93 and "rotary-feed" not in self.features and \
                    not any(a in self.linear for a in axes):
                axes.append("X")
        rng.shuffle(axes)
        return axes

    # -- features that a plain program may have
    def f_lines(self):
        for _ in range(self.rng.randrange(1, 5)):
            if self.rng.random() < 0.25 and not self.g93:
                self.rapid(self.targets(self.some_axes()))
            else:
                self.feed_move(self.targets(self.some_axes()))

    def f_short_lines(self):
        for _ in range(self.rng.randrange(2, 6)):
            axes = self.rng.sample(self.linear, self.rng.choice([1, 2, 3]))
            self.feed_move({a: self.m[a] + round(self.rng.uniform(-4, 4), 3) for a in axes})

    def f_rotary_feed(self):
        if self.rotary:
            axes = self.rng.sample(self.rotary, self.rng.choice([1, len(self.rotary)]))
            self.feed_move(self.targets(axes))

    def f_arc(self):
        rng = self.rng
        if self.plane_codes() and rng.random() < 0.35:
            self.plane = rng.choice([17, 18, 19])
            self.plain("G%d" % self.plane)
        first, second, normal = {17: "XYZ", 18: "ZXY", 19: "YZX"}[self.plane]
        for _ in range(rng.randrange(1, 3)):
            radius = rng.choice([0.02, 0.8, 3.0, 10.0, 25.0, 50.0, 80.0])
            a0 = rng.uniform(0, 2 * math.pi)
            if rng.random() < 0.3:
                a0 = rng.randrange(4) * math.pi / 2
            places = (4 if not self.inch else 5) if self.habit != "increments" else self.places() + 1
            scale = self.length_scale()
            i = round(-radius * math.cos(a0) / scale, places - 1) * scale
            j = round(-radius * math.sin(a0) / scale, places - 1) * scale
            start = (self.m[first], self.m[second])
            centre = (start[0] + i, start[1] + j)
            radius = math.hypot(i, j)
            a0 = math.atan2(-j, -i)
            clockwise = rng.random() < 0.5
            form = rng.choice(["centre", "centre", "radius"])
            sweep = rng.uniform(0.3, 2.8) if rng.random() < 0.7 else rng.uniform(3.5, 5.9)
            saved = self.decimals
            if self.habit != "increments":
                self.decimals = 4
            more = None
            if form == "centre" and rng.random() < 0.25:
                end = start  # a full circle
            else:
                a1 = a0 + (-sweep if clockwise else sweep)
                end = (centre[0] + radius * math.cos(a1), centre[1] + radius * math.sin(a1))
            if rng.random() < 0.2 and self.dialect != "heidenhain":
                more = {normal: near(rng, self.m[normal], -60, 90, 8)}
                if self.rotary and rng.random() < 0.1:
                    more.update(self.targets([rng.choice(self.rotary)]))
            self.arc(clockwise, centre, end, more, form)
            self.decimals = saved

    def f_circle_modal(self):
        """Two arcs, the second without its G code."""
        rng = self.rng
        first, second, _ = {17: "XYZ", 18: "ZXY", 19: "YZX"}[self.plane]
        r = rng.choice([5.0, 12.5, 30.0])
        clockwise = rng.random() < 0.5
        sign = rng.choice([-1, 1])
        for _ in range(2):
            start = (self.m[first], self.m[second])
            self.arc(clockwise, (start[0] + sign * r, start[1]), (start[0] + 2 * sign * r, start[1]))
            sign = -sign

    def f_incremental(self):
        self.distances(True)
        for _ in range(self.rng.randrange(1, 4)):
            axes = self.rng.sample(self.linear, self.rng.choice([1, 2, 3]))
            self.feed_move({a: self.m[a] + rng_value(self.rng, -15, 15) for a in axes})
        if self.rng.random() < 0.4:
            self.f_arc()
        self.distances(False)

    def distances(self, incremental):
        self.plain("G91" if incremental else "G90")
        self.incremental = incremental

    def f_codes(self):
        rng = self.rng
        kind = rng.randrange(9)
        if kind == 0:
            self.plain(rng.choice(["M3 S1000", "S2500 M3", "M4 S500", "M03 S800"]))
        elif kind == 1:
            self.plain(rng.choice(["M8", "M9", "M5", "M08", "M1", "M0"]))
        elif kind == 2:
            self.plain(self.dwell())
        elif kind == 3:
            self.lines.append(self.comment("ROUGHING %d X10 Y20" % rng.randrange(100)))
        elif kind == 4:
            self.lines.append("")
        elif kind == 5:
            more = {"fanuc": ["G5 P10000", "G05 P0", "G8 P1", "G5.1 Q1", "G5.1 Q0"], "mazak": ["G61.1", "G5 P2", "G5 P0"],
                    "haas": ["G187 P1", "G103 P1", "G103 P0"], "linuxcnc": ["G64 P0.01", "G61.1", "M62 P1", "M63 P1", "(MSG, X10)", "#<depth>=5."],
                    "sinumerik": ["G642", "G601", "MSG(\"X10 Y20\")", "STOPRE", "FFWON", "SOFT", "CYCLE832(0.01,1,1)", "DYNFINISH", "FNORM", "G450", "R5=3"],
                    }[self.dialect]
            text = rng.choice(["G61", "G64"] + more + more)
            self.lines.append(text) if text[0] == "(" or "=" in text and text[0] == "M" else self.plain(text) if "(" not in text else self.lines.append(text)
        elif kind == 6:
            self.feed_move(self.targets(self.some_axes()), code=rng.choice(["M8", "M3", "M13"] if self.dialect != "linuxcnc" else ["M8", "M3 S500"]))
        elif kind == 7:
            self.feed_move({a: self.m[a] + 3.0 for a in self.rng.sample(self.linear, 1)}, code=rng.choice(["M9", "M5"]))
        else:
            self.plain("M7" if self.dialect != "haas" else "M8")

    def dwell(self):
        rng = self.rng
        if self.dialect == "linuxcnc":
            return "G4 P%s" % rng.choice(["0.5", "1.25"])
        if self.dialect == "sinumerik":
            return "G4 F%s" % rng.choice(["0.5", "2"])
        return "G4 %s" % rng.choice(["P500", "X1.5", "P1.0"])

    def length_of(self, number):
        """Of D1 of Sinumerik that of the tool in the spindle, where each tool has its own."""
        return self.case.get("edges", {}).get("T%sD%s" % (self.spindle, number), self.case["lengths"][number])

    def leave_out_kept(self, axes):
        """Behind a tool change that leaves rotary axes where they stand many programs do not name them."""
        for axis in self.case.get("keeps", ()):
            if self.rng.random() < 0.7 and self.m.get(axis) is not None:
                del axes[axis]

    def restate(self, is_behind_tool_change=False):
        """Every axis again, in work coordinates."""
        axes = self.targets(self.axes)
        if is_behind_tool_change:
            self.leave_out_kept(axes)
        if self.rng.random() < 0.5:
            z = axes.pop("Z")
            self.rapid(axes)
            self.rapid({"Z": z})
        else:
            self.rapid(axes)

    def f_offset(self):
        names = [n for n in self.case["offsets"] if n and n not in self.case["unstated"]]
        name = self.rng.choice(names)
        self.wcs = name
        self.plain(name)
        if self.dialect == "sinumerik" or self.rng.random() < 0.6:
            self.restate()
        else:
            self.feed_move(self.targets(self.axes))

    def f_data_input(self):
        """G10 L2 or L20: the program states a work offset itself."""
        rng, d = self.rng, self.dialect
        if d == "sinumerik":
            return
        kinds = [("L2 P%d" % n, "G%d" % (53 + n)) for n in range(1, 7)]
        if d == "linuxcnc":
            kinds += [("L2 P%d" % (6 + n), "G59.%d" % n) for n in (1, 2, 3)]
        elif d == "haas":
            kinds += [("L20 P1", "G110"), ("L20 P3", "G154 P3"), ("L20 P40", "G154 P40")]
        else:
            kinds += [("L20 P%d" % n, "G54.1 P%d" % n) for n in (5, 12)]
        text, name = rng.choice(kinds)
        is_stated = name in self.case["offsets"] and name not in self.case["unstated"]
        axes = self.axes if not is_stated or rng.random() < 0.4 else rng.sample(self.axes, rng.randrange(1, len(self.axes)))
        values = {}
        for axis in axes:
            value = rng_value(rng, -60, 60) if axis in self.linear else rng.choice([0.0, 0.0, 12.5])
            if axis == "C" and self.case.get("roll_over") == "sign":
                value = 0.0
            values[axis] = round(value / self.scale(axis), self.places(axis))
        self.block(["G90"] * (rng.random() < 0.2) + ["G10"] + text.split() +
                   [a + self.number(v, self.places(a), True) for a, v in values.items()])
        table = self.offsets.setdefault(name, {})
        table.update({a: v * self.scale(a) for a, v in values.items()})
        if rng.random() < 0.7:
            self.wcs = name
            self.plain(name)
        if rng.random() < 0.5:
            self.restate()
        else:
            self.feed_move(self.targets(self.axes))

    def f_shift(self):
        """TRANS, ATRANS: a frame that only shifts."""
        rng = self.rng
        if self.dialect != "sinumerik" or self.inch:
            return
        for word in rng.choice([["TRANS"], ["TRANS", "ATRANS"], ["TRANS", "TRANS"]]):
            values = {a: round(rng.uniform(-20, 20), 2) for a in rng.sample(self.linear, rng.randrange(1, 4))}
            self.plain(word + " " + " ".join(a + rng.choice(["", "", "="]) + self.number(v, 2) for a, v in values.items()))
            if word == "TRANS":
                self.trans = {a: 0.0 for a in self.axes}
            for a, v in values.items():
                self.trans[a] += float(self.number(v, 2))
            self.restate()
            self.f_lines()
        self.plain(rng.choice(["TRANS", "TRANS", "ROT"]))
        self.trans = {a: 0.0 for a in self.axes}
        self.restate()

    def f_length(self):
        if not self.case["lengths"]:
            return
        number = self.rng.choice(sorted(self.case["lengths"]))
        tool = int(number)
        self.plane_xy()
        if self.dialect == "sinumerik":
            self.plain("T%d D%d" % (tool, tool) if False else "D%d" % tool)
            self.length = self.length_of(number)
            self.restate()
            return
        if self.rng.random() < 0.7:
            self.length = self.length_of(number)
            z = self.targets(["Z"])
            self.block([self.g(43), "H%d" % tool, self.motion_word(0, True)] + self.go(z))
        else:
            self.length = 0.0
            self.plain("G49")
            self.rapid(self.targets(["Z"]))

    def plane_xy(self):
        """A tool length acts along Z in G17 alone."""
        if self.plane != 17:
            self.plane = 17
            self.plain("G17")

    def f_tool_change(self):
        tool = self.rng.choice(sorted(self.case["lengths"]))
        self.plane_xy()
        if self.dialect == "sinumerik":
            self.plain("T%d M6" % int(tool))
            self.spindle = int(tool)
            edge = "1" if self.case.get("edges") else tool
            self.plain("D%d" % int(edge))
            self.length = self.length_of(edge)
            self.restate(True)
            return
        if self.rng.random() < 0.5 and self.dialect != "linuxcnc":
            self.plain("T%d" % int(tool))
            self.plain("M6")
        else:
            self.plain("T%d M6" % int(tool))
        self.motion = None
        if self.length and self.rng.random() < 0.5:
            self.length = 0.0
            self.plain("G49")
        axes = self.targets(self.axes)
        self.leave_out_kept(axes)
        z = axes.pop("Z")
        self.rapid(axes)
        self.length = self.case["lengths"][tool]
        self.block([self.g(0), self.g(43), "H%d" % int(tool)] + self.go({"Z": z}))
        self.motion = 0

    def f_g28(self):
        if self.dialect == "sinumerik":
            self.plain(self.rng.choice(["SUPA G0 Z80", "G53 G0 Z60", "G0 G153 Z70", "SUPA G0 X0 Y0 D0", "SUPA G0 Z=_Z_HOME"]))
            if "D0" in self.lines[-1]:
                self.length = 0.0
            self.motion = 0
            self.m["Z"] = None
        elif self.rng.random() < 0.6:
            z = self.rng.choice(["Z0.", "Z0.", "X0. Y0. Z0.", "Y0. Z0."])
            if self.rng.random() < 0.7:
                self.plain("G91 G28 " + z)
                self.plain("G90")
            else:
                self.block(["G28"] + self.go(self.targets(["Z"])))
        else:
            self.plain(self.rng.choice(["G53 G0 Z50.", "G0 G53 Z20."]) if not self.inch else "G53 G0 Z2.")
            self.motion = 0
        self.motion = None
        self.rapid(self.targets(self.rng.sample(self.linear[:2], self.rng.choice([1, 2]))))
        self.restate()

    def f_preset(self):
        rng = self.rng
        if self.dialect == "sinumerik":
            return
        axes = rng.sample(self.linear, rng.choice([1, 2]))
        words = []
        for a in axes:
            value = round(rng_value(rng, -30, 30) / self.scale(a), self.places())
            words.append(a + self.number(value))
            self.preset[a] = 0.0
            self.preset[a] = self.m[a] - value * self.scale(a) - self.offset(a)
        self.block(["G92"] + words)
        self.f_lines()
        if rng.random() < 0.7:
            for a in self.axes:
                self.preset[a] = 0.0
            self.plain("G92.1" if self.dialect == "linuxcnc" else "G92.1 X0. Y0. Z0.")
            if self.dialect != "linuxcnc":
                pass
            self.restate()

    def f_local(self):
        if self.dialect in ("sinumerik", "linuxcnc") or any(self.preset.values()):
            return
        axis = self.rng.choice(self.linear)
        value = round(rng_value(self.rng, -20, 20) / self.scale(axis), self.places())
        self.block(["G52", axis + self.number(value)])
        self.preset[axis] = value * self.scale(axis)
        self.f_lines()
        self.plain("G52 X0. Y0. Z0." if self.rng.random() < 0.5 else "G52 %s0." % axis)
        self.preset[axis] = 0.0
        self.restate()

    def f_skip(self):
        line = len(self.lines)
        axes = self.rng.sample(self.linear, 2)
        saved, motion, feed = dict(self.m), self.motion, self.feed
        if self.motion not in (0, 1):
            self.feed_move(self.targets(axes))
            motion, feed, saved, line = self.motion, self.feed, dict(self.m), len(self.lines)
        self.block([self.g(self.motion)] + self.go(self.targets(axes)))
        for i in range(line, len(self.lines)):
            self.lines[i] = "/" + self.lines[i]
        self.m, self.motion, self.feed = saved, motion, feed
        self.rapid(self.targets(self.axes))

    def f_inverse_time(self):
        if self.dialect == "sinumerik" and self.rng.random() < 0.5:
            return
        self.plain("G93")
        self.g93 = True
        self.motion = None
        for _ in range(self.rng.randrange(1, 4)):
            self.feed_move(self.targets(self.some_axes()))
        if self.rng.random() < 0.3:
            self.f_arc()
        self.plain("G94")
        self.g93, self.feed, self.motion = False, None, None

    def f_unit(self):
        if self.dialect == "sinumerik":
            on, off = ("G70", "G71")
        else:
            on, off = ("G20", "G21")
        self.plain(on)
        self.inch, self.feed = True, None
        self.f_lines()
        if self.rng.random() < 0.5:
            self.f_arc()
        self.plain(off)
        self.inch, self.feed = False, None
        self.restate()

    def f_absolute_centres(self):
        if self.dialect not in ("linuxcnc", "fanuc", "mazak", "haas"):
            return
        self.plain("G90.1")
        self.centre_absolute = True
        saved = self.decimals
        self.f_arc()
        self.decimals = saved
        self.plain("G91.1")
        self.centre_absolute = False

    def f_corner(self):
        rng = self.rng
        if self.dialect == "linuxcnc":
            return
        word = {"sinumerik": rng.choice(["RND=2", "CHF=1", "CHR=1.5"])}.get(self.dialect, rng.choice([",R2.", ",C1."]))
        x, y = self.m["X"], self.m["Y"]
        if self.plane != 17:
            self.plane = 17
            self.plain("G17")
        self.feed_move({"X": near(rng, x, -150, 150, 1) + 20, "Y": y}, code=word)
        self.feed_move({"Y": y + 25})
        self.feed_move({"X": x})

    def corner_words(self):
        """Words of Sinumerik for the corner at the end of a move."""
        rng = self.rng
        size = rng.choice([0.3, 1.0, 2.0, 2.5, 5.0, round(rng.uniform(0.1, 8.0), 3)]) / self.length_scale()
        words = "%s=%s" % (rng.choice(["RND", "RND", "CHF", "CHR"]), self.number(size).lstrip("+"))
        return words + rng.choice(["", "", " FRC=%d" % rng.choice([80, 150])])

    def add_words(self, words):
        """To the last block, which is a move."""
        if ";" not in self.lines[-1]:
            self.lines[-1] += " " + words

    def f_rounded(self):
        """A contour with corners that the control makes."""
        rng = self.rng
        if self.dialect != "sinumerik" or self.g93 or self.case.get("increment"):
            return
        self.plane_xy()
        self.restate()
        incremental = rng.random() < 0.2
        if incremental:
            self.plain("G91")
            self.incremental = True
        if rng.random() < 0.3:
            self.plain("RNDM=%s" % self.number(rng.choice([0.5, 1.5, 4.0]) / self.length_scale()).lstrip("+") +
                       rng.choice(["", "", " FRCM=90"]))
        heading = rng.uniform(0, 2 * math.pi) if rng.random() < 0.6 else rng.choice([0, 1, 2, 3]) * math.pi / 2
        for _ in range(rng.randrange(2, 7)):
            length = rng.choice([rng.uniform(3, 30), rng.uniform(20, 90)])
            kind = rng.random()
            if kind < 0.7:
                self.feed_move({"X": self.m["X"] + length * math.cos(heading), "Y": self.m["Y"] + length * math.sin(heading)})
            elif kind < 0.93:
                turn, r = rng.choice([1, -1]), rng.choice([6.0, 15.0, 60.0])
                a, sweep = heading - turn * math.pi / 2, turn * rng.uniform(0.4, 2.8)
                centre = (self.m["X"] - r * math.cos(a), self.m["Y"] - r * math.sin(a))
                end = (centre[0] + r * math.cos(a + sweep), centre[1] + r * math.sin(a + sweep))
                self.arc(turn < 0, centre, end, form=rng.choice(["centre", "radius"]))
                heading += sweep
            else:
                self.feed_move({"Z": self.m["Z"] + rng.choice([-2.0, 3.0])})
            if rng.random() < 0.5:
                self.add_words(self.corner_words())
            if rng.random() < 0.1:
                self.lines.append(rng.choice(["", "; CORNER"]))
            heading += rng.choice([math.pi / 2, -math.pi / 2, rng.uniform(-2.7, 2.7), rng.uniform(-0.02, 0.02), 0.0])
        if rng.random() < 0.5:
            self.plain("RNDM=0")
        else:
            self.rapid({"Z": self.m["Z"] + 5.0})
            self.plain("RNDM=0 FRCM=0")
        if incremental:
            self.plain("G90")
            self.incremental = False
        self.motion = self.feed = None
        self.restate()

    def f_wrap(self):
        """Sinumerik's stated ways round of a modulo axis."""
        if self.dialect != "sinumerik" or "C" not in self.rotary:
            return
        how = self.rng.choice(["DC", "ACP", "ACN"])
        value = round(self.rng.uniform(0, 359), 3)
        self.block([self.motion_word(1)] + self.go(self.targets(["X"])) + ["C=%s(%s)" % (how, self.number(value)), self.feed_word()])
        self.m["C"] = value
        self.feed_move(self.targets(self.axes))

    def f_long_line(self):
        """Close to what the control reads in one block."""
        room = {"linuxcnc": 252}.get(self.dialect, 240)
        words = [self.motion_word(1, True)] + self.go(self.targets([self.rng.choice("XY")])) + [self.feed_word()]
        text = " ".join(w for w in words if w)
        fill = room - len(text) - 4 - self.rng.randrange(0, 25)
        self.lines.append(text + " " + self.comment("L" * fill))

    def f_builder(self):
        """An M code of the machine's builder that is stated to move nothing, alone or in the block of a move."""
        if not self.case.get("harmless"):
            return
        if self.rng.random() < 0.5:
            self.plain("M123" if self.dialect != "heidenhain" else "L M123")
        self.feed_move(self.targets(self.rng.sample(self.linear, 2)), code=self.rng.choice(["M123", "M71"]))

    def f_over(self):
        """A rotary axis over the end of its circle."""
        if "C" not in self.rotary:
            return
        rng = self.rng
        a, b = rng.choice([(350, 10), (330, 40), (10, 350), (20, 200), (200, 20), (100, 300)])
        self.feed_move(dict(self.targets(["X"]), C=a))
        self.feed_move(dict(self.targets(["Y"]), C=b))

    def f_tcp(self):
        """Tool centre point control: the words stand in the workpiece's frame (`m` too, meanwhile)."""
        rng = self.rng
        if not self.rotary or any(self.offset(a) for a in self.rotary) or any(self.preset.values()) or self.g93 or \
                self.case.get("roll_over") in ("difference", "sign"):
            return
        self.plane_xy()
        end = self.tcp_on()
        if end is None:
            return
        self.tcp = True
        self.feed = None
        for _ in range(rng.randrange(1, 6)):
            axes = rng.sample(self.linear, rng.choice([1, 2, 3]))
            if rng.random() < 0.7:
                axes = axes + rng.sample(self.rotary, rng.choice([1, len(self.rotary)]))
            if rng.random() < 0.2:
                self.rapid(self.targets(axes))
            elif rng.random() < 0.4 and None not in self.m.values():  # as a surface is milled: near the last point
                self.feed_move({a: self.m[a] + rng.uniform(-3, 3) for a in axes})
            else:
                self.feed_move(self.targets(axes))
        if rng.random() < 0.3 and self.dialect != "heidenhain" and None not in self.m.values():
            self.distances(True)
            self.feed_move({a: self.m[a] + rng.uniform(-9, 9) for a in [rng.choice(self.linear), rng.choice(self.rotary)]})
            self.distances(False)
        self.tcp_off(end)

    def f_vector(self):
        """Tool centre point control with the tool's direction as a vector: G43.5, A3= B3= C3=, LN."""
        rng = self.rng
        if len(self.rotary) != 2 or any(self.offset(a) for a in self.rotary) or any(self.preset.values()) or self.g93 or \
                self.case.get("roll_over") in ("difference", "sign"):
            return
        tilting = [a for a in self.rotary if a != "C"][0]
        sign = rng.choice([-1, 1])
        at = {tilting: round(sign * rng.uniform(8, 50), 3), "C": round(rng.uniform(10, 340), 3)}
        self.plane_xy()
        end = self.vector_on(at)
        if end is None:
            return
        self.tcp, self.feed = True, None
        for _ in range(rng.randrange(2, 7)):
            axes = rng.sample(self.linear, rng.choice([1, 2, 3, 3]))
            kind = rng.random()
            if kind < 0.75:
                most = rng.choice([2.0, 10.0, 25.0])
                at[tilting] = sign * min(58.0, max(3.0, sign * at[tilting] + rng.uniform(-most, most)))
                at["C"] += rng.uniform(-most, most)
            elif kind < 0.8:  # no rule says where the control turns
                at.update({tilting: rng.choice([0.0, -at[tilting]])})
            if rng.random() < 0.6 and None not in self.m.values():
                targets = {a: self.m[a] + rng.uniform(-6, 6) for a in axes}
            else:
                targets = self.targets(axes)
            self.vector_move(targets, self.vector_words(at) if rng.random() < 0.85 else [], rng.random() < 0.25)
        self.m.update(at)
        self.tcp_off(end)
        self.restate()

    def vector_words(self, at):
        """The direction at these places of the rotary axes, from the tool's tip to the spindle."""
        scale = self.rng.choice([1.0, 1.0, 1.0, 2.0, 0.5]) if self.dialect != "heidenhain" else 1.0
        names = {"sinumerik": ("A3=", "B3=", "C3="), "heidenhain": ("TX", "TY", "TZ")}.get(self.dialect, ("I", "J", "K"))
        places = self.rng.choice([5, 6, 7])
        sign = "+" if self.dialect == "heidenhain" else ""
        return [name + ("%" + sign + ".*f") % (places, scale * v + 0.0) for name, v in zip(names, self.normal(at))]

    def vector_move(self, targets, vector, is_rapid):
        words = self.go(targets) + vector
        if is_rapid:
            self.block([self.motion_word(0)] + words)
        else:
            self.block([self.motion_word(1)] + words + [self.feed_word()])

    def vector_on(self, at):
        rng, d = self.rng, self.dialect
        if d not in ("fanuc", "mazak", "sinumerik"):
            return None
        number = rng.choice(sorted(self.case["lengths"]))
        if d == "sinumerik":
            self.plain("D%d" % int(number))
            self.length = self.length_of(number)
            self.plain("TRAORI")
            self.plain((self.wcs or "G500") + " ORIAXES")
            self.tcp = True
            self.rapid(dict(self.targets(self.linear), **at))
            return "TRAFOOF"
        self.rapid(dict(self.targets(self.linear), **at))
        self.length, self.tcp = self.case["lengths"][number], True
        kind = rng.random()
        if kind < 0.6:
            self.block([self.g(0), "G43.5", "H%d" % int(number)] + self.go(self.targets(self.linear)) +
                       (self.vector_words(at) if kind < 0.3 else []))
            self.motion = 0
        else:
            self.plain("G43.5 H%d" % int(number))
            self.rapid(self.targets(self.linear))
        return "G49"

    # Rotations, mirrors, scales: `m` holds places of their words meanwhile.
    def f_frame(self):
        rng = self.rng
        if any(self.preset.values()) or self.case.get("increment") or self.g93:
            return
        self.plane_xy()
        ends = self.frame_on()
        if not ends:
            return
        self.motion = None
        self.in_frame()
        for end in ends:
            self.plain(end)
        self.trans = {a: 0.0 for a in self.axes}
        self.m.update(X=None, Y=None, Z=None)
        if rng.random() < 0.3:
            self.rapid(self.targets(["X", "Y"]))
        self.restate()

    def in_frame(self):
        """Moves of linear axes, circles, holes."""
        rng = self.rng
        self.m.update(X=None, Y=None, Z=None)
        if rng.random() < 0.3:
            self.rapid(self.targets(["X", "Y"]))
        self.rapid(self.targets(self.linear))
        for _ in range(rng.randrange(1, 4)):
            kind = rng.random()
            if kind < 0.5:
                self.feed_move(self.targets(rng.sample(self.linear, rng.choice([1, 2, 3]))))
            elif kind < 0.65:
                self.f_short_lines()
            elif kind < 0.85:
                r = rng.choice([5.0, 12.5, 40.0])
                start = (self.m["X"], self.m["Y"])
                self.arc(rng.random() < 0.5, (start[0] + r, start[1]), rng.choice([start, (start[0] + r, start[1] + r)]))
            else:
                self.rapid(self.targets(self.linear))
        if rng.random() < 0.4 and self.dialect != "heidenhain" and not self.case.get("orientation"):
            self.distances(True)
            self.feed_move({a: self.m[a] + rng.uniform(-9, 9) for a in rng.sample(self.linear, 2)})
            self.distances(False)
        if rng.random() < 0.4:
            self.holes()
        if rng.random() < 0.3 and self.dialect not in ("sinumerik", "heidenhain") and not self.case.get("orientation") and \
                not self.case.get("increment"):
            self.contour(rng.choice(sorted(self.case["radii"])))
            self.motion = None
            self.rapid(self.targets(self.linear))

    def holes(self):
        """A drilling cycle of linear axes alone."""
        rng = self.rng
        if self.case.get("orientation"):
            return
        if self.dialect in ("sinumerik", "heidenhain"):
            linear, self.axes = self.axes, self.linear  # what follows the holes moves no rotary axis
            rotary, self.rotary = self.rotary, []
            self.called_cycle()
            self.axes, self.rotary = linear, rotary
            return
        self.rapid(self.targets(self.linear))
        z = (self.m["Z"] - self.offset("Z")) / self.scale("Z")
        for k in range(rng.randrange(1, 4)):
            words = self.go(self.targets(["X", "Y"]))
            if k == 0:
                words = ["G%d" % rng.choice([98, 99]), "G81"] + words + ["Z" + self.number(z - 12.0 / self.scale("Z")), "R" + self.number(z), "F120"]
            self.block(words)
        self.plain("G80")
        self.m["Z"], self.motion, self.feed = None, None, None
        self.rapid(self.targets(self.linear))

    def frame_on(self):
        rng, d = self.rng, self.dialect
        x, y, z = (self.number(round(rng.uniform(-20, 20), 2), 2) for _ in range(3))
        angle = self.number(rng.choice([30.0, 45.0, -12.5, 90.0, 137.25]), 2)
        if "." not in angle:
            angle += "."
        if d == "linuxcnc":
            return None
        if d == "sinumerik":
            factor = self.number(0.985, 3)
            if rng.random() < 0.4 and not self.inch:
                self.block(["TRANS X%s Y%s" % (x, y)])
                self.trans.update(X=float(x), Y=float(y))
                for word in rng.sample(["AROT RPL=" + angle, "AMIRROR Y0", "ASCALE X%s Y%s" % (factor, factor), "AROT Z" + angle,
                                        "ATRANS X5 Z-2.5"], rng.choice([1, 2])):
                    if word.startswith("ATRANS") and not any(l.split(" ", 1)[-1].startswith("A") for l in self.lines[-1:]):
                        self.trans["X"] += 5.0
                        self.trans["Z"] -= 2.5
                    self.block([word])
                self.trans = {a: 0.0 for a in self.axes}  # words are as they are: where they lead matters little
                self.trans.update(X=float(x), Y=float(y))
            else:
                self.block([rng.choice(["ROT Z" + angle, "ROT RPL=" + angle, "MIRROR X0", "MIRROR X0 Y0",
                                       "SCALE X%s Y%s Z%s" % (factor, factor, factor)])])
            return [rng.choice(["TRANS", "ROT"])]
        kind = rng.random()
        if kind < 0.6:
            self.plain("G68 X%s Y%s R%s" % (x, y, angle))
            return ["G69"]
        if kind < 0.8:
            axes = rng.choice([["X"], ["Y"], ["X", "Y"]])
            self.plain("G51.1 " + " ".join(a + v for a, v in zip(axes, (x, y))))
            return [rng.choice(["G50.1", "G50.1 " + " ".join(a + "0." for a in axes)])]
        self.plain("G51 X%s Y%s Z%s P0.98" % (x, y, z))
        return ["G50"]

    def f_contour(self):
        """Cutter compensation: a move to the contour, the contour, a move away."""
        rng, d = self.rng, self.dialect
        if self.case.get("orientation") or self.case.get("increment") or self.g93 or self.incremental:
            return
        self.plane_xy()
        number = rng.choice(sorted(self.case["radii"]))
        if d == "heidenhain":
            self.plain("TOOL CALL %d Z S2000" % int(number))
            self.length = self.length_of(number)
            self.restate()
        elif d == "sinumerik":
            self.plain("D%d" % int(number))
            self.length = self.length_of(number)
            self.restate()
        self.rapid(self.targets(self.linear))
        self.contour(number)
        self.motion = None
        self.restate()

    def contour(self, number):
        rng, d = self.rng, self.dialect
        side, radius = rng.choice([1, -1]), self.case["radii"][number]
        on = {"heidenhain": "RL" if side > 0 else "RR", "sinumerik": "G41" if side > 0 else "G42"}.get(
            d, ("G41" if side > 0 else "G42") + " D%d" % int(number))
        heading = rng.uniform(0, 2 * math.pi)
        low = max(4.0, 1.5 * radius)

        def ahead(length):
            return {"X": self.m["X"] + length * math.cos(heading), "Y": self.m["Y"] + length * math.sin(heading)}
        if rng.random() < 0.3 and d != "heidenhain":
            self.plain(on)
            if rng.random() < 0.5:
                self.feed_move({"Z": self.m["Z"] - rng.choice([2.0, 15.0])})
            on = ""
        self.motion = 1 if d == "heidenhain" else None
        words = self.go(ahead(rng.uniform(low, 40)))
        self.block(["L"] * (d == "heidenhain") + ([] if d == "heidenhain" else [self.motion_word(rng.choice([0, 1, 1]), True)] + ([on] if on else [])) +
                   words + ([on] if d == "heidenhain" else []) + ["F300"])
        heading += rng.uniform(-1, 1)
        for _ in range(rng.randrange(2, 7)):
            kind = rng.random()
            if kind < 0.55:
                self.feed_move(ahead(rng.choice([rng.uniform(low, 30), rng.uniform(30, 90)])))
                heading += rng.choice([0.0, rng.uniform(-0.01, 0.01), rng.uniform(-1.2, 1.2), rng.uniform(-2.6, 2.6), math.pi / 2, -math.pi / 2])
            elif kind < 0.8:
                turn = rng.choice([1, -1])
                r = rng.choice([2.0, 8.0, 25.0]) + (radius if turn == side else 0.0)
                sweep = turn * rng.choice([math.pi / 2, rng.uniform(0.3, 3.0)])
                centre = (round(self.m["X"] - turn * r * math.sin(heading), 3), round(self.m["Y"] + turn * r * math.cos(heading), 3))
                a = math.atan2(self.m["Y"] - centre[1], self.m["X"] - centre[0]) + sweep
                r = math.dist(centre, (self.m["X"], self.m["Y"]))
                self.arc(turn < 0, centre, (centre[0] + r * math.cos(a), centre[1] + r * math.sin(a)))
                heading += sweep
            elif kind < 0.92:
                self.feed_move({"Z": self.m["Z"] - rng.choice([1.0, 8.0])})
            else:
                self.feed_move(dict(ahead(rng.uniform(low, 40)), Z=self.m["Z"] - 2.0))
                heading += rng.uniform(-0.5, 0.5)
            if d == "sinumerik" and kind < 0.8 and rng.random() < 0.25:
                self.add_words(self.corner_words())
        off = "R0" if d == "heidenhain" else "G40"
        if rng.random() < 0.3 and d != "heidenhain":
            self.plain(off)
            self.rapid({"Z": self.m["Z"] + rng.choice([5.0, 40.0])})
            self.rapid(ahead(30.0))
        elif d == "heidenhain":
            self.block(["L"] + self.go(ahead(30.0)) + [off])
        else:
            self.block([off, self.motion_word(rng.choice([0, 1]), True)] + self.go(ahead(30.0)))

    def f_tilt(self):
        """3+2: the rotary axes stand, words count in the tilted plane."""
        rng = self.rng
        if len(self.rotary) != 2 or any(self.offset(a) for a in self.rotary) or any(self.preset.values()) or self.g93 or \
                self.case.get("roll_over") in ("difference", "sign") or self.case.get("increment"):
            return
        self.plane_xy()
        tilting = [a for a in self.rotary if a != "C"][0]
        at = {tilting: rng.choice([30.0, -45.0, 90.0, round(rng.uniform(5, 60), 3)]), "C": rng.choice([0.0, 90.0, round(rng.uniform(0, 300), 3)])}
        ends = self.tilt_on(at, tilting)
        if not ends:
            return
        self.motion = None
        self.in_frame()
        for end in ends:
            self.plain(end)
        self.tcp = False
        self.m = {a: None for a in self.axes}
        if rng.random() < 0.5 and self.dialect in ("fanuc", "mazak", "haas"):
            self.length = 0.0
            self.plain("G49")
        self.restate()

    def normal(self, at):
        """Z of the plane to which the tool stands upright."""
        tip = Machine(MACHINES[self.case["machine"]], {}, [0.0, 0.0, 0.0])
        return [-v for v in tip.tip(dict({a: 0.0 for a in self.linear}, **at), 0.0)[1]]

    def tilt_on(self, at, tilting):
        rng, d = self.rng, self.dialect
        if d == "linuxcnc":
            return None
        number = rng.choice(sorted(self.case["lengths"]))

        def degrees(*values):
            return [("%.5f" % v).replace("-0.00000", "0.00000") for v in values]
        place = " ".join(a + "%.2f" % rng.uniform(-20, 20) for a in "XYZ")
        if d == "sinumerik":
            if self.inch:
                return None
            self.plain("D%d" % int(number))
            self.length = self.length_of(number)
            self.rapid(self.targets(self.linear))
            self.rapid(at)
            z = self.normal(at)
            a, b = math.degrees(math.atan2(-z[1], z[2])), math.degrees(math.asin(max(-1.0, min(1.0, z[0]))))
            turned = rng.choice([0.0, 30.0])
            self.lines.append("CYCLE800(0,\"TC1\",0,57,%s,%s,%s,%s)" % (
                ",".join("%.2f" % rng.uniform(-20, 20) for _ in range(3)), ",".join(degrees(a, b, turned)),
                rng.choice(["0,0,0", "5,0,-2.5"]), rng.choice(["0", "0,,0"])))
            self.tcp = True
            return ["CYCLE800()"]
        kind = rng.random()
        if d == "haas":
            at["C"] = 0.0
        self.rapid(self.targets(self.linear))
        self.rapid(at)
        z = self.normal(at)
        if d == "haas" and kind < 0.4:
            self.length = self.length_of(number)
            self.block([self.g(43), "H%d" % int(number), self.motion_word(0, True)] + self.go(self.targets(["Z"])))
            self.tcp = True
            self.plain("G254")
            return ["G255"]
        ends = ["G69"]
        if d == "haas":
            angle = degrees(math.degrees(math.atan2(z[0], z[2]) if tilting == "B" else math.atan2(-z[1], z[2])))[0]
            self.plain("G268 %s %s" % (place, "I0. J%s K0." % angle if tilting == "B" else "I%s J0. K0." % angle))
            ends = ["G269"]
        else:
            i, j = math.degrees(math.atan2(z[0], -z[1])), math.degrees(math.acos(max(-1.0, min(1.0, z[2]))))
            self.plain("G68.2 %s I%s J%s K%s" % (tuple([place] + degrees(i, j, rng.choice([0.0, 45.0, -90.0])))))
        self.tcp = True
        if rng.random() < 0.7:
            self.plain("G253" if d == "haas" else "G53.1")
        if not self.length or rng.random() < 0.6:
            self.length = self.length_of(number)
            self.m.update(X=None, Y=None, Z=None)
            self.block([self.g(43), "H%d" % int(number), self.motion_word(0, True)] + self.go(self.targets(["Z"])))
        return ends

    def tcp_on(self):
        rng, d = self.rng, self.dialect
        if d == "linuxcnc":
            return None
        number = rng.choice(sorted(self.case["lengths"]))
        if d == "sinumerik":
            self.plain("D%d" % int(number))
            self.length = self.length_of(number)
            if rng.random() < 0.5:
                self.restate()
            self.plain(rng.choice(["TRAORI", "TRAORI", "TRAORI(1)"]))
            if rng.random() < 0.85:  # a control may drop the offset, and turn the tool otherwise
                wcs = self.wcs or "G500"
                self.plain(rng.choice(["ORIAXES", wcs + " ORIAXES", wcs + " ORIAXES", wcs]))
            self.tcp = True
            self.rapid(self.targets(self.axes))
            return "TRAFOOF"
        code = "G234" if d == "haas" else "G43.4"
        kind = rng.random()
        upright = [a for a in self.rotary if a != "C"][0]
        if kind < 0.3:  # the length moves Z alone where the tool and the table stand upright
            self.rapid(dict(self.targets(["X", "Y", "C"]), **{upright: 0.0}))
            self.length, self.tcp = self.case["lengths"][number], True
            self.block([code, "H%d" % int(number)] + self.go(self.targets(["Z"])))
            self.m.update(X=None, Y=None)
        elif kind < 0.7:
            self.length, self.tcp = self.case["lengths"][number], True
            self.block([self.g(0), code, "H%d" % int(number)] + self.go(self.targets(self.axes)))
            self.motion = 0
        else:
            self.length, self.tcp = self.case["lengths"][number], True
            self.plain("%s H%d" % (code, int(number)))
            self.rapid(self.targets(self.axes))
        return "G49"

    def tcp_off(self, end):
        rng = self.rng
        self.plain(end)
        self.tcp = False
        self.m.update(X=None, Y=None, Z=None)
        if end == "G49":
            self.length = 0.0
            if rng.random() < 0.4:
                self.rapid(self.targets(["Z"]))
            self.rapid(self.targets(self.linear))
        else:
            if end == "TRAFOOF" and rng.random() < 0.8:
                self.plain(self.wcs or "G500")
            if rng.random() < 0.5:
                self.feed_move(self.targets(rng.sample(self.linear, 2)))
            self.rapid(self.targets(self.linear))

    def f_cycle(self):
        """Holes along Z, each somewhere else, some with words of their own."""
        rng, d = self.rng, self.dialect
        if self.g93 or self.incremental or self.case.get("orientation"):
            return
        self.plane_xy()
        self.restate()
        if d in ("sinumerik", "heidenhain"):
            return self.called_cycle()

        def height(letter, want):
            value = round((want - self.offset("Z")) / self.scale("Z"), self.places())
            return letter + self.number(value), value * self.scale("Z") + self.offset("Z")
        r = rng_value(rng, -40, 60)
        self.rapid({"Z": r + rng.choice([0.0, 3.0, 20.0, 55.5])})
        level, code, side = max(self.m["Z"], r), None, 98
        if self.m["Z"] < r:
            self.rapid({"Z": r + 1.0})
            level = self.m["Z"]
        codes = {"linuxcnc": [81, 82, 83, 85, 89], "haas": [73, 74, 76, 81, 82, 83, 84, 85, 86, 89]}.get(
            d, [73, 74, 76, 81, 82, 83, 84, 85, 86, 89])
        for k in range(rng.randrange(1, 6)):
            words = []
            is_new = code is None or rng.random() < 0.1
            if is_new:
                code = rng.choice(codes)
            if is_new or rng.random() < 0.1:
                words.append("G%d" % code)
            if (k == 0 and rng.random() < 0.8) or rng.random() < 0.15:
                side = rng.choice([98, 99])
                words.insert(rng.randrange(len(words) + 1), "G%d" % side)
            axes = rng.choice([["X"], ["Y"], ["X", "Y"], ["X", "Y"]])
            words += self.go(self.targets(axes))
            if is_new or rng.random() < 0.15:
                words.append(height("Z", r - rng.choice([2.0, 8.0, 30.5, 60.0]))[0])
            if is_new or rng.random() < 0.15:
                text, at = height("R", min(r, level) - rng.choice([0.0, 0.0, 0.5]))
                words.append(text)
                self.m["R"] = at
            if is_new:
                words += {82: ["P0.5" if d == "linuxcnc" else "P500"], 89: ["P0.5" if d == "linuxcnc" else "P500"],
                          73: ["Q3."], 83: ["Q3."], 76: ["Q0.2"]}.get(code, [])
                words.append("F%d" % rng.choice([80, 120, 300]))
            if rng.random() < 0.05:
                words.append("M8")
            self.block(words)
            if rng.random() < 0.05:
                self.plain("M9")
        self.m["Z"] = level if side == 98 else self.m["R"]
        del self.m["R"]
        self.motion = None
        if rng.random() < 0.85:
            self.plain("G80")
            self.motion = 0 if d != "linuxcnc" else None
        self.feed = None
        self.rapid(self.targets(self.some_axes()))
        self.f_lines()

    def called_cycle(self):
        """CYCLE81 alone or by MCALL; heights are program positions."""
        rng = self.rng
        entry, depth = round(rng.uniform(-30, 40), 2), rng.choice([5.0, 12.5, 40.0])
        over = rng.choice([2.0, 25.0])
        scale = self.scale("Z")
        arguments = [self.number((entry + over) / scale), self.number((entry - 1.0) / scale), self.number(1.0 / scale),
                     self.number((entry - depth) / scale)]
        if rng.random() < 0.3:
            arguments[3:] = ["", self.number((depth - 1.0) / scale)]
        name = "CYCLE%d" % rng.choice([81, 82, 83, 84, 85, 86, 89])
        call = "%s(%s)" % (name, ",".join(arguments))
        if rng.random() < 0.3:
            self.rapid(self.targets(["X", "Y"]))
            self.lines.append(call)
        else:
            self.lines.append("MCALL " + call)
            for _ in range(rng.randrange(1, 5)):
                self.rapid(self.targets(rng.choice([["X"], ["Y"], ["X", "Y"]])))
            for _ in range(rng.choice([0, 0, 1, 1, 2])):
                self.pattern_of_holes()
            self.plain("MCALL")
        self.m["Z"] = None
        self.rapid(self.targets(self.linear))
        self.f_lines()

    def pattern_of_holes(self):
        """A row or a circle, which calls the cycle of MCALL."""
        rng = self.rng
        place = [round(rng.uniform(-40, 40), 2) for _ in range(2)]
        if rng.random() < 0.3:
            self.plain("G1 F200")
            self.motion = 1
        angle = rng.choice([0, 30, -90, round(rng.uniform(-179, 180), 2)])
        kind = rng.choice([1, 2])
        if kind == 1:
            words = place + [angle, rng.choice([0, 5, 7.5]), rng.choice([8, 12.25]), rng.randrange(1, 6)]
        else:
            words = place + [rng.choice([15, 22.5]), angle, rng.choice([0, 30, -40]), rng.randrange(1, 7)]
        self.lines.append("HOLES%d(%s)" % (kind, ",".join("%g" % w for w in words)))
        self.m["X"] = self.m["Y"] = None
        self.motion = None

    def f_expression(self):
        """Words of variables that the program has set: X[#101+2.5*3.], X=R1-4."""
        rng = self.rng
        if self.case.get("increment"):
            return
        first, second = rng.randrange(101, 140), rng.randrange(140, 180)
        for _ in range(rng.randrange(1, 3)):
            words = {}
            for axis in rng.sample(self.linear, rng.choice([1, 1, 2])):
                want = round((rng_value(rng, *RANGE[axis]) - self.offset(axis)) / self.scale(axis), 3)
                kind = rng.randrange(5 if self.dialect != "linuxcnc" else 4)
                if kind == 0 or self.incremental:
                    terms = [(first, want, 1.0)]
                elif kind < 3:
                    part = round(rng.uniform(-20, 20), 3)
                    terms = [(first, round(want - part, 3), 1.0), (None, part, 1.0)]
                else:
                    part, factor = round(rng.uniform(-9, 9), 2), rng.choice([2.0, -1.5, 0.25])
                    terms = [(first, round(want - part * factor, 5), 1.0), (second, part, factor)]
                words[axis] = terms
            text = []
            for number, (axis, terms) in enumerate(words.items()):
                text.append(self.expression(axis, terms, 10 * number))
                value = sum(v * f for _, v, f in terms)
                self.m[axis] = value * self.scale(axis) + self.offset(axis)
            code = self.motion_word(1, True)
            if self.dialect == "sinumerik":  # the names of variables end at a blank
                text = [" " + " ".join(text) + " "] if self.packed else text
            self.block([code] + text + [self.feed_word()])
        self.f_lines()

    def expression(self, axis, terms, shift):
        """Writes the assignments; returns the word."""
        sin = self.dialect == "sinumerik"
        name = (lambda n: "R%d" % (n + shift)) if sin else (lambda n: "#%d" % (n + shift))
        out = ""
        for number, value, factor in terms:
            if number is None:
                out += ("%+.3f" % value) if out else "%.3f" % value
                continue
            self.lines.append("%s=%.5f" % (name(number), value))
            if factor == 1.0:
                out += ("+" if out else "") + name(number)
            elif factor < 0:
                out += "-%.2f*%s" % (-factor, name(number))
            else:
                out += ("+" if out else "") + "%.2f*%s" % (factor, name(number))
        if sin:
            return "%s=%s" % (axis, out)
        return "%s%s" % (axis, out if out == name(terms[0][0]) else "[%s]" % out)

    def f_o_arguments(self):
        """A subprogram of LinuxCNC that goes where its arguments say."""
        rng = self.rng
        if self.dialect != "linuxcnc" or self.g93 or self.incremental:
            return
        self.sub_number += 1
        number, part = self.sub_number, round(rng.uniform(-9, 9), 2)
        self.tail += ["O%d sub" % number, "G1 X#1 Y[#2+%.2f] F500" % part, "O%d endsub" % number]
        for _ in range(rng.choice([1, 2, 3])):
            wants = {a: round((rng_value(rng, *RANGE[a]) - self.offset(a)) / self.scale(a), 3) for a in ("X", "Y")}
            first, second = "%.3f" % wants["X"], "%.3f" % (wants["Y"] - part)
            if rng.random() < 0.3:
                self.lines.append("#7=%s" % first)
                first = rng.choice(["#7", "#7+0.5-0.5"])
            self.lines.append("O%d call [%s] [%s]" % (number, first, second))
            for axis, want in wants.items():
                self.m[axis] = want * self.scale(axis) + self.offset(axis)
            self.motion = self.feed = None
        self.restate()

    def f_file(self):
        """A subprogram in a file of its own, called once or twice."""
        rng, d = self.rng, self.dialect
        if d in ("heidenhain", "sinumerik") or self.g93:
            return
        self.sub_number += 1
        number = self.sub_number
        body = self.body()
        text = self.subprogram(number, body)
        if d != "linuxcnc":
            text = ["%"] + text + ["%"] if rng.random() < 0.5 else text
        self.case.setdefault("files", {})["%d.%s" % (number, "ngc" if d == "linuxcnc" else "nc")] = text
        for k in range(rng.choice([1, 2])):
            if k > 0:
                self.f_lines()
            self.call_block(self.call(number, "" if d == "linuxcnc" else rng.choice(["", " L2"])))
            self.motion = self.feed = None
        self.restate()

    def call_block(self, text):
        """O words of LinuxCNC have no line number."""
        self.lines.append(text) if self.dialect == "linuxcnc" else self.block([text])

    def f_orivect(self):
        """TRAORI whose tool turns by a vector, or nobody says how: short moves, and long ones."""
        rng = self.rng
        if self.dialect != "sinumerik" or len(self.rotary) != 2 or any(self.offset(a) for a in self.rotary) or \
                any(self.preset.values()) or self.g93 or self.case.get("roll_over") in ("difference", "sign"):
            return
        self.plane_xy()
        number = rng.choice(sorted(self.case["lengths"]))
        self.plain("D%d" % int(number))
        self.length = self.length_of(number)
        self.plain("TRAORI")
        self.plain("%s %s" % (self.wcs or "G500", rng.choice(["ORIWKS", "ORIVECT", "ORIWKS ORIVECT"])))
        self.tcp, self.feed = True, None
        tilting = [a for a in self.rotary if a != "C"][0]
        at = self.targets(self.axes)
        at[tilting] = round(rng.uniform(12, 50), 3)
        self.rapid(at)
        most = rng.choice([0.05, 0.2, 0.8, 20.0])
        for _ in range(rng.randrange(1, 5)):
            axes = rng.sample(self.linear, 2) + rng.sample(self.rotary, rng.choice([1, 2]))
            self.feed_move({a: self.m[a] + rng.uniform(-most, most) for a in axes})
        self.tcp_off("TRAFOOF")

    def f_approach(self):
        """APPR and DEP are Klartext's."""

    def f_resets(self):
        """What posts write to be safe: ends of modes that were never begun."""
        rng = self.rng
        if self.dialect == "sinumerik":
            for reset in rng.sample(["TRANS", "ROT", "SCALE", "MIRROR", "MCALL", "TRAFOOF", "CYCLE800()"], 3):
                self.plain(reset)
            self.restate()
        elif self.dialect == "heidenhain":
            for reset in rng.sample([("CYCL DEF 7.0 DATUM SHIFT", "CYCL DEF 7.1 X+0", "CYCL DEF 7.2 Y+0"),
                                     ("CYCL DEF 8.0 MIRROR IMAGE", "CYCL DEF 8.1"), ("CYCL DEF 10.0 ROTATION", "CYCL DEF 10.1 ROT+0"),
                                     ("CYCL DEF 19.0 WORKING PLANE", "CYCL DEF 19.1"), ("PLANE RESET STAY",), ("M129",)], 2):
                for line in reset:
                    self.plain(line)
        self.f_lines()

    # -- features that the product refuses, or passes
    def recover(self):
        """States the modes again that a passed block may have left unknown."""
        rng = self.rng
        if rng.random() < 0.9:
            if self.dialect == "sinumerik":
                self.plain("G90 G17 G94 %s G1 G71" % (self.wcs or "G500"))
            else:
                self.plain("G90 G17 G94 %s %s G21" % ("G0" if self.dialect == "linuxcnc" else "G1", self.wcs))
            self.plane, self.motion, self.incremental, self.inch = 17, 0 if self.dialect == "linuxcnc" else 1, False, False
            self.feed = None
        self.length_known()
        self.restate()
        self.f_lines()

    def length_known(self):
        if self.dialect == "sinumerik":
            number = self.rng.choice(sorted(self.case["lengths"]))
            self.length = self.length_of(number)
            self.plain("D%d" % int(number))
        elif self.rng.random() < 0.8:
            self.length = 0.0
            self.plain("G49")

    def r_tcp(self):
        rng = self.rng
        if not self.rotary:
            return
        d = self.dialect
        if d == "sinumerik":
            self.plain("TRAORI")
        elif d == "haas":
            self.plain("G234 H1")
        elif d == "linuxcnc":
            self.plain("M428")
            self.plain(rng.choice(["G49", "G43 H1", "M3 S300"]))
        else:
            self.plain(rng.choice(["G43.4 H1", "G43.4 H1 Z50.", "G43.5 H1", "G43.5 H1", "G43.4 H1 P#3"]))
        saved = dict(self.m)
        self.motion = None
        for _ in range(rng.randrange(1, 4)):
            axes = self.targets(self.axes if rng.random() < 0.6 else self.some_axes())
            self.feed_move(axes)
        if d == "sinumerik":
            self.plain("TRAFOOF")
        elif d == "linuxcnc":
            self.plain("M429")
        elif rng.random() < 0.9:
            self.plain("G49")
            self.length = 0.0
        self.m = saved
        self.feed_move(self.targets(rng.sample(self.linear, 2)))
        if d != "linuxcnc":
            self.recover()
        else:
            self.feed_move(self.targets(self.axes))

    def r_tilt(self):
        d = self.dialect
        on, off = {"sinumerik": ("CYCLE800(1,\"TC\",0,57,0,0,0,0,30,0,0,0,0,1)", "CYCLE800()"), "haas": ("G268 X0. Y0. Z0. I0. J30. K0.", "G269"),
                   "linuxcnc": (None, None)}.get(d, ("G68.2 X0. Y0. Z0. I0. J30. K0.", "G69"))
        if not on or not self.rotary:
            return
        self.lines.append(on)
        if d in ("fanuc", "mazak") and self.rng.random() < 0.6:
            self.plain("G53.1")
        self.motion = None
        for _ in range(2):
            self.feed_move(self.targets(self.rng.sample(self.linear, 2)))
        self.plain(off)
        self.recover()

    def r_rotation(self):
        d = self.dialect
        on, off = {"sinumerik": ("ROT Z30", "ROT"), "linuxcnc": (None, None)}.get(d, ("G68 X0. Y0. R30.", "G69"))
        if not on:
            return
        self.plain(on)
        self.motion = None
        for _ in range(2):
            self.feed_move(self.targets(self.rng.sample(self.linear, 2)))
        if self.rng.random() < 0.85:
            self.plain(off)
        self.recover()

    def r_mode(self):
        rng, d = self.rng, self.dialect
        modes = {"sinumerik": [("TRANS X10", "TRANS"), ("SCALE X2", "SCALE"), ("MIRROR X0", "MIRROR"), ("G41 D1", "G40"), ("D2 G42", "G40"),
                               ("ATRANS Y5", "TRANS"), ("TRANSMIT", "TRAFOOF")],
                 "linuxcnc": [("G41 D1", "G40"), ("G41.1 D4.", "G40"), ("G43.1 Z5.", "G49"), ("G7", "G8")]}.get(
            d, [("G51 X0. Y0. P2.", "G50"), ("G51.1 X0.", "G50.1 X0."), ("G41 D1", "G40"), ("G42 D2", "G40"), ("G16", "G15"),
                ("G66 P9010 Q1.", "G67")])
        on, off = rng.choice(modes)
        self.plain(on)
        self.motion = None
        for _ in range(rng.randrange(1, 3)):
            self.feed_move(self.targets(rng.sample(self.linear[:2], 2)))
        self.plain(off)
        self.feed_move(self.targets(rng.sample(self.linear[:2], 1)))
        self.recover()

    def r_cycle(self):
        rng, d = self.rng, self.dialect
        if d == "sinumerik":
            self.lines.append(rng.choice(["CYCLE81(10,0,2,-20)", "POCKET3(10,0,1,-5,20,10,3,0,0,0)", "HOLES2(0,0,20,0,60,6)"]))
        else:
            self.plain(rng.choice(["G98 G81 X10. Y20. Z-10. R5. F100", "G99 G83 X5. Y5. Z-20. R2. Q3. F150",
                                   "G81 X-20. Y0. Z-5. R1. F80"]))
            if rng.random() < 0.5:
                self.plain("X30. Y%d." % rng.randrange(40))
            if rng.random() < 0.8:
                self.plain("G80")
        self.motion = None
        self.feed_move(self.targets([rng.choice("XY")])) if rng.random() < 0.5 else None
        self.recover()

    def r_call(self):
        """A subprogram: elsewhere, or behind the end of this text."""
        rng, d = self.rng, self.dialect
        if d == "sinumerik":
            self.plain(rng.choice(["L100", "SUB_A", "EXTCALL(\"PART\")" if False else "L7"]))
        elif rng.random() < 0.3:
            self.plain("M98 P%d" % (9000 + rng.randrange(100)) if d != "linuxcnc" else "O%d call" % (9000 + rng.randrange(100)))
        else:
            self.sub_number += 1
            number = self.sub_number
            lines, self.lines, saved = self.lines, [], (dict(self.m), self.motion, self.feed, self.numbering, self.n)
            self.motion, self.feed = None, None
            self.numbering = "none"
            kind = rng.randrange(3)
            if kind == 0:
                self.f_lines()
            elif kind == 1:
                self.plain("G91")
                self.incremental = True
                self.feed_move({"X": self.m["X"] + 5, "Y": self.m["Y"] - 3})
                self.f_circle_modal()
                self.plain("G90")
                self.incremental = False
            else:
                self.f_arc()
                self.f_circle_modal()
            body, self.lines = self.lines, lines
            self.m, self.motion, self.feed, self.numbering, self.n = saved[0], None, None, saved[3], saved[4]
            if d == "linuxcnc":
                head = ["O%d sub" % number] + body + ["O%d endsub" % number]
                if rng.random() < 0.5:
                    self.tail += head
                else:
                    self.lines += head
                self.plain("O%d call" % number) if self.numbering == "none" else self.lines.append("O%d call" % number)
            else:
                self.tail += ["O%d" % number] + body + ["M99"]
                self.plain("M98 P%d%s" % (number, rng.choice(["", "", " L2"])))
        self.recover()

    def body(self):
        """Lines of a subprogram that runs from wherever the axes stand."""
        lines, self.lines, numbering = self.lines, [], self.numbering
        self.motion, self.feed, self.numbering = None, None, "none"
        if self.rng.random() < 0.5:
            self.f_lines()
        else:
            self.distances(True)
            for _ in range(self.rng.randrange(1, 4)):
                axes = self.rng.sample(self.linear, self.rng.choice([1, 2]))
                if self.rotary and self.dialect not in ("linuxcnc", "heidenhain") and self.rng.random() < 0.3:
                    axes.append(self.rng.choice(self.rotary))
                self.feed_move({a: self.m[a] + rng_value(self.rng, -8, 8) for a in axes})
            self.distances(False)
        found, self.lines, self.numbering = self.lines, lines, numbering
        self.motion = self.feed = None
        return found

    def f_call(self):
        """A subprogram of this text that is called several times."""
        rng, d = self.rng, self.dialect
        if d == "sinumerik" or self.g93:
            return
        self.sub_number += 1
        number = self.sub_number
        body = self.body()
        if rng.random() < 0.3:  # one in another
            inner = number + 137
            self.tail += self.subprogram(inner, body)
            body = [self.call(inner, "")]
        if d == "linuxcnc" and rng.random() < 0.5:
            self.lines += self.subprogram(number, body)
        else:
            self.tail += self.subprogram(number, body)
        for k in range(rng.choice([1, 2, 2])):
            if k > 0:
                self.f_lines()
            repeats = "" if d == "linuxcnc" else rng.choice(["", "", " L2"])
            self.call_block(self.call(number, repeats))
            self.motion = self.feed = None
        self.restate()

    def subprogram(self, number, body):
        if self.dialect == "linuxcnc":
            return ["O%d sub" % number] + body + ["O%d endsub" % number]
        return ["O%d" % number + self.rng.choice(["", " (SUB)"])] + body + ["M99"]

    def call(self, number, repeats):
        if self.dialect == "linuxcnc":
            return "O%d call" % number
        if self.rng.random() < 0.15:
            return "G65 P%d%s A1." % (number, repeats)
        modes = ""
        if self.rng.random() < 0.25 and not self.incremental:
            modes = "G90 " + (self.wcs + " " if self.wcs in ("G54", "G55", "G56", "G57", "G58", "G59") and self.rng.random() < 0.5 else "")
        return "%sM98 P%d%s" % (modes, number, repeats)

    def r_macro(self):
        rng = self.rng
        d = self.dialect
        if d == "sinumerik":
            self.plain("R1=%d" % rng.randrange(1, 30))
            self.block([self.g(1), "X=R1", "F500"])
        else:
            self.plain("#100=%d." % rng.randrange(1, 30))
            self.block([self.g(1), "X#100", "F500"])
        self.motion = 1
        if rng.random() < 0.4 and d not in ("sinumerik", "linuxcnc"):
            self.plain("G65 P9100 Q1. S2.")
            self.motion = None
        self.feed_move(self.targets([rng.choice("XY")]))
        self.recover()

    def r_pattern(self):
        """Holes of a pattern, boring from behind and by hand: positions that stand in no word, or that a hand leaves."""
        rng, d = self.rng, self.dialect
        if d == "sinumerik":
            self.lines += ["MCALL CYCLE81(50,0,2,-20)", rng.choice(["HOLES1(0,0,30,5,10,4)", "HOLES2(0,0,20,0,60,6)"]), "MCALL"]
        elif d == "heidenhain":
            return
        else:
            self.plain(rng.choice(["G98 G87 X10. Y20. Z-5. R-30. Q3. F60", "G98 G88 X10. Y20. Z-20. R5. P500 F60"] +
                                  (["G70 I20. J0. L6", "G72 I10. J30. L4"] if d == "haas" else []) +
                                  (["G16", "G17 G16"] if d in ("fanuc", "mazak") else [])))
            if "G16" in self.lines[-1]:
                self.plain("G81 X30. Y45. Z-10. R5. F100")
                self.plain("G80")
                self.plain("G15")
            else:
                self.plain("G80")
        self.motion = None
        self.feed_move(self.targets([rng.choice("XY")])) if rng.random() < 0.5 else None
        self.recover()

    def r_polar(self):
        """Ends of moves by an angle and a radius."""
        if self.dialect != "sinumerik":
            return
        self.plain(self.rng.choice(["G111 X5 Y5", "G110 X5 Y5", "G112 X1 Y1"]))
        self.plain(self.rng.choice(["G1 AP=30 RP=20 F300", "G0 AP=12.5 RP=30"]))
        self.motion = None
        self.recover()

    def r_kinematics(self):
        """Switchable kinematics of LinuxCNC."""
        if self.dialect != "linuxcnc":
            return
        self.plain(self.rng.choice(["M428", "M429", "M430"]))
        for _ in range(self.rng.randrange(1, 3)):
            self.feed_move(self.targets(self.axes))
        self.plain(self.rng.choice(["M428", "M429"]))
        self.feed_move(self.targets(self.axes))

    MALFORMED = ["G1 X", "G1 X1O.", "G1 X--5.", "G1 X5. X6.", "G1 X5.5.5", "G1 X1E3", "G1 (OPEN X5.", "G1 ((A) B) X5.", "X5. Y",
                 "G1 X5. Y6.F", "G1 G0 X5.", "G1 X[5.", "G1 X5.]", "GX5.", "G1 X5. F-", "N G1 X5.", "\t;;G1 X5.", "G2 X5. Y5.", "G1 X=", "@X5.",
                 "G1 X\u00d85.", "G1 X99999999999999999999.", "G1 XY5.", "L X+", "L X+5 Y", "CC X", "C X+5", "L X5.5.5", "TOOL CALL", "G999 X5."]

    def r_malformed(self):
        """A line that no control reads, or that it reads otherwise than who wrote it thought."""
        rng = self.rng
        text = rng.choice(self.MALFORMED)
        if rng.random() < 0.4 and self.lines:  # a line of the program with letters lost or doubled
            text = rng.choice(self.lines)
            at = rng.randrange(len(text) + 1)
            text = text[:at] + rng.choice(["", text[at:at + 1] * 2, ".", "-", "X", "(", " 5"]) + text[at + 1:]
        self.lines.append(text)
        if rng.random() < 0.5:
            self.feed_move(self.targets([rng.choice("XY")]))
        self.recover()

    def r_probe(self):
        d = self.dialect
        if d == "sinumerik":
            self.plain("MEAS=1 G1 X10 F100") if False else self.plain("G74 X1=0" if False else "G75 X0")
        else:
            self.plain("G31 Z-5. F50" if d != "linuxcnc" else "G38.2 Z-5. F50")
        self.motion = None
        self.feed_move(self.targets([self.rng.choice("XY")])) if self.rng.random() < 0.5 else None
        self.recover()

    def r_unknown_m(self):
        """M codes of the machine's builder, which may call a macro."""
        rng = self.rng
        code = rng.choice([71, 81, 123, 150, 428 if self.dialect != "linuxcnc" else 123, 60, 50 if self.dialect == "haas" else 60])
        self.plain("M%d" % code)
        if rng.random() < 0.5:
            self.rapid(self.targets([rng.choice("XY")]))
        else:
            self.feed_move(self.targets([rng.choice("XY")]))
        self.recover()

    def r_builder_block(self):
        """Such an M code in the block of a move."""
        code = self.rng.choice([71, 123, 60])
        self.feed_move(self.targets([self.rng.choice("XY")]), code="M%d" % code)
        self.recover()

    def r_lathe(self):
        if self.dialect not in ("fanuc", "mazak"):
            return
        self.plain("G50 X200. Z100.")
        self.feed_move(self.targets(["X"]))
        self.recover()

    def r_data_input(self):
        if self.dialect in ("sinumerik",):
            return
        kinds = ["G10 L2 P0 X5. Y-3.", "G10 L10 P1 R10.", "/G10 L2 P1 X5."]
        if self.dialect == "linuxcnc":
            kinds = ["G10 L20 P1 X5. Y-3.", "G10 L2 P0 X5.", "/G10 L2 P1 X5."]
        self.plain(self.rng.choice(kinds))
        self.motion = None
        self.feed_move(self.targets(["X"]))
        self.recover()

    def r_passed_arc(self):
        """An arc that is passed, from a position that was corrected."""
        rng = self.rng
        r = rng.choice([10, 50])
        self.feed_move(self.targets(["X", "Y"]))
        if self.plane_codes() and self.plane != 17:
            self.plane = 17
            self.plain("G17")
        form = rng.randrange(3)
        d = self.dialect
        radius = "CR=" if d == "sinumerik" else "R"
        x, y = self.m["X"] - self.offset("X"), self.m["Y"] - self.offset("Y")
        scale = self.scale("X")
        if form == 0:    # a parameter that the product does not follow
            words = [self.g(2), "X" + self.number(x / scale), "Y" + self.number(y / scale), "I" + self.number(r / scale)]
            if d == "sinumerik":
                self.plain("R2=%d" % r)
                words[-1] = "I=R2"
            else:
                self.plain("#101=%d." % r)
                words[-1] = "I#101"
            self.block(words + ["F400"])
        elif form == 1:  # a mode that is passed begins in front of it
            self.plain({"sinumerik": "TRANS X0"}.get(d, "G10 L2 P0 X0."))
            self.block([self.g(3), "I" + self.number(r / scale), "F400"])
        else:
            self.plain(self.call_elsewhere())
            self.block([self.g(2), "X" + self.number((x + 2 * r) / scale), "Y" + self.number(y / scale), radius + self.number(r / scale + 1), "F300"])
        self.motion = None
        self.recover()

    def call_elsewhere(self):
        return {"sinumerik": "L100", "linuxcnc": "O9000 call"}.get(self.dialect, "M98 P9000")

    def r_unstated_offset(self):
        """A work offset whose values axiscal is not told."""
        self.plain(self.case["unstated"][0])
        self.motion = None
        self.feed_move(self.targets(self.rng.sample(self.linear, 2)))
        self.recover()

    def r_local_call(self):
        if self.dialect != "haas":
            return
        label = 5000 + len(self.lines)
        self.plain("M97 P%d%s" % (label, self.rng.choice(["", " L2"])))
        lines, self.lines, saved, numbering = self.lines, [], dict(self.m), self.numbering
        self.numbering = "none"
        self.motion, self.feed = None, None
        self.f_short_lines()
        self.f_arc()
        self.tail += ["N%d" % label] + self.lines + ["M99"]
        self.lines, self.m, self.numbering, self.motion, self.feed = lines, saved, numbering, None, None
        self.recover()

    def r_spline(self):
        if self.dialect == "sinumerik":
            self.plain("BSPLINE")
        elif self.dialect in ("fanuc", "mazak"):
            self.plain("G6.2 X5. Y5. K1.")
        else:
            return
        self.recover()

    def plane_codes(self):
        return True

    PLAIN = [("lines", 5), ("short_lines", 2), ("arc", 4), ("circle_modal", 1), ("incremental", 2), ("codes", 4), ("offset", 1),
             ("length", 1), ("tool_change", 1), ("g28", 1), ("preset", 0.7), ("local", 0.7), ("skip", 0.7), ("inverse_time", 1),
             ("unit", 0.6), ("absolute_centres", 0.5), ("corner", 0.6), ("rounded", 1.5), ("wrap", 0.6), ("long_line", 0.4), ("over", 0.5),
             ("rotary_feed", 0.5), ("builder", 0.7), ("tcp", 1.5), ("resets", 0.7), ("cycle", 1.5), ("data_input", 1), ("call", 1.5), ("o_arguments", 0.7), ("shift", 1),
             ("frame", 1.5), ("tilt", 1.5), ("contour", 2), ("vector", 1.5), ("expression", 1), ("file", 1), ("orivect", 1)]
    REFUSED = [("tcp", 2), ("tilt", 1), ("rotation", 1), ("mode", 1.5), ("cycle", 1.5), ("call", 2), ("macro", 1), ("probe", 0.7),
               ("pattern", 1), ("polar", 0.7), ("kinematics", 1), ("malformed", 1.5),
               ("unknown_m", 1.5), ("builder_block", 0.7), ("lathe", 1), ("data_input", 0.7), ("passed_arc", 1.5), ("spline", 0.4),
               ("unstated_offset", 0.7), ("local_call", 0.5)]

    def begin(self):
        rng = self.rng
        d = self.dialect
        if d == "sinumerik":
            if rng.random() < 0.5:
                self.lines.append("%_N_PART_MPF")
        else:
            if rng.random() < 0.5:
                self.lines.append("%")
            if d != "linuxcnc":
                self.lines.append("O%04d" % rng.randrange(1, 900) + rng.choice(["", " (PART)"]))
        if rng.random() < 0.5:
            self.lines.append(self.comment("PART %d" % rng.randrange(1000)))
        unit = {"sinumerik": ("G70", "G71")}.get(d, ("G20", "G21"))
        if self.case.get("states_unit", True):
            codes = [unit[1]]
        else:
            codes = []
        first = [n for n in self.case["offsets"] if n not in self.case["unstated"]]
        self.wcs = rng.choice(first)
        codes += ["G90", "G17", "G94", "G40", self.wcs]
        if d not in ("sinumerik",):
            codes += ["G49", "G80"]
        rng.shuffle(codes)
        if d == "haas" and "P" in self.wcs or "P" in self.wcs:
            codes = [c for c in codes if c != self.wcs]
            self.block(codes)
            self.plain(self.wcs)
        else:
            self.block(codes)
        if d == "sinumerik":
            self.length_known()
        if self.case["unit"] == "inch" and not self.case.get("states_unit", True):
            self.inch = True
        if self.case["start_option"] and self.dialect != "sinumerik":
            self.m = dict(self.case["start"])
            self.f_lines()
        self.restate()
        self.feed = None

    def end(self):
        rng = self.rng
        if self.dialect == "linuxcnc":
            self.lines.append(rng.choice(["M2", "M30"]))
        else:
            self.lines.append("M30" if self.dialect != "sinumerik" else rng.choice(["M30", "M2"]))
        self.lines += self.tail
        if self.lines[0] == "%":
            self.lines.append("%")

    def make(self):
        rng = self.rng
        self.begin()
        count = rng.randrange(2, 9)
        refused = set()
        if self.case["mixed"]:
            refused = set(rng.sample(range(count), min(count, rng.choice([1, 1, 2]))))
        for i in range(count):
            table = self.REFUSED if i in refused else self.PLAIN
            names = [n for n, _ in table if n not in self.case["without"]]
            name = rng.choices(names, [w for n, w in table if n in names])[0]
            before = len(self.lines) + len(self.tail)
            getattr(self, ("r_" if i in refused else "f_") + name)()
            if len(self.lines) + len(self.tail) > before:  # some are of other controls or machines: they write nothing
                self.features.append(name)
        self.end()
        return self.lines


def rng_value(rng, low, high):
    kind = rng.random()
    if kind < 0.25:
        return float(round(rng.uniform(low, high)))
    if kind < 0.4:
        return round(rng.uniform(low, high) / 10) * 10.0
    return round(rng.uniform(low, high), 4)


class KlartextProgram(Program):
    PLAIN = [("lines", 5), ("short_lines", 2), ("arc", 4), ("incremental", 2), ("codes", 4), ("tool_change", 1), ("g28", 1),
             ("skip", 0.5), ("corner", 0.6), ("long_line", 0.4), ("over", 0.7), ("rotary_feed", 0.5), ("roll", 0.7), ("builder", 0.7), ("tcp", 1.5), ("resets", 0.7), ("cycle", 1.5), ("offset", 1), ("call", 1.5), ("section", 0.7), ("shift", 1),
             ("frame", 1.5), ("tilt", 1.5), ("contour", 2), ("vector", 1.5), ("expression", 1), ("approach", 1)]
    REFUSED = [("malformed", 1.5), ("tcp", 2), ("unstated_offset", 0.7), ("tilt", 1), ("rotation", 1.5), ("mode", 1.5), ("cycle", 1.5), ("pattern", 1.5), ("call", 2), ("macro", 1),
               ("unknown_m", 1.5), ("passed_arc", 1.5), ("polar", 1),
               ("program_call", 0.7)]

    def block(self, words, comment=None):
        words = [w for w in words if w]
        self.lines.append("%d %s" % (self.n, " ".join(words)))
        self.n += 1

    def plain(self, text):
        self.block([text])

    def number(self, value, places=None, is_axis=False):
        text = "%.*f" % (self.places() if places is None else places, value)
        if float(text) == 0:
            text = text.lstrip("-")
        if self.habit != "fixed":
            text = text.rstrip("0").rstrip(".")
        return text if text.startswith("-") else "+" + text

    def axis_word(self, axis, value):
        return ("I" if self.incremental else "") + axis + self.number(value)

    def comment(self, text):
        return "; " + text

    def compensation(self):
        return "R0" if self.rng.random() < 0.3 else ""

    def rapid(self, targets):
        self.block(["L"] + self.go(targets, True) + [self.compensation(), "FMAX"])

    def feed_word(self, minutes=None):
        if self.feed is None or self.rng.random() < 0.2:
            self.feed = self.rng.choice([200, 500, 1500])
            return "F%d" % self.feed
        return ""

    def feed_move(self, targets, minutes=None, code=""):
        self.block(["L"] + self.go(targets, True) + [self.compensation(), self.feed_word(), code])

    def plane_codes(self):
        return False

    def arc(self, clockwise, centre, end, more=None, form="centre"):
        start = (self.m["X"], self.m["Y"])
        scale = self.length_scale()
        sense = "DR-" if clockwise else "DR+"
        if form == "radius" and math.dist(start, end) > 1e-6:
            a0 = math.atan2(start[1] - centre[1], start[0] - centre[0])
            a1 = math.atan2(end[1] - centre[1], end[0] - centre[0])
            sweep = (a1 - a0) % (2 * math.pi)
            if clockwise:
                sweep = 2 * math.pi - sweep
            radius = math.dist(start, centre) / scale * (-1 if sweep > math.pi else 1)
            self.block(["CR"] + self.go({"X": end[0], "Y": end[1]}, True) + ["R" + self.number(radius), sense, self.feed_word()])
            return
        if self.incremental or self.rng.random() < 0.15:
            self.block(["CC", "IX" + self.number((centre[0] - start[0]) / scale), "IY" + self.number((centre[1] - start[1]) / scale)])
        else:
            self.block(["CC", "X" + self.number((centre[0] - self.offset("X")) / scale), "Y" + self.number((centre[1] - self.offset("Y")) / scale)])
        self.block(["C"] + self.go({"X": end[0], "Y": end[1]}, True) + [sense, self.feed_word()])

    def distances(self, incremental):
        self.incremental = incremental  # IX+5: each word says it

    def f_codes(self):
        rng = self.rng
        kind = rng.randrange(7)
        if kind == 0:
            self.plain("L M3")
        elif kind == 1:
            self.plain(rng.choice(["M8", "M9", "STOP", "M5", "L M13", "TOOL CALL S3000", "FN 0: Q5 = +3", "Q7 = +12.5", "TOOL DEF 7", "M136", "M137"]))
        elif kind == 2:
            self.plain("CYCL DEF 9.0 DWELL")
            self.plain("CYCL DEF 9.1 DWELL 0.5")
        elif kind == 3:
            self.plain("; ROUGHING X+10")
        elif kind == 4:
            self.plain("CYCL DEF 32.0 TOLERANCE")
            self.plain("CYCL DEF 32.1 T0.01")
        elif kind == 5:
            self.feed_move(self.targets(self.some_axes()), code=rng.choice(["M8", "M3"]))
        else:
            self.feed_move({a: self.m[a] + 3.0 for a in rng.sample(self.linear, 1)}, code=rng.choice(["M9", "M5"]))

    def f_tool_change(self):
        tool = self.rng.choice(sorted(self.case["lengths"]))
        difference = self.rng.choice(["", "", " DL+0.1"])
        self.plain("TOOL CALL %d Z S2000%s" % (int(tool), difference))
        self.length = self.case["lengths"][tool] + (0.1 * self.length_scale() if difference else 0.0)
        self.restate(True)

    def f_g28(self):
        self.plain(self.rng.choice(["L Z+%d R0 FMAX M91" % self.rng.randrange(0, 60), "L Z+10 R0 FMAX M92", "M140 MB MAX",
                                    "L M140 MB 50 F MAX", "PLANE RESET TURN FMAX", "PLANE RESET MOVE DIST50 F500", "M6"]))
        self.rapid(self.targets(self.rng.sample(["X", "Y"], self.rng.choice([1, 2]))))
        self.restate()

    def f_skip(self):
        saved, feed = dict(self.m), self.feed
        self.block(["L"] + self.go(self.targets(self.rng.sample(self.linear, 2)), True) + ["F500"])
        self.lines[-1] = "/" + self.lines[-1]
        self.m, self.feed = saved, None
        self.rapid(self.targets(self.axes))

    def f_corner(self):
        x, y = self.m["X"], self.m["Y"]
        self.feed_move({"X": x + 20, "Y": y})
        self.plain(self.rng.choice(["RND R2", "CHF 1", "RND R1.5 F100"]))
        self.feed_move({"Y": y + 25})
        self.feed_move({"X": x})

    def datum(self, name):
        """CYCL DEF 247."""
        self.wcs = name
        number = name.split()[1]
        kind = self.rng.randrange(3)
        if kind == 0:
            self.plain("CYCL DEF 247 DATUM SETTING Q339=%s" % number)
        else:
            self.lines += ["%d CYCL DEF 247 DATUM SETTING ~" % self.n, "  Q339=+%s ;DATUM NUMBER" % number]
            self.n += 1

    def f_offset(self):
        self.datum(self.rng.choice([n for n in self.case["offsets"] if " " in n and n not in self.case["unstated"]]))
        if self.rng.random() < 0.5:
            self.restate()
        else:
            self.feed_move(self.targets(self.axes))

    def r_unstated_offset(self):
        self.datum(self.case["unstated"][0])
        self.feed_move(self.targets(self.rng.sample(self.linear, 2)))
        self.recover()

    def f_long_line(self):
        self.lines.append("%d L X%s ; %s" % (self.n, self.number(5.0 / self.length_scale()), "L" * 200))
        self.n += 1
        self.m["X"] = round(5.0 / self.length_scale(), self.places()) * self.length_scale() + self.offset("X")

    def tcp_on(self):
        rng = self.rng
        number = rng.choice(sorted(self.case["lengths"]))
        self.plain("TOOL CALL %d Z S2000" % int(number))
        self.length = self.length_of(number)
        self.restate()
        kind = rng.random()
        self.tcp = True
        if kind < 0.4:
            self.plain("FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS")
            self.rapid(self.targets(self.axes))
            return "FUNCTION RESET TCPM"
        if kind < 0.7:
            self.block(["L"] + self.go(self.targets(self.axes), True) + ["R0 FMAX M128"])
        else:
            self.plain("M128")
            self.m.update(X=None, Y=None, Z=None)
            self.rapid(self.targets(rng.sample(self.linear, 2)))
        return "M129"

    def vector_on(self, at):
        rng = self.rng
        number = rng.choice(sorted(self.case["lengths"]))
        self.plain("TOOL CALL %d Z S2000" % int(number))
        self.length = self.length_of(number)
        self.restate()
        self.tcp = True
        if rng.random() < 0.5:
            self.plain("FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS")
            self.rapid(dict(self.targets(self.linear), **at))
            return "FUNCTION RESET TCPM"
        self.block(["L"] + self.go(dict(self.targets(self.linear), **at), True) + ["R0 FMAX M128"])
        return "M129"

    def vector_move(self, targets, vector, is_rapid):
        normal = ["N%s%+.4f" % (a, v) for a, v in zip("XYZ", self.normal(self.at_home()))] if vector and self.rng.random() < 0.5 else []
        self.block(["LN" if vector else "L"] + self.go(targets, True) + normal + vector + (["FMAX"] if is_rapid else [self.feed_word()]))

    def at_home(self):
        return {a: 0.0 for a in self.rotary}

    def frame_on(self):
        rng = self.rng
        kind = rng.random()
        if kind < 0.5:
            self.plain("CYCL DEF 10.0 ROTATION")
            self.plain("CYCL DEF 10.1 ROT" + self.number(rng.choice([30.0, -12.5, 90.0]), 3))
            return ["CYCL DEF 10.0 ROTATION", "CYCL DEF 10.1 ROT+0"]
        if kind < 0.75:
            self.plain("CYCL DEF 8.0 MIRROR IMAGE")
            self.plain("CYCL DEF 8.1 " + rng.choice(["X", "Y", "X Y"]))
            return ["CYCL DEF 8.0 MIRROR IMAGE", "CYCL DEF 8.1"]
        self.plain("CYCL DEF 11.0 SCALING")
        self.plain("CYCL DEF 11.1 SCL 0.985")
        return ["CYCL DEF 11.0 SCALING", "CYCL DEF 11.1 SCL 1"]

    def plane_xy(self):
        pass

    def tilt_on(self, at, tilting):
        rng = self.rng
        number = rng.choice(sorted(self.case["lengths"]))
        self.plain("TOOL CALL %d Z S2000" % int(number))
        self.length = self.length_of(number)
        self.restate()
        kind = rng.random()
        if kind < 0.7:
            self.rapid(at)
        z = self.normal(at)
        b, c = math.degrees(math.acos(max(-1.0, min(1.0, z[2])))), math.degrees(math.atan2(z[1], z[0]))
        angles = [("%+.4f" % v).replace("-0.0000", "+0.0000") for v in (0.0, b, c)]
        if kind < 0.6:
            how = rng.choice(["TURN FMAX", "STAY", "TURN FMAX SEQ%s" % ("+" if at[tilting] > 0 else "-"), "MOVE DIST50 F500"])
            self.plain("PLANE SPATIAL SPA%s SPB%s SPC%s %s" % tuple(angles + [how]))
            ends = ["PLANE RESET STAY"]
        else:
            self.plain("CYCL DEF 19.0 WORKING PLANE")
            self.plain("CYCL DEF 19.1 A%s B%s C%s" % tuple(angles))
            words = {"A": "A+Q120", "B": "B+Q121", "C": "C+Q122"}
            if kind < 0.7:
                self.rapid(at)
            else:
                self.plain("L %s R0 FMAX" % " ".join(words[a] for a in self.rotary))
            ends = ["CYCL DEF 19.0 WORKING PLANE", "CYCL DEF 19.1"] if rng.random() < 0.5 else ["PLANE RESET STAY"]
        self.tcp = True
        return ends

    def called_cycle(self):
        rng, scale = self.rng, self.length_scale()
        clearance, depth = 2.0, rng.choice([5.0, 12.5, 40.0])
        surface, second = round(rng.uniform(-30, 40), 2), rng.choice([2.0, 50.0])
        self.lines += ["%d CYCL DEF %d DRILLING ~" % (self.n, rng.choice([200, 201, 203, 205, 207])),
                       " Q200=%s ;SET-UP CLEARANCE ~" % self.number(clearance / scale),
                       " Q201=%s ;DEPTH ~" % self.number(-depth / scale), " Q203=%s ;SURFACE ~" % self.number(surface / scale),
                       " Q204=%s ;2ND CLEARANCE" % self.number(second / scale)]
        self.n += 1
        if rng.random() < 0.2:
            self.rapid(self.targets(["X", "Y"]))
            self.plain(rng.choice(["CYCL CALL", "CYCL CALL M3"]))
        for _ in range(rng.randrange(1, 5)):
            self.block(["L"] + self.go(self.targets(rng.choice([["X"], ["Y"], ["X", "Y"]])), True) + ["R0 FMAX M99"])
        self.m["Z"] = None
        self.rapid(self.targets(self.linear))
        self.f_lines()

    def f_expression(self):
        """L X+Q5: a variable that the program has set, as a number or by FN 1."""
        rng = self.rng
        for _ in range(rng.randrange(1, 3)):
            axis, number = rng.choice(self.linear), rng.randrange(1, 40)
            want = round((rng_value(rng, *RANGE[axis]) - self.offset(axis)) / self.scale(axis), 3)
            self.plain("Q%d = %+.3f" % (number, want))
            sign = rng.choice(["+", "+", "-"])
            self.block(["L", "%s%sQ%d" % (axis, sign, number), self.compensation(), self.feed_word()])
            self.m[axis] = (want if sign == "+" else -want) * self.scale(axis) + self.offset(axis)
        self.f_lines()

    def f_approach(self):
        """APPR and DEP: the control comes to the contour and leaves it by a line or an arc that touches it."""
        rng = self.rng
        if self.case.get("orientation"):
            return
        number = rng.choice(sorted(self.case["radii"]))
        self.plain("TOOL CALL %d Z S2000" % int(number))
        self.length = self.length_of(number)
        self.restate()
        self.rapid(self.targets(self.linear))
        side, radius = rng.choice([1, -1]), self.case["radii"][number]
        low = max(6.0, 1.5 * radius)
        heading = rng.uniform(0, 2 * math.pi)

        def ahead(length):
            return {"X": self.m["X"] + length * math.cos(heading), "Y": self.m["Y"] + length * math.sin(heading)}
        s = self.length_scale()
        size = round(rng.choice([3.0, 12.0]) + radius, 2)
        how = rng.choice(["LT", "LN", "CT", "LCT"])
        more = {"LT": "LEN%s" % self.plain_number(size / s), "LN": "LEN%s" % self.plain_number(size / s),
                "CT": "CCA%d R%s" % (rng.choice([90, 180, 45]), self.number(size / s)), "LCT": "R%s" % self.number(size / s).lstrip("+")}[how]
        self.block(["APPR", how] + self.go(ahead(rng.uniform(3 * size + 20, 80)), True) + [more, "RL" if side > 0 else "RR", "F300"])
        for _ in range(rng.randrange(1, 5)):
            heading += rng.choice([0.0, rng.uniform(-1.2, 1.2), math.pi / 2, -math.pi / 2])
            self.feed_move_plain(ahead(rng.uniform(2 * low + 10, 60)))
        out = rng.choice(["LT", "LN", "CT", "LCT"])
        if out == "LCT":
            heading += rng.uniform(-1, 1)
            self.block(["DEP", "LCT"] + self.go(ahead(3 * size + 30), True) + ["R%s" % self.number(size / s).lstrip("+"), "F500"])
        else:
            self.block(["DEP", out, "CCA%d R%s" % (rng.choice([90, 180]), self.number(size / s)) if out == "CT" else
                        "LEN%s" % self.plain_number(size / s)])
            self.m.update(X=None, Y=None)
        self.feed = None
        self.restate()

    def plain_number(self, value):
        return self.number(value, 3).lstrip("+")

    def feed_move_plain(self, targets):
        self.block(["L"] + self.go(targets, True) + [self.feed_word()])

    def f_roll(self):
        """M126: rotary axes take the shorter way."""
        if "C" not in self.rotary:
            return
        self.feed_move({"C": self.rng.choice([300, 340, 10, 40])})
        self.plain("M126")
        for c in self.rng.sample([350, 10, 40, 300, 200], 3):
            self.feed_move(dict(self.targets(["X"]), C=c))
        self.plain("M127")
        self.feed_move(self.targets(self.axes))

    def recover(self):
        self.restate()
        self.f_lines()

    def r_tcp(self):
        if not self.rotary:
            return
        self.plain(self.rng.choice(["M128 F1000", "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS"]))
        tcpm = "FUNCTION" in self.lines[-1]
        for _ in range(2):
            self.feed_move(self.targets(self.axes))
        self.plain("FUNCTION RESET TCPM" if tcpm else "M129")
        self.feed_move(self.targets(["X"]))
        self.recover()

    def r_tilt(self):
        if not self.rotary:
            return
        self.plain("PLANE SPATIAL SPA+0 SPB+30 SPC+0 " + self.rng.choice(["STAY", "TURN FMAX"]))
        for _ in range(2):
            self.feed_move(self.targets(self.rng.sample(self.linear, 2)))
        self.plain("PLANE RESET " + self.rng.choice(["STAY", "TURN FMAX", "MOVE DIST50 F500"]))
        self.recover()

    def r_rotation(self):
        rng = self.rng
        self.plain("CYCL DEF 10.0 ROTATION")
        self.plain("CYCL DEF 10.1 ROT+30")
        for _ in range(2):
            self.feed_move(self.targets(rng.sample(self.linear, 2)))
        if rng.random() < 0.6:
            self.plain("PLANE RESET STAY")
        else:
            self.plain("CYCL DEF 10.0 ROTATION")
            self.plain("CYCL DEF 10.1 ROT+0")
        self.recover()

    def r_mode(self):
        on, off = self.rng.choice([(["CYCL DEF 7.0 DATUM SHIFT", "CYCL DEF 7.1 X+10"], ["CYCL DEF 7.0 DATUM SHIFT", "CYCL DEF 7.1 X+0"]),
                                   (["CYCL DEF 8.0 MIRROR IMAGE", "CYCL DEF 8.1 X"], ["CYCL DEF 8.0 MIRROR IMAGE", "CYCL DEF 8.1"]),
                                   (["CYCL DEF 11.0 SCALING", "CYCL DEF 11.1 SCL 0.99"], ["CYCL DEF 11.0 SCALING", "CYCL DEF 11.1 SCL 1"]),
                                   (["TRANS DATUM AXIS X+10"], ["TRANS DATUM RESET"]),
                                   (["M114"], ["M115"])])
        for line in on:
            self.plain(line)
        self.feed_move(self.targets(["X", "Y"]))
        for line in off:
            self.plain(line)
        self.recover()

    def r_cycle(self):
        self.lines += ["%d CYCL DEF 200 DRILLING ~" % self.n, " Q200=2 ;SET-UP CLEARANCE ~", " Q201=-20 ;DEPTH"]
        self.n += 1
        call = self.rng.choice(["CYCL CALL M3", "M99", "CYCL CALL POS X+10 Y+10 Z+0 FMAX"])
        if call == "M99":
            self.block(["L"] + self.go(self.targets(["X", "Y"]), True) + ["R0 FMAX M99"])
        else:
            self.plain(call)
        self.feed_move(self.targets([self.rng.choice("XY")]))
        self.recover()

    def r_pattern(self):
        """Cycles that run where they are defined."""
        self.lines += ["%d CYCL DEF 200 DRILLING ~" % self.n, " Q200=2 ~", " Q201=-20"]
        self.lines.append("%d CYCL DEF 221 CARTESIAN PATTERN ~" % (self.n + 1))
        self.lines += [" Q225=+10 ~", " Q226=+15 ~", " Q237=+10"]
        self.n += 2
        self.rapid(self.targets([self.rng.choice("XYZ")]))
        self.recover()

    def r_call(self):
        rng = self.rng
        self.sub_number += 1
        label = self.sub_number % 90 + 1
        lines, self.lines, m = self.lines, [], dict(self.m)
        if rng.random() < 0.5:
            self.f_lines()
        else:
            self.incremental = True
            self.feed_move({"X": self.m["X"] + 5})
            self.f_arc()
            self.incremental = False
        self.tail += ["LBL %d" % label] + self.lines + ["LBL 0"]
        self.lines, self.m = lines, m
        self.plain("CALL LBL %d" % label)
        self.recover()

    def subprogram(self, number, body):
        return ["LBL %d" % (number % 500 + 1)] + body + ["LBL 0"]

    def call(self, number, repeats):
        return "CALL LBL %d" % (number % 500 + 1)

    def f_shift(self):
        """CYCL DEF 7: axes that are not named keep their shift."""
        rng = self.rng
        for _ in range(rng.randrange(1, 3)):
            values = {a: round(rng.uniform(-20, 20), 2) for a in rng.sample(self.linear, rng.randrange(1, 4))}
            self.plain("CYCL DEF 7.0 DATUM SHIFT")
            for i, (axis, value) in enumerate(values.items()):
                text = self.number(value / self.scale(axis), 3)
                self.plain("CYCL DEF 7.%d %s%s" % (i + 1, axis, text))
                self.trans[axis] = float(text) * self.scale(axis)
            if rng.random() < 0.5:
                self.restate()
            else:
                self.feed_move(self.targets(self.axes))
            self.f_lines()
        self.plain("CYCL DEF 7.0 DATUM SHIFT")
        for i, axis in enumerate(self.linear):
            self.plain("CYCL DEF 7.%d %s+0" % (i + 1, axis))
            self.trans[axis] = 0.0
        self.feed_move(self.targets(self.axes))

    def f_section(self):
        """A part that runs again: CALL LBL REP."""
        self.sub_number += 1
        self.plain("LBL %d" % (self.sub_number % 500 + 1))
        self.lines += self.body()
        self.plain("CALL LBL %d REP %s" % (self.sub_number % 500 + 1, self.rng.choice(["1", "1/1", "2"])))
        self.restate()

    def r_macro(self):
        self.plain("Q1 = +%d" % self.rng.randrange(1, 40))
        self.plain("L X+Q1 F500")
        self.feed_move(self.targets(["Y"]))
        self.recover()

    def r_unknown_m(self):
        self.plain("L M%d" % self.rng.choice([60, 123, 71, 94]))
        (self.rapid if self.rng.random() < 0.5 else self.feed_move)(self.targets([self.rng.choice("XY")]))
        self.recover()

    def r_passed_arc(self):
        rng = self.rng
        self.feed_move(self.targets(["X", "Y"]))
        x, y = self.m["X"] - self.offset("X"), self.m["Y"] - self.offset("Y")
        s = self.length_scale()
        kind = rng.randrange(3)
        if kind == 0:
            self.plain("CC X%s Y%s" % (self.number((x + 50) / s), self.number(y / s)))
            self.plain("FN 9: IF +1 EQU +2 GOTO LBL 5" if False else "CALL LBL 99")
            self.tail += ["LBL 99", "L M8", "LBL 0"]
            self.plain("C X%s Y%s DR- F400" % (self.number(x / s), self.number(y / s)))
        elif kind == 1:
            self.plain("CC X%s Y%s" % (self.number((x + 50) / s), self.number(y / s)))
            self.plain("CP IPA+360 DR+")
        else:
            self.plain("CYCL DEF 10.0 ROTATION")
            self.plain("CYCL DEF 10.1 ROT+15")
            self.plain("CR X%s Y%s R%s DR+ F300" % (self.number((x + 100) / s), self.number(y / s), self.number(50.01 / s)))
            self.plain("CYCL DEF 10.0 ROTATION")
            self.plain("CYCL DEF 10.1 ROT+0")
        self.recover()

    def r_polar(self):
        x, y = self.m["X"] - self.offset("X"), self.m["Y"] - self.offset("Y")
        s = self.length_scale()
        self.plain("CC X%s Y%s" % (self.number(x / s), self.number(y / s)))
        self.plain("LP PR+10 PA+30 F500")
        self.recover()

    def begin(self):
        self.n = 0
        self.inch = self.case["unit"] == "inch"
        self.name = "PART%d" % self.rng.randrange(100)
        self.plain("BEGIN PGM %s %s" % (self.name, "INCH" if self.inch else "MM"))
        if self.rng.random() < 0.4:
            self.plain("BLK FORM 0.1 Z X+0 Y+0 Z-20")
            self.plain("BLK FORM 0.2 X+100 Y+100 Z+0")
        if self.rng.random() < 0.5:
            self.f_tool_change()
        else:
            self.restate()

    def r_program_call(self):
        self.plain(self.rng.choice(["CALL PGM SUB1", "CYCL DEF 12.0 PGM CALL"]))
        if "12.0" in self.lines[-1]:
            self.plain("CYCL DEF 12.1 PGM SUB1")
            self.plain("CYCL CALL")
        self.feed_move(self.targets([self.rng.choice("XY")]))
        self.recover()

    def end(self):
        self.plain(self.rng.choice(["M30", "L M30", "M2"]))
        for line in self.tail:
            if line.startswith("LBL"):
                self.plain(line)
            else:
                self.lines.append("%d %s" % (self.n, line.split(" ", 1)[1] if line[0].isdigit() else line))
                self.n += 1
        self.plain("END PGM %s %s" % (self.name, "INCH" if self.inch else "MM"))


def draw(seed, dialects=tuple(DIALECTS), without=(), with_known=()):
    """A case: all that one run needs, as plain data."""
    rng = random.Random(seed)
    dialect = rng.choice(list(dialects))
    name = rng.choice(list(MACHINES))
    description = MACHINES[name]
    axes = list(description["axes"])
    linear = [a for a in axes if a in "XYZ"]

    def offsets():
        return {a: round(rng.uniform(-80, 80), 3) if a in linear else rng.choice([0.0, 0.0, round(rng.uniform(-20, 20), 3)]) for a in axes}
    names = {"fanuc": ["G54", "G55", "G59", "G54.1 P5"], "mazak": ["G54", "G56", "G54.1 P12"],
             "haas": ["G54", "G57", "G110", "G154 P3"], "linuxcnc": ["G54", "G58", "G59.2"],
             "sinumerik": ["G500", "G54", "G57", "G505"], "heidenhain": ["PRESET", "PRESET 2", "PRESET 11"]}[dialect]
    unstated = {"fanuc": "G58", "mazak": "G58", "haas": "G59", "linuxcnc": "G59.1", "sinumerik": "G56",
                "heidenhain": "PRESET 5"}.get(dialect)
    names = names + ([unstated] if unstated else [])
    case = {
        "seed": seed, "dialect": dialect, "machine": name, "features": [], "mixed": rng.random() < 0.4,
        "without": list(without), "with": list(with_known),
        "errors": draw_errors(rng, description), "tip": [0.0, 0.0, round(-rng.uniform(100, 300), 2)],
        "offsets": {n: offsets() if n != "G500" else {} for n in names},
        "lengths": {str(n): round(rng.uniform(20, 120), 3) for n in (1, 2, 7)},
        "radii": {"1": rng.choice([0.0, 2.0, 5.0, 10.0, 31.5]), "7": round(rng.uniform(0.5, 8.0), 3)},
        "start": {a: round(rng.uniform(*RANGE[a]), 3) for a in axes},
        "unit": rng.choice(["mm", "mm", "mm", "inch"]), "states_unit": rng.random() < 0.93,
        "block_delete": rng.choice(["either", "either", "executed", "skipped"]),
        "unstated": [unstated] if unstated else [],
        "tolerance_um": rng.choice([1.0, 1.0, 3.0, 10.0]),
        "decimals": rng.choice([None, None, 3, 5]),
        "unit_option": rng.random() < 0.6,
        "start_option": rng.random() < 0.15,
        "cycle_tolerance_um": rng.choice([None, 50.0, 50.0]),
        "orientation": len(axes) > 3 and rng.random() < 0.15,
    }
    if dialect in ("fanuc", "mazak", "haas") and rng.random() < 0.1:
        case.update(decimals=3, increment=0.001, unit="mm")
    if "orientation" in without:
        case["orientation"] = False
    if "C" in axes:
        case["roll_over"] = rng.choice([None, "none", "none", "shortest", "shortest", "difference", "sign"])
        if case["roll_over"] == "sign":
            for table in case["offsets"].values():
                table["C"] = 0.0
    if rng.random() < 0.3:
        case["harmless"] = [71, 123]  # the builder says so
    if dialect == "sinumerik" and rng.random() < 0.5:
        case["edges"] = {"T%dD1" % n: round(rng.uniform(20, 120), 3) for n in (1, 2, 7)}
    if dialect in ("fanuc", "haas", "linuxcnc", "heidenhain") and rng.random() < 0.3:
        case["table"] = True  # the control's own table states lengths and radii
        case["features"].append("tool_table")
    if len(axes) > 3 and rng.random() < 0.4:
        case["keeps"] = [a for a in axes if a in "ABC" and rng.random() < 0.8]
    if "unstated-unit" in without:
        case["states_unit"] = True
    if "roll-over" in without:
        case["roll_over"] = "none"
    maker = KlartextProgram if dialect == "heidenhain" else Program
    writer = maker(rng, case)
    case["lines"] = writer.make()
    case["lathe"] = "lathe" in case["features"]
    return case


def samples(folder, dialects, with_known=()):
    """The checkout's programs (NAME.nc with its dialect in NAME.txt) on a machine that they know."""
    out = []
    for name in sorted(os.listdir(folder)):
        if not name.endswith(".txt"):
            continue
        with open(os.path.join(folder, name), encoding="utf-8", errors="replace") as file:
            words = file.readline().split()
        with open(os.path.join(folder, name[:-3] + "nc"), "rb") as file:
            program = file.read()
        if name[:-4] in KNOWN_SAMPLES and name[:-4] not in with_known:
            continue
        if words[0] not in dialects or "increments" in words or not program.isascii() or b"\0" in program:
            continue
        text = program.decode().replace("\r\n", "\n")
        out.append({
            "seed": name[:-4], "dialect": words[0], "machine": "head-table", "features": ["sample"], "mixed": True, "without": [],
            "errors": {"EB0B": 116.9, "EX0C": 30.0}, "tip": [0.0, 0.0, -356.3945],
            "offsets": {"PRESET": {}} if words[0] == "heidenhain" else {"G54": {}, "G55": {"X": 100.0, "B": 10.0}},
            "lengths": {"1": 10.0, "5": 10.0}, "start": {"X": 11.0, "Y": -7.0, "Z": 40.0, "B": 5.0, "C": 30.0}, "unit": "mm",
            "unit_option": True, "start_option": False, "orientation": False, "block_delete": "either", "tolerance_um": 5.0,
            "decimals": None, "unstated": [], "roll_over": "none", "lathe": False, "lines": text.rstrip("\n").split("\n")})
    return out
