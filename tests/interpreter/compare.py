"""Two traces side by side: does the machine with errors, commanded by the output, do what the nominal machine does
when commanded by the source? See README.md for the rules."""
import math

from kinematics import Machine  # noqa: F401  (the type of `machine` below)


class Limits:
    def __init__(self, end_mm, path_mm, gross_mm=0.5, gross_deg=1e-6, rounding_deg=0.6e-4):
        self.end_mm, self.path_mm, self.gross_mm, self.gross_deg = end_mm, path_mm, gross_mm, gross_deg
        self.rounding_deg = rounding_deg
        self.lean_mm = 0.0  # what the report says is left at the bottom of holes
        self.contour_mm = 0.0  # and along contours under cutter compensation
        self.tilt_rad = None  # where rotary axes are corrected too: how far the tool's direction may be off


class Difference(Exception):
    def __init__(self, text, source=None, output=()):
        super().__init__(text)
        self.text, self.source, self.output = text, source, list(output)


def gross(a, b, machine):
    """The largest difference of axis positions, rotary axes in mm of 1000 mm radius per 57 deg (deg x 17)."""
    worst = 0.0
    for axis, value in a.items():
        d = value - b[axis]  # of rotary axes but for whole turns (Comparison.turn_to)
        d = abs(d) if axis in machine.linear else 17.0 * abs(math.remainder(d, 360.0))
        worst = max(worst, d)
    return worst


def group(moves, others, machine):
    """For each source move the pieces that it became: the cheapest way to cut `others` into len(moves) runs. And what it
    costs: how far apart the ends are, mm, with 20 for each word that does not fit."""
    n, m = len(moves), len(others)
    if m < n:
        raise Difference("%d moves became %d" % (n, m), moves[0] if moves else None, others[:1])
    if n == 0:
        if m:
            raise Difference("a move where the source has none", None, others)
        return [], 0.0
    def apart(s, o):
        """Where the piece ends the move, the tool is right, or the axes stand as in the source."""
        axes = gross(s.end, o.end, machine)
        if axes > 1.0 or axes < 1e-4:
            return min(axes, 50.0)
        return min(axes, math.dist(machine.tip(s.end, s.length)[0], machine.tip(o.end, o.length, True)[0]))
    end = [[apart(s, o) for o in others] for s in moves]
    first = [[0.0 if s.number == o.number and set(s.words[0] and [w[0] for w in s.words[0]] or ()) <= o.named else 20.0
              for o in others] for s in moves]
    # No straight move became an arc, no rapid a feed move. (A full circle ends where the block that brings the axes back in
    # front of it does, and an arc's first piece may be a straight one of some micrometres.)
    bent = [[20.0 if o.arc is not None and s.arc is None or o.rapid != s.rapid else 0.0 for o in others] for s in moves]
    later = [0.0 if o.number is None else 20.0 for o in others]
    arcs = [0]  # among the first others
    for o in others:
        arcs.append(arcs[-1] + (o.arc is not None))
    inf = float("inf")
    cost = [0.0] + [inf] * m
    back = []
    for i in range(n):
        new, origin = [inf] * (m + 1), [0] * (m + 1)
        is_long = moves[i].arc is not None and abs(moves[i].arc[4]) * moves[i].arc[5] > 0.1
        for j in range(i, m):
            if cost[j] == inf:
                continue
            run = cost[j] + first[i][j] + bent[i][j]
            for k in range(j + 1, m - (n - i - 1) + 1):
                if k > j + 1:
                    run += later[k - 1] + bent[i][k - 1] + 0.001
                # An arc stays one, in some of its pieces at least: a block that brings the axes back is none. (One of a tenth of
                # a millimetre may become straight, and a full circle become chords, which cost less than an end a millimetre off.)
                is_straightened = is_long and arcs[k] == arcs[j]
                c = run + end[i][k - 1] + (1.0 if is_straightened else 0.0)
                if c < new[k]:
                    new[k], origin[k] = c, j
        back.append(origin)
        cost = new
    cuts, k = [], m
    for i in range(n - 1, -1, -1):
        cuts.append((back[i][k], k))
        k = back[i][k]
    return [others[a:b] for a, b in reversed(cuts)], cost[m]


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def unit(a):
    length = math.sqrt(dot(a, a))
    return tuple(v / length for v in a)


def angle(a, b):
    c = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    return math.atan2(math.sqrt(dot(c, c)), dot(a, b))


def words_of(event, t):
    at = event.at(t)
    return event.frame.to_words(at, event.length) if event.frame else at


def axes_of(event, words):
    return event.frame.to_axes(words, event.length) if event.frame else words


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


def tangent(event, t):
    """The direction in X and Y of a move's words."""
    if event.arc:
        angle, sense = event.arc[3] + t * event.arc[4], math.copysign(1.0, event.arc[4])
        return (-sense * math.sin(angle), sense * math.cos(angle))
    a, b = words_of(event, 0.0), words_of(event, 1.0)
    d = (b["X"] - a["X"], b["Y"] - a["Y"])
    length = math.hypot(*d)
    return (d[0] / length, d[1] / length) if length > 1e-9 else None


def corner_takes(a, b, side, radius):
    """How much of straight moves an inner corner between them takes of the offset path."""
    if a.arc or b.arc:
        return 0.0
    u, v = tangent(a, 1.0), tangent(b, 0.0)
    turn = math.atan2(cross(u, v), u[0] * v[0] + u[1] * v[1])
    return radius * math.tan(min(abs(turn), 3.1) / 2) if side * turn > 0 else 0.0


def room(pair, side, radius):
    """What the corners leave of the first of two moves; of arcs it is not asked here."""
    (a, taken), (b, _) = pair[0], pair[1]
    if a.arc:
        return 1.0
    p, q = words_of(a, 0.0), words_of(a, 1.0)
    return math.hypot(q["X"] - p["X"], q["Y"] - p["Y"]) - taken - corner_takes(a, b, side, radius)


class Comparison:
    """`passed`: lines that the report lists as not corrected. `strict`: such a line must be listed."""

    def __init__(self, machine, limits, passed, strict, not_turned=()):
        self.machine, self.limits, self.passed, self.strict = machine, limits, passed, strict
        self.corrected = self.unchanged = self.holes = self.contour_moves = self.vector_moves = 0
        self.corner = None  # the last pieces of a contour, of source and output
        self.worst_end = self.worst_path = 0.0
        self.is_corrected = False  # the position before the present move
        self.not_turned = not_turned
        self.place = None  # where the nominal machine stands
        self.brought_back = 0
        self.has_preset = False

    def run(self, source, output):
        i = j = 0
        while True:
            a, b = [], []
            while i < len(source) and source[i].kind == "move":
                a.append(source[i])
                i += 1
            while j < len(output) and output[j].kind == "move":
                b.append(output[j])
                j += 1
            s = source[i] if i < len(source) else None
            o = output[j] if j < len(output) else None
            if not a and self.is_back(b):
                self.brought_back += 1
                self.is_corrected, b = False, []
            if len(a) > len(b) or (not a and b):
                raise Difference("%d moves became %d" % (len(a), len(b)), a[0] if a else s, b or ([o] if o else []))
            self.unwrap(a)
            self.unwrap(b)
            for move, pieces in zip(a, self.group(a, b)):
                self.check(move, pieces)
            if s is None and o is None:
                return
            if s is None or o is None or s.kind != o.kind or not same(s.key, o.key):
                raise Difference("other words than moves differ: %s, now %s" % (s and s.key, o and o.key), s,
                                 [o] if o else [])
            if s.kind == "hole":
                self.check_hole(s, o)
            self.has_preset |= s.kind == "raw" and s.key[0] == "G92"
            i += 1
            j += 1

    def group(self, moves, others):
        if len(others) == len(moves):
            return [[o] for o in others]
        runs, cost = group(moves, others, self.machine)
        if moves and self.is_back(others[-1:], moves[-1].end):  # or a move as short as a correction is long
            before_back, cost_before = group(moves, others[:-1], self.machine)
            if cost_before < cost:
                return before_back[:-1] + [before_back[-1] + others[-1:]]
        return runs

    def unwrap(self, moves):
        """An axis that counts from 0 again behind each block goes on where the block before ended."""
        for axis in self.machine.rotary:
            for before, move in zip(moves, moves[1:]):
                turns = 360.0 * round((before.end[axis] - move.start[axis]) / 360.0)
                if turns and before.end[axis] != move.start[axis]:
                    move.start = dict(move.start, **{axis: move.start[axis] + turns})
                    move.end = dict(move.end, **{axis: move.end[axis] + turns})

    def is_back(self, moves, position=None):
        """Blocks that bring the axes from a corrected position back to the programmed one, in front of a passed block."""
        position = position or self.place
        if not moves or position is None:
            return False
        start, end = moves[0].start, moves[-1].end
        # G92 took its coordinates from where the control stood, which was the corrected position.
        near = self.limits.gross_mm if self.has_preset else 1.3 * self.limits.end_mm
        def off(axis):
            """Half a turn from where nobody knows may have gone the other way round: whole turns do not count (turn_to)."""
            d = end[axis] - position[axis]
            return abs(math.remainder(d, 360.0) if axis in self.machine.rotary else d)
        # An axis that somebody else has moved since stays where it is.
        return (all(start[a] == end[a] or off(a) <= near and abs(start[a] - end[a]) <= self.limits.gross_mm for a in end) and any(start[a] != end[a] for a in end) and
                all(m.number is None and m.arc is None for m in moves))

    def turn_to(self, place, pieces):
        """C=DC(10) may leave an axis that counts from 0 again whole turns from where the source's word leaves it. The end
        of the block before was compared: what follows is told by its travel."""
        for axis in self.machine.rotary:
            turns = 360.0 * round((pieces[0].start[axis] - place[axis]) / 360.0)
            for piece in pieces if turns else ():
                piece.start, piece.end = dict(piece.start), dict(piece.end)
                piece.start[axis] -= turns
                piece.end[axis] -= turns

    def check(self, s, pieces):
        machine, limits = self.machine, self.limits
        self.place = s.end
        self.turn_to(s.start, pieces)
        if len(pieces) > 1 and self.is_back(pieces[-1:], s.end) and not self.is_right_at_end(s, pieces[-1]):
            self.brought_back += 1
            self.check(s, pieces[:-1])
            self.is_corrected = False
            return
        # A block that was passed may have named some of the axes alone, so that others still stand corrected behind it.
        is_away = any(abs(pieces[0].start[a] - s.start[a]) > limits.end_mm for a in machine.linear)
        is_away |= pieces[0].rapid != s.rapid  # however short: a way back at feed
        if len(pieces) > 1 and self.is_back(pieces[:1], s.start) and (self.is_corrected or is_away):
            self.brought_back += 1
            self.is_corrected = False
            pieces = pieces[1:]
        last = pieces[-1]
        # Behind a passed move a block may lead to where the next one, an arc or a corner, is corrected.
        if len(pieces) == 2 and last.number is None and last.arc is None and self.is_same(s, pieces[0]) and all(
                abs(last.end[a] - last.start[a]) <= limits.gross_mm for a in last.end) and not self.is_right_at_end(s, pieces[0]):
            self.check(s, pieces[:1])
            self.is_corrected = self.is_right_at_end(s, last)
            return
        for at, a, b in (("start", s.start, pieces[0].start), ("end", s.end, last.end)):
            for axis in a:
                limit = limits.gross_mm if axis in machine.linear else limits.gross_deg
                off = a[axis] - b[axis]
                if axis in machine.rotary and axis in s.unsure_before:  # which way round it turned, nobody knows
                    off = math.remainder(off, 360.0)
                if abs(off) > limit:
                    raise Difference("%s of the move: %s stands at %.4f, commanded by the source at %.4f" %
                                     (at, axis, b[axis], a[axis]), s, pieces)
        if s.minutes is not None:
            if any(p.minutes is None for p in pieces):
                raise Difference("another feed mode", s, pieces)
            now = sum(p.minutes for p in pieces)
            if abs(now - s.minutes) > 0.001 + 0.05 * s.minutes:
                raise Difference("the move takes %.5f min, in the source %.5f" % (now, s.minutes), s, pieces)
        if s.feed is not None and any(p.feed is not None and abs(p.feed - s.feed) > 1e-6 for p in pieces):
            raise Difference("feed %s, in the source %s" % ([p.feed for p in pieces], s.feed), s, pieces)
        # Corners that are no moves of their own (corners.py); one of RNDM may say so itself.
        is_own = isinstance(s.corner, tuple) and s.corner[4]
        for p in pieces:
            if isinstance(p.corner, tuple) and not (p is last and isinstance(s.corner, tuple) and same(p.corner[:4], s.corner[:4])):
                raise Difference("another corner: %s, in the source %s" % (p.corner, s.corner), s, pieces)
        if is_own and not isinstance(last.corner, tuple):
            raise Difference("the corner %s is lost" % (s.corner,), s, pieces)
        if any(p.rapid != s.rapid for p in pieces):
            raise Difference("rapid or feed differs", s, pieces)
        was_corrected = self.is_corrected
        problem = None
        if s.opaque:
            problem = "an axis stands where nobody knows (%s)" % " ".join(sorted(s.opaque))
        else:
            problem = self.problem(s, pieces, was_corrected)
        self.is_corrected = problem is None or (self.is_right_at_end(s, last) and not s.opaque)
        if problem is None:
            self.corrected += 1
            self.vector_moves += s.vector is not None
            return
        same_words = len(pieces) == 1 and self.is_same(s, last)
        if same_words and s.arc:
            same_words = (abs(s.arc[4] - pieces[0].arc[4]) < 0.05 + 0.5 / s.arc[5] if pieces[0].arc else False)
            problem = problem if same_words else "the arc sweeps %.4f rad, in the source %.4f" % (
                pieces[0].arc[4] if pieces[0].arc else 0.0, s.arc[4])
        if not same_words:
            raise Difference(problem, s, pieces)
        if self.strict and not self.is_listed(s) and not (s.unsure and self.passed and min(self.passed) < s.line):
            raise Difference("not corrected, and the report does not list it: " + problem, s, pieces)
        self.unchanged += 1

    def is_same(self, s, piece):
        return same(s.words, piece.words) or s.is_made and self.is_same_way(s, piece)

    def is_same_way(self, s, piece):
        """Beside a corner that is a move of its own the words say where that begins: what counts is where they lead, or by how
        much."""
        def leads_there(ways):
            return any(all(abs(x - y) < 1e-6 for x, y in way) for way in ways)
        if any(not leads_there([[(s.end[a], piece.end[a])], [(s.end[a] - s.start[a], piece.end[a] - piece.start[a])]])
               for a in s.named | piece.named) or (s.arc is None) != (piece.arc is None):
            return False
        if s.arc is None:
            return True
        def from_start(e):
            return [c - e.start[a] for c, a in zip(e.arc[2], e.arc[:2])]
        return s.arc[:2] == piece.arc[:2] and leads_there([zip(s.arc[2], piece.arc[2]), zip(from_start(s), from_start(piece))])

    def is_listed(self, s):
        """A call that is listed stands for what it runs."""
        return bool(self.passed & {s.line, *s.callers})

    def check_hole(self, s, o):
        """The tool is right where the drill goes in, and as deep as programmed; how far it leans between, the report says."""
        machine, limits = self.machine, self.limits
        self.place = s.end
        self.is_corrected = False
        for at, a, b in (("entry", s.entry, o.entry), ("bottom", s.bottom, o.bottom), ("end", s.end, o.end)):
            for axis in a:
                off = a[axis] - b[axis]
                if axis in machine.rotary:  # whole turns do not count
                    off = math.remainder(off, 360.0)
                if abs(off) > (limits.gross_mm if axis in machine.linear else limits.gross_deg):
                    raise Difference("%s of the hole: %s stands at %.4f, commanded by the source at %.4f" %
                                     (at, axis, b[axis], a[axis]), s, [o])
        problem = None
        if s.opaque:
            problem = "an axis stands where nobody knows (%s)" % " ".join(sorted(s.opaque))
        else:
            want = [machine.tip(p, s.length)[0] for p in (s.entry, s.bottom)]
            have = [machine.tip(p, o.length, True)[0] for p in (o.entry, o.bottom)]
            along = sub(want[1], want[0])
            length = math.sqrt(dot(along, along))
            left = sub(have[1], want[1])
            depth = dot(left, along) / length
            lean = math.sqrt(max(dot(left, left) - depth * depth, 0.0))
            if s.key[0] == "called":  # its heights are no words of the hole
                over = sub(have[0], want[0])
                height = dot(over, along) / length
                aside = math.sqrt(max(dot(over, over) - height * height, 0.0))
                most = max(math.sqrt(dot(over, over)), math.sqrt(dot(left, left)))
                if most > limits.lean_mm + limits.end_mm:
                    problem = "the hole is %.5f mm off, and %.5f are reported" % (most, limits.lean_mm)
                elif s.key[1] == "POS" and abs(depth) > limits.end_mm + 1e-3 * lean:  # its Z is a word of the block
                    problem = "the hole is %.5f mm too deep" % depth
                elif s.words and aside > limits.end_mm + 1e-3 * abs(height):
                    problem = "the drill is %.5f mm off where it goes in" % aside
            elif math.dist(want[0], have[0]) > limits.end_mm:
                problem = "the drill is %.5f mm off where it goes in" % math.dist(want[0], have[0])
            elif abs(depth) > limits.end_mm + 1e-3 * lean:
                problem = "the hole is %.5f mm too deep" % depth
            elif lean > limits.lean_mm + limits.end_mm:
                problem = "the hole is %.5f mm off at its bottom, and %.5f are reported" % (lean, limits.lean_mm)
        if problem is None:
            self.holes += 1
            return
        # Holes of patterns may have words of their own.
        if not same(s.words, o.words) and any(abs(s.entry[a] - o.entry[a]) > 1e-6 for a in "XY"):
            raise Difference(problem, s, [o])
        if self.strict and not self.is_listed(s):
            raise Difference("not corrected, and the report does not list it: " + problem, s, [o])
        self.unchanged += 1

    def left(self, s):
        """What may be left at the end of a move, since it gets no words of X and Y."""
        return self.limits.contour_mm if s.cut and s.cut[0] == "held" else 0.0

    def is_right_at_end(self, s, last):
        want, _ = self.machine.tip(s.end, s.length)
        have, _ = self.machine.tip(last.end, last.length, True)
        return math.dist(want, have) <= (self.limits.path_mm if last.is_made else self.limits.end_mm) + self.left(s)

    def contour_problem(self, s, pieces):
        """Cutter compensation: the control leads the tool's centre a radius beside the contour of the words. Is the tool of
        the machine with errors right across the contour and along the tool, to what is reported? Does the control go round
        the corners as it did?"""
        machine, limits = self.machine, self.limits
        part, side, radius = s.cut
        if any(p.cut is None or p.cut[1:] != s.cut[1:] for p in pieces):
            return "another cutter compensation"
        if part == "held":
            for p in pieces:
                a, b = words_of(p, 0.0), words_of(p, 1.0)
                if math.hypot(b["X"] - a["X"], b["Y"] - a["Y"]) > 1e-7:
                    return "a move along Z alone became one of X and Y: the control offsets that"
            return None
        if [p.cut[0] for p in pieces] != [part] * len(pieces):
            return "another part of the contour"
        self.corner = None if part != "piece" else self.corner
        if part != "piece":
            return None
        t = 0.0
        for piece in pieces:
            end = 1.0 if piece is pieces[-1] else self.fraction(s, dict(piece.end), t)
            for k in range(7):
                u = k / 6.0
                at, along = words_of(s, t + u * (end - t)), tangent(s, t + u * (end - t))
                now, along_now = words_of(piece, u), tangent(piece, u)
                if along is None or along_now is None or abs(cross(along, along_now)) > 0.011 or along[0] * along_now[0] + along[1] * along_now[1] < 0:
                    return "the contour is turned, and the tool's centre with it"
                def centre_of(event, words, direction, more=0.0):
                    return axes_of(event, dict(words, X=words["X"] - side * (radius + more) * direction[1],
                                               Y=words["Y"] + side * (radius + more) * direction[0]))

                want, aim = machine.tip(centre_of(s, at, along), s.length)
                wall = unit(sub(machine.tip(centre_of(s, at, along, 1.0), s.length)[0], want))
                have = machine.tip(centre_of(piece, now, along_now), piece.length, True)[0]
                # Along the path of its centre the tool comes by: how far `t` is from its place does not count.
                h = 1e-5 if t + u * (end - t) < 0.5 else -1e-5
                later = t + u * (end - t) + h
                path = sub(machine.tip(centre_of(s, words_of(s, later), tangent(s, later)), s.length)[0], want)
                off = sub(have, want)
                if dot(path, path) > 1e-20:
                    path = unit(path)
                    off = sub(off, [dot(off, path) * v for v in path])
                across = dot(off, wall)
                high = math.sqrt(max(dot(off, off) - across * across, 0.0))
                most = limits.contour_mm + limits.end_mm
                if abs(across) > most or high > most:
                    return "the cutter is %.5f mm off across the contour, %.5f along the tool, and %.5f are reported" % (
                        across, high, limits.contour_mm)
            t = end
        now = [(s, 0.0)], [(p, 0.0) for p in pieces]
        if self.corner:
            rooms = [room(chain[-1:] + present, side, radius) for chain, present in zip(self.corner, now)]
            if (rooms[0] > 0) != (rooms[1] > 0):
                return "at the corner the tool has room of %.4f mm, in the source %.4f" % (rooms[1], rooms[0])
        else:
            rooms = (0.0, 0.0)
        taken = [corner_takes(c[-1][0], n[0][0], side, radius) if self.corner else 0.0 for c, n in
                 zip(self.corner or ([None], [None]), now)]
        self.corner = ([(s, taken[0])], [(pieces[-1], taken[1] if len(pieces) == 1 else 0.0)])
        self.contour_moves += 1
        return None

    def problem(self, s, pieces, start_is_corrected):
        machine, limits = self.machine, self.limits
        if abs(s.length - pieces[-1].length) > 1e-6:
            return "another tool length"
        want, aim = machine.tip(s.end, s.length)
        have, direction = machine.tip(pieces[-1].end, pieces[-1].length, True)
        off = math.dist(want, have)
        # A full circle ends where it began, wherever else its correction leads.
        is_full = s.arc is not None and abs(abs(s.arc[4]) - 2 * math.pi) < 1e-3
        # A corner that the control makes is part of the path.
        if off > (limits.path_mm if is_full or pieces[-1].is_made else limits.end_mm) + self.left(s):
            return "the tool is %.5f mm off at the end" % off
        self.worst_end = max(self.worst_end, off)
        if s.cut:
            text = self.contour_problem(s, pieces)
            if text or s.cut[0] != "piece":  # how the tool comes to a contour and leaves it, the control says
                return text
        more = limits.contour_mm if s.cut else 0.0  # a contour may begin behind a move along Z
        if limits.tilt_rad is not None and angle(aim, direction) > limits.tilt_rad and s.line not in self.not_turned:
            return "the tool leans by %.1f urad at the end" % (1e6 * angle(aim, direction))
        if s.rapid or s.unsure_before or not start_is_corrected:
            return None
        t = 0.0
        length = abs(s.arc[4]) * s.arc[5] if s.arc else math.dist(*[[p[a] for a in machine.linear] for p in (s.start, s.end)])
        # The correction at both ends: what it shifts a point on the way, to first order.
        shift = {a: (pieces[0].start[a] - s.start[a], pieces[-1].end[a] - s.end[a]) for a in machine.linear}
        mismatch = abs(s.arc[5] - s.arc[6]) if s.arc else 0.0
        if len(pieces) > 1 and (self.turns_by_axis(s) or limits.tilt_rad is not None):  # the rotary words of pieces are rounded, at 300 mm from the axis
            mismatch += math.radians(limits.rounding_deg) * 300.0
        for piece in pieces:
            count = 4
            if s.arc:
                count = max(3, math.ceil(abs(piece.arc[4]) / 0.5)) if piece.arc else 3
            for k in range(1, count + 1):
                c = piece.at(k / count)
                t_new = self.fraction(s, {a: v - (shift[a][0] + t * (shift[a][1] - shift[a][0]) if a in shift else 0.0)
                                          for a, v in c.items()}, t)
                have, direction = machine.tip(c, s.length, True)
                want, aim = machine.tip(s.at(t_new), s.length)
                slack = self.slack(s)
                t_low, t_high = max(0.0, t_new - slack), min(1.0, t_new + slack)
                if math.dist(want, have) > 0.3 * limits.path_mm:
                    for _ in range(2):
                        h = 1e-5 if t_new < 0.5 else -1e-5
                        ahead, _ = machine.tip(s.at(t_new + h), s.length)
                        slope = [v / h for v in sub(ahead, want)]
                        square = dot(slope, slope)
                        if square < 1e-18:
                            break
                        t_new = min(t_high, max(t_low, t_new + dot(sub(have, want), slope) / square))
                        want, aim = machine.tip(s.at(t_new), s.length)
                off = math.dist(want, have)
                if off > limits.path_mm + mismatch + more:
                    return "the tool is %.5f mm off on the way (at %.3f of the move)" % (off, t_new)
                self.worst_path = max(self.worst_path, off)
                if (t - t_new) * length > max(2 * limits.path_mm, 0.02 * length):
                    return "the tool goes back on the way (from %.4f to %.4f of the move)" % (t, t_new)
                t = t_new
        if s.arc and abs(t - 1.0) > 0.02 and abs(t - 1.0) * length > 0.002:
            return "the arc ends at %.4f of its sweep" % t
        return None

    def slack(self, s):
        """How far the fraction of the move may be off its first guess: where a rotary axis tells it, by its rounding."""
        travel = max((abs(s.end[a] - s.start[a]) for a in self.machine.rotary), default=0.0)
        if self.limits.tilt_rad is not None:
            return 0.3 / max(travel, 0.3)
        return self.limits.rounding_deg / travel if self.turns_by_axis(s) else 1.0

    def turns_by_axis(self, s):
        return max((abs(s.end[a] - s.start[a]) for a in self.machine.rotary), default=0.0) > 0.01

    def fraction(self, s, c, before):
        if self.turns_by_axis(s):
            axis = max(self.machine.rotary, key=lambda a: abs(s.end[a] - s.start[a]))
            return min(1.0, max(0.0, (c[axis] - s.start[axis]) / (s.end[axis] - s.start[axis])))
        if s.arc:
            first, second, centre, start, sweep, radius, _ = s.arc
            begin, end = s.start, s.end
            if s.frame:  # the circle is one of words
                begin, end, c = (s.frame.to_words(p, s.length) for p in (begin, end, c))
            along = max(self.machine.linear, key=lambda a: 0.0 if a in (first, second) else abs(end[a] - begin[a]))
            if along not in (first, second) and abs(end[along] - begin[along]) > radius * abs(sweep):
                return min(1.0, max(0.0, (c[along] - begin[along]) / (end[along] - begin[along])))
            turn = math.atan2(c[second] - centre[1], c[first] - centre[0]) - start
            t = turn / sweep
            step = 2 * math.pi / abs(sweep)
            if radius * abs(sweep) < self.limits.path_mm:  # what the correction differs by along it is many times its length
                return min(1.0, max(0.0, t))
            return t + step * round((before + 0.04 - t) / step) if step < 1e6 else t
        d = {a: s.end[a] - s.start[a] for a in self.machine.linear}
        square = sum(v * v for v in d.values())
        if square < 1e-12:
            return 1.0
        return min(1.0, max(0.0, sum((c[a] - s.start[a]) * d[a] for a in d) / square))


def same(a, b):
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b))
    if isinstance(a, float) or isinstance(b, float):
        return isinstance(a, (int, float)) and isinstance(b, (int, float)) and abs(a - b) < 1e-9
    return a == b
