"""A machine with errors, from the words of docs/formats.md and docs/architecture.md alone.

Two branches of joints start at the bed. Joint i is E_i J_i(q_i): its error, then its motion. The tool branch ends with
E_T, the work branch with E_W. At home all frames are the machine frame. mm, and degrees for rotary axes where a
position is given; errors.json is in um and urad.
"""
import math


def identity():
    return [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]  # rows of (R | t)


def product(a, b):
    out = []
    for r in (0, 4, 8):
        x, y, z, t = a[r:r + 4]
        out += [x * b[0] + y * b[4] + z * b[8], x * b[1] + y * b[5] + z * b[9], x * b[2] + y * b[6] + z * b[10],
                x * b[3] + y * b[7] + z * b[11] + t]
    return out


def apply(a, p):
    return [a[r] * p[0] + a[r + 1] * p[1] + a[r + 2] * p[2] + a[r + 3] for r in (0, 4, 8)]


def turned(a, v):
    return [a[r] * v[0] + a[r + 1] * v[1] + a[r + 2] * v[2] for r in (0, 4, 8)]


def apply_inverse(a, p):
    d = [p[0] - a[3], p[1] - a[7], p[2] - a[11]]
    return [a[c] * d[0] + a[c + 4] * d[1] + a[c + 8] * d[2] for c in (0, 1, 2)]


def about(rotation9, point):
    """The turn about a point: (R | p - R p)."""
    out = []
    for i in range(3):
        row = rotation9[3 * i:3 * i + 3]
        out += row + [point[i] - (row[0] * point[0] + row[1] * point[1] + row[2] * point[2])]
    return out


def rotation(direction, angle):
    x, y, z = direction
    c, s = math.cos(angle), math.sin(angle)
    k = 1.0 - c
    return [c + x * x * k, x * y * k - z * s, x * z * k + y * s,
            y * x * k + z * s, c + y * y * k, y * z * k - x * s,
            z * x * k - y * s, z * y * k + x * s, c + z * z * k]


class Joint:
    def __init__(self, name, axis):
        self.name = name
        self.is_rotary = axis is not None and axis["kind"] == "rotary"
        self.direction = axis["direction"] if axis else None
        self.point = axis.get("point_mm", [0, 0, 0]) if self.is_rotary else [0.0, 0.0, 0.0]
        self.errors = []  # (component 0..5, function of the positions), mm or rad

    def error(self, positions):
        values = [0.0] * 6
        for component, value in self.errors:
            values[component] += value(positions)
        x, y, z, a, b, c = values
        if a or b or c:
            turn = rotation((1, 0, 0), a)
            for direction, angle in (((0, 1, 0), b), ((0, 0, 1), c)):
                if angle:
                    turn = [v for i, v in enumerate(product(about(turn, (0, 0, 0)),
                                                            about(rotation(direction, angle), (0, 0, 0)))) if i % 4 != 3]
            out = about(turn, self.point)
        else:
            out = identity()
        out[3] += x
        out[7] += y
        out[11] += z
        return out

    def motion(self, positions):
        q = positions[self.name]
        if self.is_rotary:
            return about(rotation(self.direction, math.radians(q)), self.point)
        out = identity()
        out[3], out[7], out[11] = (d * q for d in self.direction)
        return out


def shape(entry, is_angle, axes):
    """The error of one entry of errors.json as a function of the positions, mm or rad."""
    amplitude = entry["amplitude"] * (1e-6 if is_angle else 1e-3)
    name = entry.get("variable") or entry["symbol"][2:]
    is_rotary = axes[name]["kind"] == "rotary"

    def q(positions):
        return math.radians(positions[name]) if is_rotary else positions[name]
    kind = entry["shape"]
    if kind == "linear":  # per metre or per radian
        return lambda p: amplitude * q(p) / (1.0 if is_rotary else 1000.0)
    if kind == "quadratic":  # at 250 mm or 1 rad
        return lambda p: amplitude * (q(p) / (1.0 if is_rotary else 250.0)) ** 2
    if kind == "harmonic":  # amplitude cos(order q - phase)
        phase = math.radians(entry["phase_deg"])
        order = entry["order"] if is_rotary else 2 * math.pi / entry["period_mm"]
        return lambda p: amplitude * math.cos(order * q(p) - phase)
    raise ValueError("shape " + kind)


class Machine:
    """`tip_mm`: the nominal tool point at home, machine frame."""

    def __init__(self, description, errors, tip_mm):
        self.axes = description["axes"]
        self.names = [n for n in "XYZABCUVW" if n in self.axes]
        self.linear = [n for n in self.names if self.axes[n]["kind"] == "linear"]
        self.rotary = [n for n in self.names if self.axes[n]["kind"] == "rotary"]
        self.tool = [Joint(n, self.axes[n]) for n in description["tool_branch"]] + [Joint("T", None)]
        self.work = [Joint(n, self.axes[n]) for n in description["work_branch"]] + [Joint("W", None)]
        self.tip_mm = tip_mm
        self.tool_direction = description["tool_direction"]
        joints = {j.name: j for j in self.tool + self.work}
        entries = [({"symbol": s, "shape": "constant", "amplitude": v}) for s, v in errors.items() if s != "terms"]
        for entry in entries + errors.get("terms", []):
            symbol = entry["symbol"]
            component = "XYZABC".index(symbol[1])
            if entry["shape"] == "constant":
                value = entry["amplitude"] * (1e-6 if component > 2 else 1e-3)
                joints[symbol[3:]].errors.append((component, lambda p, v=value: v))
            else:
                joints[symbol[2:]].errors.append((component, shape(entry, component > 2, self.axes)))

    def nearest_to_tool(self):
        """The rotary axis that stands nearest to the tool; of axes of the table alone, the first of them."""
        names = [j.name for j in self.work if j.is_rotary][::-1] + [j.name for j in self.tool if j.is_rotary]
        return names[-1]

    def tip(self, positions, length_mm=0.0, with_errors=False):
        """The tool point as the table sees it, and the tool's direction there."""
        ends = []
        for branch in (self.tool, self.work):
            bed = identity()
            for joint in branch:
                if with_errors and joint.errors:
                    bed = product(bed, joint.error(positions))
                if joint.direction is not None:
                    bed = product(bed, joint.motion(positions))
            ends.append(bed)
        tip = [self.tip_mm[i] + length_mm * self.tool_direction[i] for i in range(3)]
        point = apply_inverse(ends[1], apply(ends[0], tip))
        direction = turned(ends[0], self.tool_direction)
        work = ends[1]
        return point, [work[c] * direction[0] + work[c + 4] * direction[1] + work[c + 8] * direction[2]
                       for c in (0, 1, 2)]
