"""Corners of Sinumerik (RND=, RNDM=, CHF=, CHR=): the control rounds or chamfers them in the working plane, between two feed
moves that do not leave it. Found step by step along both moves, where the product has formulas."""
import copy
import math


def travel(event, axes):
    return max((abs(event.end[a] - event.start[a]) for a in axes), default=0.0)


class Side:
    """One of both moves, by the length from the corner: `taken` mm of it away."""

    def __init__(self, event, first, second, is_end):
        self.event, self.first, self.second, self.is_end = event, first, second, is_end
        p, q = self.words(0.0), self.words(1.0)
        self.length = abs(event.arc[4]) * event.arc[5] if event.arc else math.hypot(q[first] - p[first], q[second] - p[second])

    def words(self, t):
        event = self.event
        place = event.at(t)
        return event.frame.to_words(place, event.length) if event.frame else place

    def fraction(self, taken):
        return 1.0 - taken / self.length if self.is_end else taken / self.length

    def at(self, taken):
        t = self.fraction(taken)
        event = self.event
        if event.arc:
            _, _, centre, angle, sweep, r0, r1 = event.arc
            r = r1 if self.is_end else r0
            a = angle + t * sweep
            return (centre[0] + r * math.cos(a), centre[1] + r * math.sin(a)), \
                (-math.copysign(math.sin(a), math.sin(a) * sweep), math.copysign(math.cos(a), math.cos(a) * sweep))
        p, q = self.words(0.0), self.words(1.0)
        d = (q[self.first] - p[self.first], q[self.second] - p[self.second])
        size = math.hypot(*d)
        return (p[self.first] + t * d[0], p[self.second] + t * d[1]), (d[0] / size, d[1] / size)


def turn_of(a, b):
    return math.atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1])


def touching(one, two, radius, side, guess):
    """How much of both moves an arc of that radius takes that touches them; None: it does not fit."""
    def apart(taken):
        (p, u), (q, v) = one.at(taken[0]), two.at(taken[1])
        return (p[0] - side * radius * u[1] - q[0] + side * radius * v[1], p[1] + side * radius * u[0] - q[1] - side * radius * v[0])
    taken = [guess, guess]
    for _ in range(100):
        off = apart(taken)
        h = 1e-6
        a = [(x - y) / h for x, y in zip(apart([taken[0] + h, taken[1]]), off)]
        b = [(x - y) / h for x, y in zip(apart([taken[0], taken[1] + h]), off)]
        whole = a[0] * b[1] - a[1] * b[0]
        if abs(whole) < 1e-12:
            return None
        step = [(off[0] * b[1] - off[1] * b[0]) / whole, (a[0] * off[1] - a[1] * off[0]) / whole]
        size = max(abs(s) for s in step)
        limit = 0.3 * (radius + guess)
        step = [s * min(1.0, limit / size) if size else 0.0 for s in step]
        taken = [t - s for t, s in zip(taken, step)]
    return taken if max(abs(v) for v in apart(taken)) < 1e-8 else None


def can_be(s, first, second, linear, axes):
    others = [a for a in axes if a not in (first, second)]
    return not s.rapid and s.minutes is None and not s.opaque and travel(s, others if not s.frame else []) < 1e-9 and \
        (not s.cut or s.cut[0] == "piece") and s.vector is None


NOTHING_MM = 1e-5  # what a corner takes off the path, at least: words and corrections are coarser


def resolve(trace, linear, axes, least_mm=NOTHING_MM):
    """The trace with corners as moves of their own."""
    out, i = [], 0
    trace = list(trace)
    while i < len(trace):
        event = trace[i]
        corner = event.corner if event.kind == "move" and isinstance(event.corner, tuple) else None
        j = i + 1
        while corner and j < len(trace) and trace[j].kind == "code":
            j += 1
        made = between(event, trace[j], linear, axes, least_mm) if corner and j < len(trace) and trace[j].kind == "move" else None
        if made is None:
            out.append(event)
            i += 1
            continue
        out.append(made[0])
        i += 1
        while trace[i].kind == "code" and (trace[i].line, trace[i].callers) == (event.line, event.callers):
            out.append(trace[i])
            i += 1
        if made[1]:
            out.append(made[1])
        trace[j] = made[2]
    return out


def between(s, e, linear, axes, least_mm):
    kind, size, plane, feed, _ = s.corner
    first, second = {17: "XY", 18: "ZX", 19: "YZ"}[plane]
    if not (can_be(s, first, second, linear, axes) and can_be(e, first, second, linear, axes)):
        return None
    if (s.frame is None) != (e.frame is None) or (s.cut and s.cut[1:]) != (e.cut and e.cut[1:]) or s.length != e.length:
        return None
    for event in (s, e):
        if event.arc and event.arc[:2] != (first, second):
            return None
    one, two = Side(s, first, second, True), Side(e, first, second, False)
    if s.frame:
        if any(abs(side.words(1.0)[a] - side.words(0.0)[a]) > 1e-7 for side in (one, two) for a in axes if a not in (first, second)):
            return None
    if one.length < 1e-9 or two.length < 1e-9:
        return None
    corner = one.at(0.0)[0]
    turn = turn_of(one.at(0.0)[1], two.at(0.0)[1])
    if abs(turn) > math.radians(170):
        return None
    plain = copy.copy(s)
    plain.corner, plain.is_made = False, True
    leg = size / (2 * math.cos(turn / 2)) if kind == "CHF" else size
    is_small = (size * (1 / math.cos(turn / 2) - 1) if kind == "RND" else leg * abs(math.sin(turn / 2))) < least_mm
    if is_small:
        return plain, None, e
    side = 1.0 if turn > 0 else -1.0
    if kind == "RND":
        taken = touching(one, two, size, side, size * math.tan(abs(turn) / 2))
    else:
        if s.arc or e.arc:
            return None
        taken = [leg] * 2
    if taken is None or min(taken) < 0 or taken[0] > one.length + 1e-7 or taken[1] > two.length + 1e-7:
        return None
    (p, u), (q, v) = one.at(taken[0]), two.at(taken[1])

    def place(at):
        words = dict(one.words(1.0), **{first: at[0], second: at[1]})
        return s.frame.to_axes(words, s.length) if s.frame else words
    after = copy.copy(e)
    after.is_made = True
    plain.end = dict(s.end, **{a: x for a, x in place(p).items() if a in linear})
    after.start = dict(e.start, **{a: x for a, x in place(q).items() if a in linear})
    if s.arc:
        f, g, centre, angle, sweep, r0, r1 = s.arc
        plain.arc = (f, g, centre, angle, sweep * one.fraction(taken[0]), r0, r1)
    if e.arc:
        f, g, centre, angle, sweep, r0, r1 = e.arc
        t = two.fraction(taken[1])
        after.arc = (f, g, centre, angle + t * sweep, sweep * (1 - t), r0, r1)
    middle = copy.copy(plain)
    middle.start, middle.end, middle.arc, middle.words, middle.number = plain.end, after.start, None, ((),), None
    middle.named = {first, second}
    middle.unsure_before = s.unsure
    if feed is not None:
        middle.feed = feed
    if kind == "RND":
        centre = (p[0] - side * size * u[1], p[1] + side * size * u[0])
        begin = math.atan2(p[1] - centre[1], p[0] - centre[0])
        middle.arc = (first, second, centre, begin, turn_of(u, v), size, size)
        if abs(middle.arc[4]) < 1e-9 or middle.arc[4] * turn < 0:  # beside arcs it may turn by more than half a turn
            middle.arc = middle.arc[:4] + (middle.arc[4] + side * 2 * math.pi, size, size)
    return plain, middle, after
