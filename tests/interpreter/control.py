"""What every control has: positions, offsets, modes, and the trace of what it does. The dialects stand in iso.py and
klartext.py. Nothing here knows of the product: the rules are those of the controls' manuals.

A trace is a list of events:
  move   axes go from `start` to `end` (axis positions, mm and deg), straight or on a circle
  hole   a drilling cycle at `end`: `entry` and `bottom` are the axis positions between which the drill feeds; no other
         key of it says where
  raw    words that something else than a plain move takes (a cycle, a rotated frame, TCP): they must not change
  code   what else the block says (M, S, T, dwell ...)
"""
import math


class Alarm(Exception):
    """The control stops with an alarm."""


class Event:
    __slots__ = ("frame", "kind", "line", "number", "key", "start", "end", "arc", "rapid", "words", "minutes", "opaque",
                 "unsure_before", "unsure", "length", "named", "corner", "entry", "bottom")

    def __init__(self, kind, line, number, key=None):
        self.kind, self.line, self.number, self.key = kind, line, number, key
        self.arc = self.minutes = self.frame = None
        self.rapid = self.corner = False
        self.words = ()
        self.length = 0.0

    def at(self, t):
        """Axis positions at the fraction t of the move."""
        s, e = self.start, self.end
        if self.frame and t not in (0.0, 1.0):  # the words go along a line, not the axes
            s, e = self.frame.to_words(s, self.length), self.frame.to_words(e, self.length)
            return self.frame.to_axes({a: s[a] + t * (e[a] - s[a]) for a in s}, self.length)
        p = {a: s[a] + t * (e[a] - s[a]) for a in s}
        if self.arc:
            first, second, centre, angle, sweep, r0, r1 = self.arc
            r = r0 + t * (r1 - r0)
            p[first] = centre[0] + r * math.cos(angle + t * sweep)
            p[second] = centre[1] + r * math.sin(angle + t * sweep)
        return p


class Control:
    """`setup`: what only the shop floor knows.
      start     axis positions when the program starts
      offsets   work offset -> axis -> value, by the name that programs use
      lengths   number -> tool length, mm
      rollover  axis -> how an axis that counts from 0 to 360 deg reaches an absolute position: "shortest" way, by the
                word's "sign", or by the "difference" of both positions, never across 0
      unit      "mm" or "inch" when the program does not say
      skip      the block-delete switch is on
      increment None, or mm per count of a word without a point
      harmless  M codes that the machine's builder says move nothing
    """
    arc_tolerance_mm = 0.02
    max_line = None

    def __init__(self, axes, linear, setup):
        self.axes, self.linear, self.setup = axes, linear, setup
        self.pos = dict(setup["start"])
        self.opaque = set()      # stands where somebody else moved it
        self.unsure = set(axes)  # stands where no word in work coordinates sent it
        self.lost = 0
        self.inch = setup.get("unit") == "inch"
        self.incremental = False
        self.wcs = None
        self.preset = {a: 0.0 for a in axes}
        self.shift = {a: 0.0 for a in axes}
        self.trans = {a: 0.0 for a in axes}  # TRANS, CYCL DEF 7
        self.length = 0.0
        self.length_number = None
        self.feed = 0.0
        self.feed_mode = 94
        self.foreign = set()
        self.frame = setup.get("frame")
        self.tcp = False
        self.rollover = dict(setup.get("rollover", {}))
        self.trace = []
        self.line = 0
        self.number = None
        self.steps = 0

    # -- coordinates
    def unit(self, axis):
        return 25.4 if self.inch and axis in self.linear else 1.0

    def length_unit(self):
        return 25.4 if self.inch else 1.0

    def offset(self, axis):
        value = self.setup["offsets"].get(self.wcs, {}).get(axis, 0.0) if self.wcs else 0.0
        value += self.preset[axis] + self.shift[axis] + self.trans[axis]
        if axis == "Z" and not self.tcp:  # in the workpiece's frame words say where the tool point is
            value += self.length
        return value

    # -- the frame in which words of linear axes stand: axis positions, or under tool centre point control the workpiece
    def begin_tcp(self, named=(), by_length=False):
        """`by_length`: the tool length begins or changes here, and may move the tool along itself."""
        self.foreign.discard("tcp")
        rotary = [a for a in self.axes if a not in self.linear]
        if not rotary or not self.length or any(self.offset(a) for a in rotary) or any(self.preset.values()) or \
                any(self.shift.values()) or any(self.trans.values()):
            self.tcp = False
            return self.enter("tcp")  # which frame that is, nobody said
        self.tcp = True
        if self.opaque:
            self.opaque |= set(self.linear)
        if self.unsure & set(self.axes):
            self.unsure |= set(self.linear)
        if by_length:
            upright = self.frame.is_upright(self.pos)
            self.lose([a for a in (("Z",) if upright else self.linear) if a not in named])
        return None

    def end_tcp(self, named=(), by_length=False):
        if self.tcp:
            self.tcp = False
            if self.opaque:
                self.opaque |= set(self.linear)
            if self.unsure:
                self.unsure |= set(self.linear)
            if by_length:
                self.lose([a for a in self.linear if a not in named])

    def lose_tcp(self):
        """Whether it goes on is not known."""
        if self.tcp:
            self.end_tcp()
            self.enter("tcp")

    def target(self, axis, value, incremental):
        """Where a word of the axis leads from where it stands."""
        value *= self.unit(axis)
        if incremental:
            return self.pos[axis] + value
        goal = value + self.offset(axis)
        if self.rollover.get(axis) == "shortest":
            travel = math.fmod(goal - self.pos[axis], 360.0)
            if travel > 180.0:
                travel -= 360.0
            elif travel < -180.0:
                travel += 360.0
            return self.pos[axis] + travel
        if self.rollover.get(axis) == "difference":
            return self.pos[axis] + goal % 360.0 - self.pos[axis] % 360.0
        if self.rollover.get(axis) == "sign":  # of the word; its size is the position
            goal = abs(value) + self.offset(axis)
            if math.copysign(1.0, value) > 0:
                return self.pos[axis] + (goal - self.pos[axis]) % 360.0
            return self.pos[axis] - (self.pos[axis] - goal) % 360.0
        return goal

    def lose(self, axes):
        """Somebody else moves these axes: where to, only the builder knows."""
        self.lost += 1
        if self.setup.get("still"):  # a control without a machine: nobody moves
            return
        if self.tcp and axes:  # what moves one axis moves the tool point along all words
            self.opaque |= set(self.linear)
        for axis in axes:
            self.pos[axis] = 3000.0 + 100.0 * "XYZABCUVW".index(axis) + 7.0 * self.lost
            self.opaque.add(axis)

    def enter(self, mode):
        self.foreign.add(mode)

    def leave(self, mode):
        """Axis positions behind a mode that turns or bends coordinates are not followed here."""
        if mode in self.foreign:
            self.foreign.discard(mode)
            self.lose(self.linear)

    # -- events
    def emit(self, kind, key=None):
        event = Event(kind, self.line, self.number, key)
        self.trace.append(event)
        return event

    def code(self, *key):
        self.emit("code", key)

    def move(self, words, rapid=False, arc=None, raw=()):
        """`words`: axis -> (value, incremental)."""
        event = self.emit("move")
        event.start = dict(self.pos)
        event.unsure_before = self.opaque | self.unsure
        frame = self.frame if self.tcp else None
        event.frame = frame
        place = frame.to_words(self.pos, self.length) if frame else None
        for axis, (value, incremental) in words.items():
            if frame and axis in self.linear:
                value *= self.unit(axis)
                place[axis] = place[axis] + value if incremental else value + self.offset(axis)
            else:
                self.pos[axis] = self.target(axis, value, incremental)
                if frame:
                    place[axis] = self.pos[axis]
            if not incremental:
                self.opaque.discard(axis)
                self.unsure.discard(axis)
        if frame:
            self.pos.update(frame.to_axes(place, self.length))
        event.end = dict(self.pos)
        event.opaque = set(self.opaque)
        event.unsure = self.opaque | self.unsure
        event.rapid = rapid
        event.words = (tuple(sorted((a, round(v, 9), i) for a, (v, i) in words.items())),) + raw
        event.named = set(words)
        event.length = self.length
        if arc:
            event.arc = self.circle(event, *arc)
        event.minutes = None if rapid else self.minutes(event)
        return event

    def hole(self, key, words, raw, entry, bottom, level):
        """At the X and Y of `words`: heights are axis positions of Z; it stands at `level` behind it (None: nobody knows)."""
        event = self.emit("hole", key)
        event.start = dict(self.pos)
        event.unsure_before = self.opaque | self.unsure
        for axis, (value, incremental) in words.items():
            self.pos[axis] = self.target(axis, value, incremental)
            if not incremental:
                self.opaque.discard(axis)
                self.unsure.discard(axis)
        event.entry, event.bottom = dict(self.pos, Z=entry), dict(self.pos, Z=bottom)
        event.opaque, event.unsure = self.opaque - {"Z"}, (self.opaque | self.unsure) - {"Z"}
        event.words = raw
        event.length = self.length
        if level is not None:
            self.pos["Z"] = level
        event.end = dict(self.pos)
        return event

    def minutes(self, event):
        if self.feed_mode == 93:
            if self.feed <= 0:
                raise Alarm("inverse time without F")
            return 1.0 / self.feed
        return None

    def path_length(self, event):
        d2 = sum((event.end[a] - event.start[a]) ** 2 for a in self.linear)
        if event.arc:
            first, second, _, _, sweep, r0, _ = event.arc
            d2 -= (event.end[first] - event.start[first]) ** 2 + (event.end[second] - event.start[second]) ** 2
            d2 += (r0 * sweep) ** 2
        return math.sqrt(max(d2, 0.0))

    def circle(self, event, first, second, centre, clockwise, turns=1):
        """`centre` in axis positions, or a radius (signed: negative is more than half a turn)."""
        s = (event.start[first], event.start[second])
        e = (event.end[first], event.end[second])
        if not isinstance(centre, tuple):
            radius = centre
            dx, dy = e[0] - s[0], e[1] - s[1]
            d = math.hypot(dx, dy)
            if d < 1e-9:
                raise Alarm("radius with the end at the start")
            if d / 2 > abs(radius) + self.arc_tolerance_mm:
                raise Alarm("radius too small")
            h = math.sqrt(max(radius * radius - d * d / 4, 0.0))
            left = 1.0 if (radius > 0) != clockwise else -1.0
            centre = ((s[0] + e[0]) / 2 - left * h * dy / d, (s[1] + e[1]) / 2 + left * h * dx / d)
        r0, r1 = math.dist(s, centre), math.dist(e, centre)
        if r0 < 1e-6:
            raise Alarm("circle without radius")
        self.check_radii(r0, r1)
        a0 = math.atan2(s[1] - centre[1], s[0] - centre[0])
        a1 = math.atan2(e[1] - centre[1], e[0] - centre[0])
        sweep = a1 - a0
        full = self.full_circle_mm
        if clockwise:
            while sweep >= -1e-12:
                sweep -= 2 * math.pi
        else:
            while sweep <= 1e-12:
                sweep += 2 * math.pi
        if math.dist(s, e) <= full and abs(sweep) < 0.1:
            sweep = math.copysign(2 * math.pi, sweep)
        return (first, second, centre, a0, sweep, r0, r1)

    full_circle_mm = 1e-7

    def check_radii(self, r0, r1):
        if abs(r0 - r1) > self.arc_tolerance_mm:
            raise Alarm("radius %.4f at the start, %.4f at the end" % (r0, r1))

    def tick(self):
        self.steps += 1
        if self.steps > 20000:
            raise Alarm("does not end")


class Frame:
    """The workpiece's frame of tool centre point control: where the nominal tool point stands as the table sees it, from
    where it is at home without a tool. With all rotary axes at zero that is the axes' positions, but for the length."""

    def __init__(self, machine):
        self.machine = machine

    def place(self, axes, length):
        tip, _ = self.machine.tip(axes, length)
        return [t - g for t, g in zip(tip, self.machine.tip_mm)]

    def to_words(self, axes, length):
        return dict(axes, **dict(zip("XYZ", self.place(axes, length))))

    def to_axes(self, words, length):
        """The tool point is linear in the linear axes."""
        zero = self.place(dict(words, X=0.0, Y=0.0, Z=0.0), length)
        columns = []
        for axis in "XYZ":
            p = self.place(dict(words, **dict({"X": 0.0, "Y": 0.0, "Z": 0.0}, **{axis: 1.0})), length)
            columns.append([v - z for v, z in zip(p, zero)])
        want = [words[a] - z for a, z in zip("XYZ", zero)]

        def det(a, b, c):
            return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                    a[2] * (b[0] * c[1] - b[1] * c[0]))
        x, y, z = columns
        whole = det(x, y, z)
        return dict(words, X=det(want, y, z) / whole, Y=det(x, want, z) / whole, Z=det(x, y, want) / whole)

    def is_upright(self, axes):
        """Whether the axis Z, and a longer tool, move the tool point along the Z of the words alone, but for what a correction
        of the tool's direction turns it (0.05 deg at most)."""
        p = self.place(axes, 0.0)
        up, longer = self.place(dict(axes, Z=axes["Z"] + 1.0), 0.0), self.place(axes, 1.0)
        return all(abs(abs(a - b) - c) < 1e-3 for q in (up, longer) for a, b, c in zip(q, p, (0, 0, 1)))
