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
                 "unsure_before", "unsure", "length", "named", "corner", "entry", "bottom", "cut", "vector",
                 "callers", "feed", "is_made")

    def __init__(self, kind, line, number, key=None):
        self.kind, self.line, self.number, self.key = kind, line, number, key
        self.arc = self.minutes = self.frame = self.cut = self.vector = None
        self.rapid = self.corner = False
        self.feed = None  # where it is compared
        self.is_made = False  # begins or ends where the control makes a corner
        self.words = self.callers = ()
        self.length = 0.0

    def at(self, t):
        """Axis positions at the fraction t of the move."""
        s, e = self.start, self.end
        if self.frame and t in (0.0, 1.0):
            return dict(e if t else s)
        if self.frame:  # the words go along a line, not the axes
            s, e = self.frame.to_words(s, self.length), self.frame.to_words(e, self.length)
        p = {a: s[a] + t * (e[a] - s[a]) for a in s}
        if self.arc:
            first, second, centre, angle, sweep, r0, r1 = self.arc
            r = r0 + t * (r1 - r0)
            p[first] = centre[0] + r * math.cos(angle + t * sweep)
            p[second] = centre[1] + r * math.sin(angle + t * sweep)
        return self.frame.to_axes(p, self.length) if self.frame else p


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
      radii     number -> radius of a cutter, mm
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
        self.called_tool = self.spindle = None  # tools, as T words say them
        self.feed = 0.0
        self.feed_mode = 94
        self.foreign = set()
        self.frame = setup.get("frame")
        self.tcp = False
        self.states_vectors = False  # I, J and K say how the tool stands (G43.5)
        self.vector = None           # of the block: from the tool's tip to the spindle, as the table sees it
        # Words that are turned, mirrored, scaled: `inner`, in a tilted plane or over the axes. Each (3 x 3, shift), and
        # which mode it is. `origin_moves`: the work offset goes with the turned table.
        self.inner = self.slope = None
        self.inner_mode = self.slope_mode = None
        self.origin_moves = False
        self.frames_inside = False  # TRANS counts in the tilted plane
        # Cutter compensation: None or (side, radius), +1 with the tool left of the contour; and whether the move that leads
        # to the contour, or away from it, is still to come.
        self.cutter, self.cutter_state = None, "off"
        self.rollover = dict(setup.get("rollover", {}))
        self.trace = []
        self.callers = ()  # the lines of the calls that run
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
        if axis == "Z" and not self.tcp and not self.slope and not self.origin_moves:  # else words say where the tool point is
            value += self.length
        return value

    # -- the frame in which words of linear axes stand: axis positions, or under tool centre point control the workpiece
    def begin_tcp(self, named=(), by_length=False):
        """`by_length`: the tool length begins or changes here, and may move the tool along itself."""
        self.foreign.discard("tcp")
        rotary = [a for a in self.axes if a not in self.linear]
        if self.inner or self.slope or self.origin_moves or not rotary or not self.length or any(self.offset(a) for a in rotary) or any(self.preset.values()) or \
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

    def words_frame(self):
        """Where words of linear axes stand; None: over the axes."""
        if self.tcp:
            return self.frame
        if not self.inner and not self.slope and not self.origin_moves:
            return None
        shift = [self.trans[a] if self.frames_inside else 0.0 for a in "XYZ"]
        return Placed(self.frame, [self.offset(a) for a in "XYZ"], shift, self.slope, self.inner, self.origin_moves)

    def standing(self):
        """Where the axes stand, as words and the work offset say it."""
        frame = self.words_frame()
        return frame.to_words(self.pos, self.length) if frame else self.pos

    def turn(self, mode, matrix, at, adds=False):
        """A rotation, mirror or scale about `at`, or behind those in force. False: what it makes of them is not read."""
        if self.tcp or self.origin_moves or any(self.preset.values()) or (self.inner and self.inner_mode != mode):
            return False
        shift = [c - v for c, v in zip(at, times(matrix, at))]
        if adds and self.inner:
            shift = [s + v for s, v in zip(self.inner[1], times(self.inner[0], shift))]
            matrix = chain(self.inner[0], matrix)
        self.inner, self.inner_mode = (matrix, shift), mode
        return True

    def unturn(self, mode):
        if self.inner_mode == mode:
            self.inner = self.inner_mode = None

    def tilt(self, mode, matrix, at):
        if self.tcp or self.inner or (self.slope and self.slope_mode != mode) or self.origin_moves or any(self.preset.values()) or len(self.rotary()) != 2:
            return False
        self.slope, self.slope_mode = (matrix, at), mode
        return True

    def untilt(self, mode):
        if self.slope_mode == mode:
            self.slope = self.slope_mode = None

    # -- cutter compensation, of the plane XY and a radius that is stated: words are those of the contour
    def cutter_on(self, side, number, plane_is_xy=True):
        radius = 0.0 if number == 0 else self.setup.get("radii", {}).get(number)
        turned = self.inner[0] if self.inner else None
        scaled = turned and (abs(math.hypot(turned[0][0], turned[1][0]) - 1.0) > 1e-9 or
                             turned[0][0] * turned[1][1] - turned[0][1] * turned[1][0] < 0 or abs(turned[2][2] - 1.0) > 1e-9)
        changes = self.cutter is not None and self.cutter != (side, radius)
        if radius is None or not plane_is_xy or scaled or self.tcp or changes or "comp" in self.foreign or self.cutter_state == "ending":
            self.cutter, self.cutter_state = None, "off"
            return self.enter("comp")
        self.cutter = (side, radius)
        if self.cutter_state == "off":
            self.cutter_state = "starting"
        return None

    def cutter_off(self):
        self.leave("comp")
        self.cutter = None
        self.cutter_state = "ending" if self.cutter_state in ("on", "ending") else "off"

    def cut(self, event):
        """What the move is to the contour: (part, side, radius), or None."""
        if self.cutter_state == "off":
            return None
        a, b = event.start, event.end
        if event.frame:
            a, b = (event.frame.to_words(p, event.length) for p in (a, b))
        if not event.arc and math.hypot(b["X"] - a["X"], b["Y"] - a["Y"]) < 1e-9:
            return ("held",) + (self.cutter or (0, 0.0))
        part = {"starting": "entry", "on": "piece", "ending": "exit"}[self.cutter_state]
        self.cutter_state = "off" if part == "exit" else "on"
        return (part,) + (self.cutter or (0, 0.0))

    def rotary(self):
        return [a for a in self.axes if a not in self.linear]

    def turn_to_plane(self, choose=None):
        """The control turns its rotary axes until the tool stands on the plane: by the shortest way of those that `choose`
        allows."""
        matrix, _ = self.slope
        ways = [w for w in self.frame.tool_along([-matrix[r][2] for r in range(3)]) if choose is None or choose(w)]
        if not ways:
            raise Alarm("the tool cannot stand on the plane")
        # All rotary axes of these machines go round without an end.
        for way in ways:
            for axis in way:
                turns = 360.0 * round((self.pos[axis] - way[axis]) / 360.0)
                way[axis] += turns
        way = min(ways, key=lambda w: sum(abs(w[a] - self.pos[a]) for a in w))
        self.pos.update(way)
        self.opaque -= set(way)
        self.unsure |= set(self.linear)

    def turn_to_vector(self):
        """The control turns its rotary axes until the tool stands along the vector: by the shortest way. It stays where it
        stands so already."""
        size = math.sqrt(sum(v * v for v in self.vector))
        if size < 1e-9:
            raise Alarm("the tool's vector is zero")
        direction = [-v / size for v in self.vector]
        now = self.frame.machine.tip(self.pos, 0.0)[1]
        if math.dist(now, direction) < 1e-8:
            return {}
        ways = self.frame.tool_along(direction)
        if not ways:
            raise Alarm("the tool cannot stand along the vector")
        for way in ways:
            for axis in way:
                way[axis] += 360.0 * round((self.pos[axis] - way[axis]) / 360.0)
        return min(ways, key=lambda w: sum(abs(w[a] - self.pos[a]) for a in w))

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
            travel = math.fmod(round(goal - self.pos[axis], 9), 360.0)
            if travel > 180.0:
                travel -= 360.0
            elif travel <= -180.0:  # half a turn goes one way, from whichever turn and on both sides of a rounding
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

    def lose_at_tool_change(self):
        """The tool changer leaves what the builder says."""
        keeps = self.setup.get("keeps", ())
        self.lose([axis for axis in self.axes if axis not in keeps])

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
        event.callers = self.callers
        self.trace.append(event)
        return event

    def code(self, *key):
        self.emit("code", key)

    def move(self, words, rapid=False, arc=None, raw=()):
        """`words`: axis -> (value, incremental)."""
        event = self.emit("move")
        event.start = dict(self.pos)
        event.unsure_before = self.opaque | self.unsure
        frame = self.words_frame()
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
        event.vector = self.vector
        if self.vector:
            raw += (tuple(round(v, 9) for v in self.vector),)
            for axis, value in self.turn_to_vector().items():
                self.pos[axis] = place[axis] = value
                if self.opaque & {axis}:
                    self.unsure |= set(self.linear)
        if frame and (self.tcp or set(words) & set(self.linear)):  # the others stand while a tilted table turns under them
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
        event.cut = self.cut(event)
        event.minutes = None if rapid else self.minutes(event)
        event.feed = None if rapid or self.feed_mode == 93 else self.compared_feed()
        return event

    def hole(self, key, words, raw, entry, bottom, level):
        """At the X and Y of `words`: heights are axis positions of Z; it stands at `level` behind it (None: nobody knows)."""
        event = self.emit("hole", key)
        event.start = dict(self.pos)
        event.unsure_before = self.opaque | self.unsure
        frame = self.words_frame()
        place = frame.to_words(self.pos, self.length) if frame else self.pos
        for axis, (value, incremental) in words.items():
            if frame:
                value *= self.unit(axis)
                place[axis] = place[axis] + value if incremental else value + self.offset(axis)
            else:
                self.pos[axis] = self.target(axis, value, incremental)
            if not incremental:
                self.opaque.discard(axis)
                self.unsure.discard(axis)

        def axes(height):
            p = dict(place, Z=height)
            return frame.to_axes(p, self.length) if frame else p
        event.frame = frame
        event.entry, event.bottom = axes(entry), axes(bottom)
        event.opaque, event.unsure = self.opaque - {"Z"}, (self.opaque | self.unsure) - {"Z"}
        event.words = raw
        event.length = self.length
        if level is not None:
            self.pos.update(axes(level))
        event.end = dict(self.pos)
        return event

    def minutes(self, event):
        if self.feed_mode == 93:
            if self.feed <= 0:
                raise Alarm("inverse time without F")
            return 1.0 / self.feed
        return None

    def compared_feed(self):
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
        start, end = event.start, event.end
        if event.frame:
            start, end = event.frame.to_words(start, self.length), event.frame.to_words(end, self.length)
        s = (start[first], start[second])
        e = (end[first], end[second])
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
        self.grid = None  # where the tool points, by places of the rotary axes

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

    def tool_along(self, direction):
        """All places of two rotary axes (deg) where the nominal tool points that way over the table."""
        rotary = self.machine.rotary

        def aim(a, b):
            return self.machine.tip(dict({x: 0.0 for x in self.machine.linear}, **{rotary[0]: a, rotary[1]: b}), 0.0)[1]
        if self.grid is None:
            self.grid = {(a, b): aim(a, b) for a in range(-180, 180, 10) for b in range(-180, 180, 10)}

        def off(a, b):
            return sum((x - y) ** 2 for x, y in zip(aim(a, b), direction))
        near = {place: sum((x - y) ** 2 for x, y in zip(at, direction)) for place, at in self.grid.items()}
        found = []
        for (a, b), value in sorted(near.items(), key=lambda item: item[1])[:40]:
            if value > 0.2:
                break
            for _ in range(60):  # steps of least squares
                at = aim(a, b)
                h = 1e-4
                one = [(x - y) / h for x, y in zip(aim(a + h, b), at)]
                two = [(x - y) / h for x, y in zip(aim(a, b + h), at)]
                want = [x - y for x, y in zip(direction, at)]
                p, q, r = sum(x * x for x in one), sum(x * y for x, y in zip(one, two)), sum(y * y for y in two)
                u, v = sum(x * y for x, y in zip(one, want)), sum(x * y for x, y in zip(two, want))
                p, r = p + 1e-12, r + 1e-12
                whole = p * r - q * q
                da, db = (u * r - v * q) / whole, (v * p - u * q) / whole
                size = max(abs(da), abs(db), 1e-9)
                da, db = (d * min(1.0, 20.0 / size) for d in (da, db))
                a, b = a + da, b + db
                if max(abs(da), abs(db)) < 1e-9:
                    break
            way = {rotary[0]: math.remainder(a, 360.0), rotary[1]: math.remainder(b, 360.0)}
            if off(a, b) < 1e-14 and all(any(abs(math.remainder(way[x] - w[x], 360.0)) > 1e-4 for x in rotary) for w in found):
                found.append(way)
        return found


def times(matrix, vector):
    return [sum(m * v for m, v in zip(row, vector)) for row in matrix]


def chain(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(3)) for c in range(3)] for r in range(3)]


def inverse(m):
    (a, b, c), (d, e, f), (g, h, i) = m
    whole = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return [[(e * i - f * h) / whole, (c * h - b * i) / whole, (b * f - c * e) / whole],
            [(f * g - d * i) / whole, (a * i - c * g) / whole, (c * d - a * f) / whole],
            [(d * h - e * g) / whole, (b * g - a * h) / whole, (a * e - b * d) / whole]]


def about(axis, degrees):
    """A rotation about X, Y or Z."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return {"X": [[1, 0, 0], [0, c, -s], [0, s, c]], "Y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "Z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}[axis]


def along(x=1.0, y=1.0, z=1.0):
    return [[x, 0, 0], [0, y, 0], [0, 0, z]]


class Placed:
    """Words that a tilted plane and what turns words in it place: over the axes, or over the workpiece (`Frame`). Places are
    words and the work offset, as Control keeps positions."""

    def __init__(self, frame, offset, shift, plane, inner, origin_moves):
        self.frame, self.offset, self.origin_moves, self.is_tilted = frame, offset, origin_moves, plane is not None
        self.matrix, zero = inner or (along(), [0.0] * 3)
        zero = [z + s for z, s in zip(zero, shift)]
        if plane:
            self.matrix = chain(plane[0], self.matrix)
            zero = [z + p for z, p in zip(times(plane[0], zero), plane[1])]
        # base of a word of 0
        self.zero = [o - s + z for o, s, z in zip(offset, shift, zero)]
        self.back = inverse(self.matrix)

    def to_axes(self, place, length):
        word = [place[a] - o for a, o in zip("XYZ", self.offset)]
        if self.origin_moves:
            origin = self.frame.to_axes(dict(place, **dict(zip("XYZ", self.offset))), length)
            return dict(place, **{a: origin[a] + w for a, w in zip("XYZ", word)})
        base = dict(place, **{a: z + v for a, z, v in zip("XYZ", self.zero, times(self.matrix, word))})
        return self.frame.to_axes(base, length) if self.is_tilted else base

    def to_words(self, axes, length):
        if self.origin_moves:
            origin = self.frame.to_axes(dict(axes, **dict(zip("XYZ", self.offset))), length)
            return dict(axes, **{a: axes[a] - origin[a] + o for a, o in zip("XYZ", self.offset)})
        base = self.frame.to_words(axes, length) if self.is_tilted else axes
        word = times(self.back, [base[a] - z for a, z in zip("XYZ", self.zero)])
        return dict(axes, **{a: w + o for a, w, o in zip("XYZ", word, self.offset)})
