"""Heidenhain Klartext (TNC 640, iTNC 530) as the user's manual describes it."""
import re

from control import Alarm, Control, about, along, chain

# M functions that move nothing by themselves; the second set acts at the end of its block.
M_BEFORE = {3, 4, 7, 8, 13, 14, 97, 98, 101, 102, 103, 107, 108, 109, 110, 111, 116, 117, 118, 120, 124, 126, 127, 136,
            137, 138, 141, 148, 149}
M_AFTER = {0, 1, 2, 5, 9, 30}
VALUE = r"([+-]?(?:\d+\.?\d*|\.\d+))"


class Klartext(Control):
    arc_tolerance_mm = 0.017

    def __init__(self, axes, linear, setup):
        super().__init__(axes, linear, setup)
        self.wcs = "PRESET"
        self.pole = None
        self.shortest = False
        self.q = {}
        self.modal_cycle = False
        self.difference = 0.0
        self.calls_program = False
        self.shifted = set()
        self.shift_of_frame = None  # in force where a rotation or plane began to be moved

    def run(self, text):
        blocks, labels = [], {}
        lines = text.replace("\r", "").split("\n")
        i = 0
        while i < len(lines):
            first, line = i + 1, self.clean(lines[i])
            # Also behind a comment; a line with a number of its own is a block of its own.
            while lines[i].rstrip().endswith("~") and i + 1 < len(lines) and not re.match(r"\s*\d", lines[i + 1]):
                i += 1
                line = line.rstrip("~ ") + " " + self.clean(lines[i])
            line = line.rstrip("~ ")
            i += 1
            match = re.match(r"(/?)\s*(\d+)?\s*(/?)(.*)$", line)
            if match.group(4).strip():
                blocks.append((first, match.group(2), match.group(4).strip().upper(),
                               bool(match.group(1) or match.group(3))))
        for n, (_, _, body, _) in enumerate(blocks):
            match = re.match(r"LBL\s+(\d+)$", body)
            if match and match.group(1) != "0":
                labels[int(match.group(1))] = n
        pc, stack = 0, []
        while pc < len(blocks):
            self.tick()
            self.line, number, body, skipped = blocks[pc]
            self.number = int(number) if number else None
            pc += 1
            moved = {a for a in self.axes if re.search(a + r"[-+\d]", body)} if skipped and self.setup.get("either") else set()
            if skipped and self.setup.get("skip"):
                self.unsure |= moved
                continue
            match = re.match(r"CALL LBL\s+(\d+)(?:\s+REP\s*(\d+))?", body)
            if match:
                label, times = int(match.group(1)), match.group(2)
                if times is None:
                    stack.append(pc)
                    pc = labels[label] + 1
                else:  # repeats the part above
                    key = (pc, "rep")
                    self.q.setdefault(key, int(times))
                    if self.q[key] > 0:
                        self.q[key] -= 1
                        pc = labels[label] + 1
                    else:
                        del self.q[key]
                continue
            if body == "LBL 0":
                if stack:
                    pc = stack.pop()
                continue
            if body.startswith("LBL "):
                continue
            if self.block(body) == "end":
                break
            self.unsure |= moved
        return self.trace

    def clean(self, line):
        return re.split(r"[;*]", line, maxsplit=1)[0].strip()

    def block(self, body):
        match = re.match(r"BEGIN PGM \S+ (MM|INCH)", body)
        if match:
            self.inch = match.group(1) == "INCH"
            return None
        if body.startswith("END PGM"):
            return "end"
        match = re.match(r"TOOL CALL\s*(\d+)?(?:\s+([XYZ]))?(.*)$", body)
        if match:
            self.code("TOOL CALL", body)
            difference = re.search(r"DL\s*=?\s*" + VALUE, match.group(3))
            if match.group(1):
                self.length_number = int(match.group(1))
                self.tool_mm = self.setup["lengths"].get(self.length_number, 0.0)
                self.difference = 0.0
                self.lose_tcp()
                self.lose_at_tool_change()
            if difference:
                self.lose_tcp()
                self.difference = float(difference.group(1)) * self.length_unit()
            self.length = getattr(self, "tool_mm", 0.0) + self.difference
            return None
        match = re.match(r"CYCL DEF\s+(\d+)(?:\.(\d+))?(.*)$", body)
        if match:
            return self.cycle(int(match.group(1)), match.group(2), match.group(3), body)
        if body.startswith("CALL PGM"):
            self.code("CALL PGM", body)
            self.lose(self.axes)
            return None
        if body.startswith("CYCL CALL"):
            at = re.fullmatch(r"CYCL CALL POS X" + VALUE + " Y" + VALUE + " Z" + VALUE + "( FMAX| F[0-9.]+)?", body)
            if at and self.drilling and not self.foreign and not self.tcp:
                self.code("CYCL CALL", "POS" + (at.group(4) or ""))
                return None if self.drill({a: (float(at.group(k)), False) for k, a in ((1, "X"), (2, "Y"))}, ("CYCL CALL POS", body),
                                          float(at.group(3)) * self.length_unit()) else None
            self.code("CYCL CALL", body)
            if self.drilling and re.fullmatch(r"CYCL CALL( M(3|4|8|13|14))?", body) and self.drill({}, ()):
                return None
            self.lose(self.axes if "POS" in body or "PAT" in body or self.calls_program else ["Z"])
            return None
        match = re.match(r"Q(\d+)\s*=\s*" + VALUE + "$", body)
        if match:
            self.q[int(match.group(1))] = float(match.group(2))
            self.code("Q", body)
            return None
        if body.startswith("PLANE"):
            self.code("PLANE", body)
            if body.startswith("PLANE RESET"):
                for mode in ("plane", "cycle 19"):
                    self.untilt(mode)
                self.leave("tilt")
                self.leave("tilt19")
                if "STAY" not in body:
                    self.lose(self.axes)
            elif self.tilted(body):
                pass
            else:
                self.slope = self.slope_mode = None
                self.enter("tilt")
                if "STAY" not in body:
                    self.lose(self.axes)
            return None
        if body.startswith("FUNCTION"):
            self.code("FUNCTION", body)
            if body.startswith("FUNCTION TCPM"):
                self.enter("tcp") if self.difference else self.begin_tcp()
            elif body.startswith("FUNCTION RESET TCPM"):
                self.leave("tcp")
                self.end_tcp()
            return None
        if body.startswith("TRANS DATUM"):
            self.code("TRANS DATUM", body)
            self.enter("shift")
            return None
        match = re.match(r"(RND|CHF)\b(.*)$", body)
        if match:
            self.code(match.group(1), match.group(2))
            return None
        if re.match(r"(BLK FORM|TOOL DEF|STOP|FN \d|QL|QR|QS|M\d|CYCL|PRESET)", body):
            if body.startswith("PRESET"):
                self.enter("shift")
            if not body.startswith("M"):
                self.code("block", body)
                return None
        return self.motion_block(body)

    def tilted(self, body):
        match = re.fullmatch(r"PLANE SPATIAL SPA" + VALUE + " SPB" + VALUE + " SPC" + VALUE + r" (TURN|MOVE|STAY)(.*)", body)
        if not match or self.foreign:
            return False
        a, b, c = (float(v) for v in match.groups()[:3])
        if not self.tilt("plane", chain(chain(about("Z", c), about("Y", b)), about("X", a)), [0.0] * 3):
            return False
        self.pole = None
        sign = {"SEQ+": 1, "SEQ-": -1}.get(match.group(5).strip().split(" ")[0] if match.group(5).strip() else "", 0)
        master = self.frame.machine.nearest_to_tool()

        def allowed(way):
            return sign == 0 or way[master] * sign >= -1e-6
        if match.group(4) != "STAY":
            if match.group(4) == "MOVE":
                self.lose(self.linear)
            self.turn_to_plane(allowed)
        else:
            before = dict(self.pos)
            self.turn_to_plane(allowed)
            for name, axis in (("Q120", "A"), ("Q121", "B"), ("Q122", "C")):
                self.q[int(name[1:])] = self.pos.get(axis, 0.0)
            self.pos = before
        return True

    def cycle(self, number, part, rest, body):
        self.code("CYCL DEF", body)
        if number not in (7, 8, 9, 10, 11, 19, 26, 32, 247):
            self.drilling = None
        if number in (200, 201, 202, 203, 205, 206, 207, 209):
            q = {int(n): float(v) for n, v in re.findall(r"Q(\d+)\s*=\s*" + VALUE, rest)}
            if {200, 201, 203} <= set(q) and q[201] < 0:
                unit = self.length_unit()
                self.drilling = [(q[203] + q[200]) * unit, (q[203] + q[201]) * unit,
                                 (q[203] + max(q[200], q.get(204, 0.0))) * unit]
        if number not in (7, 8, 10, 11, 9, 26, 19, 32, 247):
            self.calls_program = number == 12
        values = [float(v) for v in re.findall(r"[A-Z]" + VALUE, rest)]
        named = re.findall(r"([A-Z])" + VALUE, rest)
        stays = number == 7 and named and not re.search(r"I[A-Z]|Q|#", rest) and \
            all(float(value) * (self.unit(axis) if axis in self.axes else 1.0) == self.trans.get(axis, 0.0) for axis, value in named)
        if number in (7, 247) and part not in ("0",) and (self.inner or self.slope) and not stays:
            if number == 247:
                self.inner = self.inner_mode = self.slope = self.slope_mode = None
                self.shift_of_frame = None
            elif "moved frame" not in self.foreign:
                self.shift_of_frame = dict(self.trans)
            self.enter("moved frame")  # whether that moves with it, nobody said: until the shift is what it was
        if number == 7:
            if part not in (None, "0"):  # each line states one axis or more
                named = re.findall(r"([A-Z])" + VALUE, rest)
                for axis, value in named:
                    if axis in self.axes:
                        self.trans[axis] = float(value) * self.unit(axis)
                        self.pole = None
                        self.shifted.discard(axis)
                    else:
                        (self.shifted.add if float(value) else self.shifted.discard)(axis)
                if not named or re.search(r"I[A-Z]|Q|#", rest):
                    self.shifted.add("?")
                (self.enter if self.shifted else self.leave)("shift")
                if not self.shifted and self.trans == self.shift_of_frame:
                    self.leave("moved frame")
        elif number == 8:
            if part not in (None, "0"):
                self.pole = None
                self.unturn("mirror")
                named = rest.split()
                if not named or not set(named) <= {"X", "Y"} or not self.turn("mirror", along(
                        *[-1.0 if a in named else 1.0 for a in "XYZ"]), [0.0] * 3):
                    (self.enter if named else self.leave)("mirror")
        elif number == 10:
            if part not in (None, "0"):
                self.pole = None
                self.unturn("rotation")
                plain = re.fullmatch(r"\s*ROT" + VALUE, rest)
                if not any(values):
                    self.leave("rotation")
                elif not plain or not self.turn("rotation", about("Z", values[0]), [0.0] * 3):
                    self.enter("rotation")
        elif number in (11, 26):
            if part not in (None, "0"):
                self.pole = None
                match = re.fullmatch(r"\s*SCL\s*" + VALUE, rest)
                if number == 11:
                    self.unturn("scale")
                if number == 11 and match and float(match.group(1)) == 1:
                    self.leave("scale")
                elif number == 26 or not match or not self.turn("scale", along(*[float(match.group(1))] * 3), [0.0] * 3):
                    self.enter("scale")
        elif number == 19:
            if part not in (None, "0"):
                self.pole = None
                if not rest.strip():
                    self.untilt("cycle 19")
                angles = {a: float(v) for a, v in re.findall(r"([ABC])\s*" + VALUE, rest)}
                if not rest.strip():
                    self.leave("tilt19")
                elif self.foreign or not self.tilt("cycle 19", chain(chain(
                        about("Z", angles.get("C", 0.0)), about("Y", angles.get("B", 0.0))), about("X", angles.get("A", 0.0))), [0.0] * 3):
                    (self.enter if any(angles.values()) else self.leave)("tilt19")
                else:
                    before = dict(self.pos)
                    self.turn_to_plane()
                    for number, axis in ((120, "A"), (121, "B"), (122, "C")):
                        self.q[number] = self.pos.get(axis, 0.0)
                    self.pos = before
                    self.lose(self.rotary())  # a builder may let the cycle turn them
        elif number == 247:
            match = re.search(r"Q339\s*=\s*\+?(\d+)\s*$", rest)
            name = "PRESET " + match.group(1) if match else None
            self.pole = None
            if name in self.setup["offsets"]:
                self.wcs = name
                self.leave("datum")
            else:
                self.enter("datum")
        elif number in (220, 221, 12, 14) or 400 <= number < 500:
            # Pattern cycles run where they are defined (so says their page: "DEF active"); 12 and 14 only name contours.
            if number not in (12, 14):
                self.lose(self.axes)
        return None

    def motion_block(self, body):
        words, other, m, kind = {}, {}, [], None
        text = body
        match = re.match(r"(APPR|DEP) (LT|LN|CT|LCT)(?=\s|$)", text) or \
            re.match(r"(LP|LN|L|CR|CC|CTP|CT|CP|C)(?=\s|[XYZABCUVWI+-]|$)", text)
        if match:
            kind, text = match.group(0), text[match.end():]
        at = 0
        token = re.compile(
            r"\s*(?:(FMAX|F MAX|FAUTO)|(R0|RL|RR)(?![\d.+-])|(DR[+-])|M(\d+)|(I?)([XYZABCUVW])\s*" + VALUE + r"|(LEN|CCA|IPA|PA|IPR|PR|[IFSRP])\s*" + VALUE +
            r"|(I?[XYZABCUVW])\s*([+-]?)Q(\d+)|(MB MAX|MB)\s*" + VALUE + r"?|([TN][XYZ])\s*" + VALUE + "|(.))")
        while at < len(text):
            match = token.match(text, at)
            if not match:
                break
            at = match.end()
            if match.group(1):
                other["F"] = match.group(1)
            elif match.group(2):
                other["comp"] = match.group(2)
            elif match.group(3):
                other["DR"] = match.group(3)
            elif match.group(4):
                m.append(int(match.group(4)))
            elif match.group(6):
                axis = match.group(6)
                if axis not in self.axes:
                    raise Alarm("no axis " + axis)
                if axis in words:
                    raise Alarm("two words " + axis)
                words[axis] = (float(match.group(7)), bool(match.group(5)))
            elif match.group(8):
                other[match.group(8)] = float(match.group(9))
            elif match.group(10):
                address = match.group(10)
                value = self.q.get(int(match.group(12)), 0.0) * (-1 if match.group(11) == "-" else 1)
                words[address[-1]] = (value, address[0] == "I")
            elif match.group(13):
                other[match.group(13)] = match.group(14)
            elif match.group(15):
                other[match.group(15)] = float(match.group(16))
            elif match.group(17):
                raise Alarm("cannot read %r" % body)
        if kind is None and words:
            raise Alarm("axis words without L or C: " + body)
        return self.act(kind, words, other, m)

    def act(self, kind, words, other, m):
        if kind == "CC":
            if "comp" in other or m:
                raise Alarm("CC with other words")
            unit = self.length_unit()
            pole = []
            for axis in ("X", "Y"):
                if not words:
                    pole.append(self.standing()[axis])
                elif axis in words:
                    value, inc = words[axis]
                    pole.append(value * unit + (self.standing()[axis] if inc else self.offset(axis)))
                else:
                    pole.append(self.pole[("X", "Y").index(axis)] if self.pole else 0.0)
            self.pole = tuple(pole)
            return None
        rapid = other.pop("F", None) if isinstance(other.get("F"), str) else None
        if isinstance(other.get("F"), float):
            self.feed = other.pop("F") * self.length_unit()
        comp = other.pop("comp", None)
        if comp in ("RL", "RR"):
            self.cutter_on(1 if comp == "RL" else -1, self.length_number)
        elif comp == "R0":
            self.cutter_off()
        machine = [c for c in m if c in (91, 92)]
        for code in m:
            if code == 128:  # at the begin of its block, M129 at the end
                self.enter("tcp") if self.difference else self.begin_tcp()
            if code in (114, 144):
                self.enter("tilting axes")
            if code in (115, 145):
                self.leave("tilting axes")
            if code == 126:
                self.shortest = True
            elif code == 127:
                self.shortest = False
        for code in m:
            if code not in M_AFTER and code not in (99, 89, 91, 92, 140, 94):
                self.code("M", code)
        if 94 in m:
            self.code("M", 94)
            self.lose([a for a in self.axes if a not in self.linear])
        if 140 in m:
            self.code("M140", tuple(sorted((k, str(v)) for k, v in other.items())))
            self.lose(self.axes)
            other = {}
        self.vector = None
        if kind and kind[0] in "AD":
            self.leave_or_come(kind, words, other, comp)
        elif kind == "LN" and self.tcp and not self.foreign and not machine and 130 not in m and any("T" + a in other for a in "XYZ") and \
                not any(a not in self.linear for a in words):
            # The normals move the path where the tool has differences alone.
            self.vector = [other.pop("T" + a, 0.0) for a in "XYZ"]
            self.move(words, bool(rapid), None, ("straight", kind, tuple(sorted((k, str(v)) for k, v in other.items()))))
        elif words or kind == "LN":
            raw = (kind, tuple(sorted((k, str(v)) for k, v in other.items())))
            if machine or 130 in m:
                event = self.emit("raw")
                event.key = ("machine", tuple(sorted(m)), tuple(sorted(words.items())))
                for a, (v, inc) in words.items():
                    self.pos[a] = v * self.unit(a) + (self.pos[a] if inc else 0.0)
                    self.opaque.discard(a)
                    self.unsure.add(a)
                if self.tcp:
                    self.lose(self.axes)
            elif self.foreign or kind in ("CT", "CP", "CTP", "LP", "LN") or (self.tcp and kind != "L"):
                event = self.emit("raw")
                event.key = ("mode", kind, tuple(sorted(self.foreign)), tuple(sorted(words.items())), raw, self.pole_key(kind))
                for a, (v, inc) in words.items():
                    self.pos[a] = self.target(a, v, inc)
                if (kind != "L" and not self.foreign) or self.tcp:
                    self.lose(self.linear)
            elif kind == "L" and 99 in m and self.drilling and rapid and \
                    self.drill(words, tuple(sorted((a, round(v, 9), i) for a, (v, i) in words.items()))):
                m = [c for c in m if c != 99]
                self.code("cycle call", 99)
            elif kind == "L":
                self.move(words, bool(rapid), None, ("straight",) + raw)
            elif kind in ("C", "CR"):
                clockwise = other.get("DR") == "DR-"
                if "DR" not in other:
                    raise Alarm("arc without DR")
                if kind == "C":
                    if self.pole is None:
                        raise Alarm("arc without CC")
                    centre = self.pole
                else:
                    centre = other["R"] * self.length_unit()
                self.move(words, False, ("X", "Y", centre, clockwise), ("arc",) + raw)
            else:
                raise Alarm("not read: " + kind)
        elif other:
            if kind in ("CP", "LP", "CT"):
                event = self.emit("raw")
                event.key = (kind, tuple(sorted((k, str(v)) for k, v in other.items())), self.pole_key(kind))
                self.lose(self.linear)
            elif other:
                self.code("words", tuple(sorted((k, str(v)) for k, v in other.items())))
        for code in m:
            if code == 129:
                self.leave("tcp")
                self.end_tcp()
            if code in M_AFTER:
                self.code("M", code)
                if code in (2, 30):
                    return "end"
            elif code == 6:  # a function of the machine's builder
                self.code("M", code)
                self.lose_at_tool_change()
            elif code in (89, 99):
                self.code("cycle call", code)
                self.lose(["Z"])
            elif code not in M_BEFORE and code not in (91, 92, 94, 114, 115, 128, 129, 130, 140, 144, 145) and \
                    code not in self.setup.get("harmless", ()):
                self.lose(self.axes)
        return None

    def leave_or_come(self, kind, words, other, comp):
        """APPR leads to the first point of the contour, DEP away from its last one: to a point of its own, or the control
        computes where."""
        raw = (kind, tuple(sorted((k, str(v)) for k, v in other.items())))
        comes = kind.startswith("APPR")
        if not comes:
            self.cutter_off()
        if self.foreign or self.tcp or (comes and comp not in ("RL", "RR")):
            event = self.emit("raw")
            event.key = ("mode", kind, tuple(sorted(self.foreign)), tuple(sorted(words.items())), raw, None)
            self.lose(self.linear)
        elif comes or kind == "DEP LCT":
            self.move(words, False, None, ("straight",) + raw)
        else:
            self.cutter_state = "off"
            self.code("DEP", raw)
            self.lose(["X", "Y"])

    drilling = None

    def drill(self, words, raw, shift=None):
        """The cycle that was defined last, at X and Y of `words`: heights count from the datum, or are shifted from there."""
        if self.foreign or self.tcp:
            return False
        if "Z" in words:
            self.pos["Z"] = self.target("Z", *words["Z"])
        entry, bottom, level = [h + self.offset("Z") + (shift or 0.0) for h in self.drilling]
        event = self.hole(("called", "CYCL" if shift is None else "POS"), {a: v for a, v in words.items() if a != "Z"}, raw, entry, bottom, level)
        event.length -= self.difference
        self.opaque.discard("Z")
        self.unsure.discard("Z")
        return True

    def move(self, words, rapid=False, arc=None, raw=()):
        event = super().move(words, rapid, arc, raw)
        event.length -= self.difference  # DL lifts Z; the tool is as long as it is
        return event

    def pole_key(self, kind):
        return tuple(round(v, 2) for v in self.pole) if self.pole and kind in ("CP", "LP", "C", "CTP") else None

    def target(self, axis, value, incremental):
        # M126 is for axes that count from 0 to 360 deg; others go on counting.
        if self.shortest and axis in self.rollover and not incremental:
            saved, self.rollover = self.rollover, {axis: "shortest"}
            try:
                return super().target(axis, value, incremental)
            finally:
                self.rollover = saved
        return super().target(axis, value, incremental)
