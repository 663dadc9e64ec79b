"""LinuxCNC's own interpreter (rs274 of Debian's linuxcnc-uspace) as the judge from outside: where its canonical calls
send the axes."""
import os
import re
import shutil
import subprocess

from control import Event

AXES = "XYZABC"
BASES = {"G54": 5221, "G55": 5241, "G56": 5261, "G57": 5281, "G58": 5301, "G59": 5321, "G59.1": 5341, "G59.2": 5361,
         "G59.3": 5381}


class NotRead(Exception):
    """rs274's message and block."""


def is_there():
    return shutil.which("rs274") is not None


def places(case, text, folder, skip, probed=None):
    """[(axis positions, rapid, radians of the arc or 0)] of all moves. rs274 is a machine in inches whose axes start at 0. `probed`: a list to
    which the ends of probing moves are added."""
    values = {base + i: 0.0 for base in list(BASES.values()) + [5161, 5181, 5211] for i in range(10)}
    for n in (5210, 5219):
        values[n] = 0.0
    for name, axes in case["offsets"].items():
        for axis, value in axes.items():
            values[BASES[name] + AXES.index(axis)] = value / 25.4 if axis in "XYZ" else value
    values[5220] = 1.0
    with open(os.path.join(folder, "rs.var"), "w") as file:
        file.write("".join("%d\t%.10f\n" % item for item in sorted(values.items())))
    with open(os.path.join(folder, "tool.tbl"), "w") as file:
        for number, length in case["lengths"].items():
            file.write("T%s P%s Z%.10f\n" % (number, number, length / 25.4))
    name = os.path.join(folder, "rs.ngc")
    with open(name, "w") as file:
        file.write(text)
    # The strictest machine: the least that rs274 takes for these, in inch and mm.
    ini = os.path.join(folder, "rs.ini")
    with open(ini, "w") as file:
        file.write("[RS274NGC]\nCENTER_ARC_RADIUS_TOLERANCE_INCH = 0.00005\nCENTER_ARC_RADIUS_TOLERANCE_MM = 0.00127\n")
    done = subprocess.run(["rs274", "-g", "-i", ini] + (["-b"] if skip else []) +
                          ["-t", os.path.join(folder, "tool.tbl"), "-v", os.path.join(folder, "rs.var"), name],
                          capture_output=True, text=True, cwd=folder, timeout=60,
                          env=dict(os.environ, HOME=folder, TMPDIR=folder))
    out, scale = [], 25.4
    g5x, g92, tool = [0.0] * 6, [0.0] * 6, 0.0

    def machine(p):
        return {a: (p[i] + g5x[i] + g92[i] + (tool if i == 2 else 0.0)) * (scale if i < 3 else 1.0) for i, a in enumerate(AXES)}

    def convert(values, factor):
        return [v * factor if i < 3 else v for i, v in enumerate(values)]
    plane = "XY"
    at = None
    problem = []
    text = done.stdout + done.stderr
    for line in text.split("\n"):
        match = re.match(r"\s*\d+ N\S* +([A-Z_0-9]+)\((.*)\)", line)
        if not match:
            if line.strip() and line.strip() != "executing":
                problem.append(line.strip())
            continue
        call, inside = match.groups()
        if call in ("COMMENT", "MESSAGE"):
            continue
        numbers = [float(v) for v in re.findall(r"-?\d+\.?\d*(?:e[-+]\d+)?", inside)]
        if call == "USE_LENGTH_UNITS":
            new = 1.0 if "MM" in inside else 25.4
            g5x, g92 = convert(g5x, scale / new), convert(g92, scale / new)
            tool *= scale / new
            scale = new
        elif call == "SET_G5X_OFFSET":
            g5x = numbers[1:7]
        elif call == "SET_G92_OFFSET":
            g92 = numbers[:6]
        elif call == "USE_TOOL_LENGTH_OFFSET":
            tool = numbers[2]
        elif call == "SELECT_PLANE":
            plane = {"CANON_PLANE_XY": "XY", "CANON_PLANE_XZ": "ZX", "CANON_PLANE_YZ": "YZ"}[inside.strip()]
        elif call in ("STRAIGHT_FEED", "STRAIGHT_TRAVERSE"):
            at = machine(numbers[:6])
            out.append((at, call == "STRAIGHT_TRAVERSE", 0))
        elif call == "STRAIGHT_PROBE" and probed is not None:
            probed.append(machine(numbers[:6]))
        elif call == "ARC_FEED":
            end1, end2, c1, c2, turns, end3 = numbers[:6]
            p = dict(zip(AXES, [0.0] * 3 + numbers[6:9]))
            third = [a for a in "XYZ" if a not in plane][0]
            p[plane[0]], p[plane[1]], p[third] = end1, end2, end3
            at = machine([p[a] for a in AXES])
            centre = dict(zip(AXES, [0.0] * 6))
            centre[plane[0]], centre[plane[1]] = c1, c2
            centre = machine([centre[a] for a in AXES])
            out.append((at, False, (plane, centre[plane[0]], centre[plane[1]], turns)))
    if problem:
        raise NotRead("; ".join(problem)[:300])
    return out


def strokes(hole):
    """The moves of a cycle that drills in one stroke, as the manual of LinuxCNC lists them."""
    over = dict(hole.end, Z=max(hole.start["Z"], hole.entry["Z"]))
    ways = [(over, True), (hole.entry, True), (hole.bottom, False), (hole.end, hole.key[1] not in (84, 85, 89, 74))]
    parts = []
    for end, rapid in ways:
        part = Event("move", hole.line, hole.number)
        # Where Z began is not known to both of us before a word of it was read.
        is_level = end is over or (end is hole.end and hole.end["Z"] != hole.entry["Z"])
        part.start, part.end, part.arc, part.rapid = hole.start, end, None, rapid
        part.unsure = hole.unsure | (hole.unsure_before & {"Z"} if is_level else set())
        parts.append(part)
    return parts


def differences(trace, calls, axes, tolerance):
    """Where our trace of the moves differs from LinuxCNC's; None: nowhere. Moves of no length are left out."""
    ours = [part for e in trace for part in ([e] if e.kind == "move" else strokes(e) if e.kind == "hole" else [])]

    def moved(events, position, first):
        kept, last = [], None
        for e in events:
            p = position(e)
            if last is None or any(abs(p[a] - last[a]) > tolerance for a in axes) or first(e):
                kept.append(e)
                last = p
        return kept
    ours = moved(ours, lambda e: e.end, lambda e: e.arc is not None)
    theirs = moved(calls, lambda c: c[0], lambda c: c[2] != 0)
    for i in range(max(len(ours), len(theirs))):
        if i >= len(ours) or i >= len(theirs):
            return "our %d moves are %d of LinuxCNC" % (len(ours), len(theirs)), ours[-1] if ours else None
        e, (place, rapid, arc) = ours[i], theirs[i]
        known = [a for a in axes if a not in e.unsure]
        off = max([abs(e.end[a] - place[a]) for a in known] or [0.0])
        if off > tolerance:
            return "move %d ends %.5f off LinuxCNC's (%s)" % (i, off, place), e
        if rapid != e.rapid or (arc != 0) != (e.arc is not None):
            return "move %d is of another kind in LinuxCNC" % i, e
        if arc:
            first, second = e.arc[0], e.arc[1]
            if first + second != arc[0]:
                return "move %d is in another plane in LinuxCNC" % i, e
            if abs(e.arc[2][0] - arc[1]) > tolerance * 3 or abs(e.arc[2][1] - arc[2]) > tolerance * 3:
                return "move %d has its centre at %s in LinuxCNC, here %s" % (i, arc[1:3], e.arc[2]), e
            if (arc[3] > 0) != (e.arc[4] > 0):
                return "move %d turns the other way in LinuxCNC" % i, e
    return None
