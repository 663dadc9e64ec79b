"""Fanuc 30i, Mazak EIA, Haas, LinuxCNC 2.9 and Sinumerik 840D as their programming manuals describe them."""
import math
import re

from corners import NOTHING_MM, resolve
from control import Alarm, Control, about, along, chain, times

PLANES = {17: ("X", "Y", "I", "J"), 18: ("Z", "X", "K", "I"), 19: ("Y", "Z", "J", "K")}
NUMBER = r"[+-]?\s*(?:\d[\d ]*\.?[\d ]*|\.[\d ]+)"

# M codes that move nothing, by manual. Whatever is not here belongs to the machine's builder and may call a macro.
M_BEFORE = {3, 4, 7, 8, 13, 14}
M_AFTER = {0, 1, 2, 5, 9, 30}
M_MORE = {
    "fanuc": {19, 29, 48, 49}, "mazak": {19, 29, 48, 49},
    "haas": {10, 11, 12, 13, 19, 29, 31, 33, 34, 35, 41, 42, 48, 49, 59, 63, 69, 73, 74, 83, 84, 88, 89},
    "linuxcnc": {19, 48, 49, 50, 51, 52, 53, 61, 62, 63, 64, 65, 66, 67, 68, 70, 71, 73},
    "sinumerik": {19, 40, 41, 42, 43, 44, 45, 70},
}
CYCLES = {73, 74, 76, 81, 82, 83, 84, 85, 86, 87, 88, 89}


class Word:
    __slots__ = ("address", "value", "how", "has_point")

    def __init__(self, address, value, how=None, has_point=True):
        self.address, self.value, self.how, self.has_point = address, value, how, has_point


class Iso(Control):
    def __init__(self, dialect, axes, linear, setup):
        super().__init__(axes, linear, setup)
        self.dialect = dialect
        self.motion = 1
        self.plane = 17
        self.centre_absolute = False
        self.variables, self.arguments = {}, {}
        self.cycle = None
        self.cycle_r = self.cycle_z = self.cycle_level = None
        self.return_level = 99 if dialect == "linuxcnc" else 98  # rs274 of 2.9 begins at the R level
        self.saved_preset = None
        self.wcs = "" if dialect == "sinumerik" else "G54"
        self.is_sinumerik = dialect == "sinumerik"
        # Without the line's end. LinuxCNC: rs274 of 2.9; Sinumerik: Programming Manual Fundamentals.
        self.max_line = {"linuxcnc": 252, "sinumerik": 512}.get(dialect)
        self.arc_tolerance_mm = {"sinumerik": 0.011, "haas": 0.02, "linuxcnc": 0.127}.get(dialect, 0.02)
        self.corner_all, self.corner_feed_all = None, None  # RNDM, FRCM
        self.unsure_later = set()

    def check_radii(self, r0, r1):
        super().check_radii(r0, r1)
        # rs274 of LinuxCNC, on a machine whose ini file asks for the most: 0.1 % and 0.00127 mm (0.00005 inch).
        if self.dialect == "linuxcnc" and abs(r0 - r1) > 0.00127 and abs(r0 - r1) > 0.001 * max(r0, r1):
            raise Alarm("radius %.5f at the start, %.5f at the end" % (r0, r1))

    # -- text
    def run(self, text):
        self.lines = text.replace("\r", "").split("\n")
        self.programs, self.labels, self.subs = {}, {}, {}
        body = []
        for i, line in enumerate(self.lines):
            if self.max_line and len(line) > self.max_line:
                raise Alarm("line %d: %d characters, the control reads %d" % (i + 1, len(line), self.max_line))
            clean, skipped = self.clean(line)
            body.append((clean, skipped))
            match = re.match(r"\s*[O:]\s*(\d+)\s*(SUB)?", clean, re.I)
            if match:
                (self.subs if match.group(2) else self.programs).setdefault(int(match.group(1)), i)
            match = re.match(r"\s*N\s*(\d+)", clean, re.I)
            if match:
                self.labels.setdefault(int(match.group(1)), i)
        # Subprograms in files of their own stand behind the text, where nothing runs into them.
        main = len(body)
        at = list(range(1, main + 1))  # lines, as each file counts them
        for name, lines in self.setup.get("files", {}).items():
            for line in lines.replace("\r", "").split("\n"):
                clean, skipped = self.clean(line)
                match = re.match(r"\s*[O:]\s*(\d+)\s*(SUB)?", clean, re.I)
                if match:
                    (self.subs if match.group(2) else self.programs).setdefault(int(match.group(1)), len(body))
                body.append((clean, skipped))
            at += range(1, len(body) - len(at) + 1)
        self.body = body
        # Behind a first %, the second one ends the file; behind blocks the first one does.
        tapes = self.dialect in ("fanuc", "mazak", "haas")  # whatever stands behind the sign, they read no further
        percents = [i for i, (clean, _) in enumerate(body[:main]) if clean.strip() == "%" or tapes and clean.startswith("%")]
        is_end = percents and any(re.fullmatch(r"(\s*[A-Z]\s*[-+]?[\d.]+)+\s*", clean, re.I) for clean, _ in body[:percents[0]])
        begin = percents[0] + 1 if percents and not is_end else 0
        ends = percents if is_end else percents[1:]
        end = ends[0] if ends else main
        pc, stack = begin, []
        while pc < end or main <= pc < len(body):
            self.tick()
            self.callers = tuple(entry[3] for entry in stack)
            clean, skipped = body[pc]
            self.line = at[pc]
            pc += 1
            if skipped and self.setup.get("either"):  # who does not know the switch does not know where these axes stand
                self.unsure_later = {a for a in self.axes if re.search(a + r"\s*[-+=.\d]", clean, re.I)}
            # rs274: "Bad character '%' used", where other words stand behind it.
            if self.dialect == "linuxcnc" and clean.startswith("%") and clean.strip() != "%":
                raise Alarm("bad character '%%' in %r" % clean.strip())
            if (skipped and self.setup.get("skip")) or not clean.strip() or clean.startswith("%"):
                self.unsure |= self.unsure_later
                self.unsure_later = set()
                continue
            jump = self.block(clean)
            self.unsure |= self.unsure_later
            self.unsure_later = set()
            if jump is None:
                continue
            what, where, times = jump
            if what == "end":
                return self.resolved()
            if what == "goto":
                pc = where
            elif what == "call":
                stack.append([pc, where, times, self.line, dict(self.variables)])
                self.variables.update(self.arguments)
                self.arguments = {}
                pc = where + 1
            elif what == "return":
                if not stack:
                    return self.resolved()
                stack[-1][2] -= 1
                if stack[-1][2] > 0:
                    pc = stack[-1][1] + 1
                else:
                    frame = stack.pop()
                    pc = frame[0]
                    if self.dialect == "linuxcnc":  # #1 to #30 are the caller's again
                        self.variables = {name: value for name, value in self.variables.items() if not isinstance(name, int) or name > 30}
                        self.variables.update((name, value) for name, value in frame[4].items() if isinstance(name, int) and name <= 30)
            elif what == "over":  # a LinuxCNC subprogram's text is read over
                while (pc < end or main <= pc < len(body)) and not re.match(r"\s*O\s*%d\s*ENDSUB" % where, body[pc][0], re.I):
                    pc += 1
                pc += 1
        return self.resolved()

    def resolved(self):
        return resolve(self.trace, self.linear, self.axes, self.setup.get("least_corner_mm", NOTHING_MM)) if self.is_sinumerik else self.trace

    def compared_feed(self):
        return self.feed if self.is_sinumerik else None

    def clean(self, line):
        """The block without comments, and whether a '/' leads it."""
        out, depth = [], 0
        for i, c in enumerate(line):
            if not self.is_sinumerik and c == "(":
                if depth:
                    raise Alarm("nested comment")
                depth = 1
            elif not self.is_sinumerik and c == ")" and depth:
                depth = 0
            elif depth:
                continue
            elif c == ";":
                break
            else:
                out.append(c)
        if depth:
            raise Alarm("unclosed comment")
        text = "".join(out).strip()
        match = re.match(r"(N\s*\d+\s*)?/\d?\s*", text)
        if match:
            return (match.group(1) or "") + text[match.end():], True
        return text, False

    def words(self, text):
        """Words in order; what is no word is a whole: ("CYCLE800", text)."""
        text = text.upper()
        out, at = [], 0
        while at < len(text):
            if text[at] in " \t":
                at += 1
                continue
            match = re.compile(r"#\s*<(\w+)>\s*=\s*(" + NUMBER + ")").match(text, at)
            if match and self.dialect == "linuxcnc":
                out.append(Word("#", (match.group(1), float(match.group(2).replace(" ", "")))))
                at = match.end()
                continue
            match = re.compile(r"#\s*(\d+)\s*=\s*(" + NUMBER + ")").match(text, at)
            if match and not self.is_sinumerik:
                out.append(Word("#", (int(match.group(1)), float(match.group(2).replace(" ", "")))))
                at = match.end()
                continue
            if self.is_sinumerik:
                match = re.compile(r"R(\d+)\s*=\s*(" + NUMBER + ")").match(text, at)
                if match:
                    out.append(Word("#", (int(match.group(1)), float(match.group(2).replace(" ", "")))))
                    at = match.end()
                    continue
                match = re.compile(r"([XYZABC])\s*=\s*([_A-Z$][\w$.]*[_A-Z]\w*)(?=\s|$)").match(text, at)
                if match:  # a place that a variable of the machine says
                    out.append(Word(match.group(1), match.group(2)))
                    at = match.end()
                    continue
                match = re.compile(r"([XYZABC])\s*=\s*([-+*\d.R]*R\d+[-+*\d.R]*)(?=\s|$)").match(text, at)
                if match and re.search(r"[-+*]", match.group(2)):
                    out.append(Word(match.group(1), self.evaluate(match.group(2))))
                    at = match.end()
                    continue
                match = re.compile(r"([A-Z]+\d*)\s*=\s*(?:(AC|IC|DC|ACP|ACN)\s*\(\s*)?(R\d+|\"[^\"]*\"|" + NUMBER + r")\s*(\))?").match(text, at)
                if match and (match.group(2) is None) == (match.group(4) is None):
                    raw = match.group(3)
                    value = (self.variables[int(raw[1:])] if raw[0] == "R" else raw if raw[0] == '"' else
                             float(raw.replace(" ", "")))
                    out.append(Word(match.group(1), value, match.group(2)))
                    at = match.end()
                    continue
                match = re.compile(r"([A-Z_]{2,}\d*)(\s*\([^)]*\))?").match(text, at)
                if match:
                    rest = match.group(0)
                    if match.group(1) in FRAMES or match.group(1) == "MCALL":  # takes the rest of the block
                        rest = text[at:]
                    out.append(Word(match.group(1), rest.strip()))
                    at += len(rest)
                    continue
            match = re.compile(r"([XYZABC])\s*\[([^\[\]]+)\]").match(text, at)
            if match and not self.is_sinumerik:
                out.append(Word(match.group(1), self.evaluate(match.group(2))))
                at = match.end()
                continue
            match = re.compile(r"(IF|GOTO|WHILE|DO|END|DPRNT|POPEN|PCLOS)").match(text, at)
            if match:
                out.append(Word(match.group(1), text[match.end():].strip()))
                break
            match = re.compile(r"(,?[A-Z])\s*(?:([+-]?)#\s*(\d+)|(" + NUMBER + "))").match(text, at)
            if not match:
                raise Alarm("cannot read %r" % text[at:])
            if match.group(3):
                if int(match.group(3)) not in self.variables:
                    raise Alarm("variable #%s is empty" % match.group(3))
                value = self.variables[int(match.group(3))] * (-1 if match.group(2) == "-" else 1)
                out.append(Word(match.group(1), value))
            else:
                raw = match.group(4).replace(" ", "")
                out.append(Word(match.group(1), float(raw), None, "." in raw))
            at = match.end()
        return out

    def evaluate(self, text):
        """A sum of numbers, variables and products of two of them."""
        total = 0.0
        for sign, product in re.findall(r"([-+]?)([^-+]+)", text.replace(" ", "")):
            value = -1.0 if sign == "-" else 1.0
            for factor in product.split("*"):
                name = re.fullmatch(r"(?:#|R)(\d+)", factor)
                if name and int(name.group(1)) not in self.variables:
                    raise Alarm("variable %s is empty" % factor)
                value *= self.variables[int(name.group(1))] if name else float(factor)
            total += value
        return total

    # -- one block
    def block(self, text):
        self.number = None
        match = re.match(r"\s*[O:]\s*(\d+)\s*(.*)$", text, re.I)
        if match:
            return self.o_word(int(match.group(1)), match.group(2).strip().upper())
        g, m, axis_words, other, counted, foreign = [], [], {}, [], [], None
        for word in self.words(text):
            a = word.address
            if a == "#":
                self.variables[word.value[0]] = word.value[1]
                self.code("#", word.value)
            elif a == "N":
                self.number = word.value
            elif a == "G":
                g.append(round(word.value, 1))
            elif a == "M":
                m.append(int(word.value))
            elif a in self.axes:
                if a in axis_words:
                    raise Alarm("two words " + a)
                value = word.value
                if not word.has_point and self.setup.get("increment"):
                    counted.append(a)
                axis_words[a] = (value, word.how)
            elif len(a) == 1 and a in "XYZABCUVW":
                foreign = a
            else:
                if a in "IJKR" and not word.has_point and self.setup.get("increment"):
                    counted.append(word)
                other.append(word)
        call = self.call_of(g, m, other)
        if call:  # its other words are the control's and the macro's
            if 98 in m and g:  # what states modes acts first
                self.execute(g, [], {}, [])
            return call
        if foreign:
            raise Alarm("no axis " + foreign)
        inch = 20 in g or (self.inch and 21 not in g)
        for word in counted:  # 0.001 mm, 0.0001 inch, 0.001 deg
            if isinstance(word, Word):
                word.value *= self.setup["increment"] * (0.1 if inch else 1.0)
            else:
                value, how = axis_words[word]
                axis_words[word] = (value * self.setup["increment"] * (0.1 if inch and word in self.linear else 1.0), how)
        return self.execute(g, m, axis_words, other)

    def call_of(self, g, m, other):
        """M98 or G65 of a program of this text; M97 of Haas."""
        p = self.parameters(other)
        number = int(p.get("P", 0))
        if not self.is_sinumerik and (98 in m or 65 in g) and number in self.programs:
            return ("call", self.programs[number], int(p.get("L", 1)))
        if self.dialect == "haas" and 97 in m:
            return ("call", self.labels[number] - 1, int(p.get("L", 1)))
        return None

    def o_word(self, number, rest):
        if self.dialect == "linuxcnc":
            if rest.startswith("SUB"):
                return ("over", number, 0)
            if rest.startswith("ENDSUB") or rest.startswith("RETURN"):
                return ("return", 0, 0)
            if rest.startswith("CALL"):
                if number not in self.subs:
                    self.code("call", number)
                    self.lose(self.axes)
                    return None
                self.arguments = {i + 1: self.evaluate(text) for i, text in enumerate(re.findall(r"\[([^\[\]]+)\]", rest))}
                return ("call", self.subs[number], 1)
            if rest:
                raise Alarm("words behind O%d: %s" % (number, rest))
            return None
        if rest:
            raise Alarm("words behind O%d: %s" % (number, rest))
        return None

    def parameters(self, other):
        return {w.address: w.value for w in other}

    def take(self, other, *names):
        out = {}
        for w in list(other):
            if w.address in names:
                out[w.address] = w
                other.remove(w)
        return out

    def execute(self, g, m, axis_words, other):
        g = list(g)
        done = []

        def has(*codes):
            found = [c for c in g if c in codes]
            for c in found:
                g.remove(c)
                done.append(c)
            return found[-1] if found else None

        sin = self.is_sinumerik
        # Modes first, as every one of these manuals orders them: feed mode, units, plane, distance.
        code = has(93, 94, 95, 931, 194)
        if code:
            self.feed_mode = int(code)
        feed = self.take(other, "F").get("F")
        if feed:
            self.feed = feed.value * (self.length_unit() if self.feed_mode != 93 else 1.0)
        elif self.feed_mode == 93 and code == 93:
            self.feed = 0.0
        if sin:
            code = has(70, 700)
            if code:
                self.inch = True
            code = has(71, 710)
            if code:
                self.inch = False
        else:
            code = has(20, 21)
            if code:
                self.inch = code == 20
        if feed and self.feed_mode != 93:
            self.feed = feed.value * self.length_unit()
        code = has(17, 18, 19)
        if code:
            self.plane = int(code)
        code = has(90, 91)
        if code:
            self.incremental = code == 91
        if not sin:
            code = has(90.1, 91.1)
            if code:
                self.centre_absolute = code == 90.1

        self.keywords(other, axis_words)
        if "raw" in self.block_flags:
            self.machine_codes(m, before=True)
            self.raw("keyword", g + done, axis_words, other)
            self.machine_codes(m, before=False)
            return self.flow(m, other)

        # Everything that does not move axes but tells the control something.
        passive = [w for w in other if w.address in ("S", "T", "D", "Q", "P", "E", "L") and w.address in ("S", "T")]
        for w in passive:
            other.remove(w)
            self.code(w.address, w.value)
            if w.address == "T":
                self.called_tool = str(w.value).lstrip("=").split(".")[0]
        self.machine_codes(m, before=True)

        if 4 in g:
            times = tuple((a, v[0]) for a, v in axis_words.items()) + tuple((w.address, w.value) for w in other)
            self.code("dwell", times)
            self.machine_codes(m, before=False)
            return self.flow(m, [])
        if has(65):
            p = self.parameters(other)
            if int(p.get("P", 0)) in self.programs:
                return ("call", self.programs[int(p["P"])], int(p.get("L", 1)))
            self.raw("G65", [], axis_words, other)
            self.lose(self.axes)
            return None

        # Modes that turn, bend or compensate.
        self.tool_length(has, axis_words, other)
        self.modes(has, axis_words, other)
        self.work_offset(has, other)
        if self.is_sinumerik and has(53, 153):
            self.block_flags.add("machine")

        code = has(10) if not sin else None
        if code:
            self.data_input(axis_words, other)
            return self.flow(m, [])
        code = has(52) if not sin else None
        if code:
            for a, (v, _) in axis_words.items():
                if self.dialect == "linuxcnc":
                    self.preset[a] = 0.0  # G52 and G92 share their place
                self.shift[a] = v * self.unit(a)
            self.code("G52")
            axis_words = {}
        if not sin:
            code = has(92)
            if code or self.is_lathe_preset(g):
                if not code:
                    has(50)
                for a, (v, _) in axis_words.items():
                    self.preset[a] = 0.0
                    if self.dialect == "linuxcnc":
                        self.shift[a] = 0.0
                    self.preset[a] = self.pos[a] - v * self.unit(a) - self.offset(a)
                self.raw("G92", [], axis_words, other, moves=False)
                axis_words, other = {}, []
            elif has(92.1):
                named = list(axis_words) or list(self.axes)
                if self.dialect == "linuxcnc":
                    named = list(self.axes)
                for a in named:
                    self.preset[a] = 0.0
                    if self.dialect in ("linuxcnc", "fanuc", "mazak"):
                        self.shift[a] = 0.0
                axis_words = {}
                self.code("G92.1")
            elif self.dialect == "linuxcnc" and has(92.2):
                self.saved_preset = dict(self.preset)
                self.preset = {a: 0.0 for a in self.axes}
                self.code("G92.2")
            elif self.dialect == "linuxcnc" and has(92.3):
                if self.saved_preset:
                    self.preset = dict(self.saved_preset)
                self.code("G92.3")

        # Moves to places of the machine.
        reference = has(28, 30, 27) if not sin else has(74, 75)
        if reference:
            self.raw("G%d" % reference, [], axis_words, other)
            self.lose(list(self.axes) if self.tcp else list(axis_words) or list(self.axes))
            self.machine_codes(m, before=False)
            return self.flow(m, [])
        if not sin and has(53):
            if has(0, 1) is not None:
                self.motion = done[-1]
            self.raw("G53", [], axis_words, other)
            if self.setup.get("still"):
                event = self.move({}, self.motion == 0)
                event.end = dict(self.pos, **{a: v * self.unit(a) for a, (v, _) in axis_words.items()})
                event.unsure = set()
            for a, (v, _) in axis_words.items():
                self.pos[a] = v * self.unit(a)
                self.opaque.discard(a)
                self.unsure.add(a)
            if self.tcp:
                self.lose(self.axes)
            self.machine_codes(m, before=False)
            return self.flow(m, [])

        motion = has(0, 1, 2, 3)
        if motion is not None:
            self.motion, self.cycle = int(motion), None
        if not sin:
            code = has(*CYCLES)
            if code:
                if self.cycle is None:
                    self.motion_before = self.motion
                    self.cycle_level, self.level_is_known = self.standing()["Z"], "Z" not in self.opaque
                if self.cycle != int(code):
                    self.cycle_r = self.cycle_z = None
                self.cycle = self.motion = int(code)
            if has(80):  # of Fanuc, Mazak and Haas it is of the group of the cycles: the motion code stands as it did
                keeps = self.cycle is not None and self.dialect != "linuxcnc"
                self.cycle, self.motion = None, self.motion_before if keeps else 80
            code = has(98, 99)
            if code:
                self.return_level = int(code)
        if not sin and self.slope_mode == "tilt" and not axis_words and not other and has(53.1, 253):
            self.code("to the plane")
            self.turn_to_plane()
        one_shot = [c for c in g if c in (31, 33, 33.1, 38.2, 38.3, 38.4, 38.5, 12, 13, 47, 70, 71, 72, 5.2, 5.3, 63, 331,
                                          332, 147, 148, 247, 248, 347, 348, 60, 150, 53.1, 253, 29, 34, 35, 36, 37)]
        if one_shot:
            self.raw("G%g" % one_shot[0], [], axis_words, other)
            self.lose(list(axis_words) or (list(self.axes) if one_shot[0] in (53.1, 253) else []))
            self.machine_codes(m, before=False)
            return self.flow(m, [])

        if g:  # exact stop, path modes, look-ahead: nothing that moves
            more = tuple((w.address, w.value) for w in other if w.address in "PQRE") if not axis_words else ()
            self.code("G", tuple(sorted(g)), more)
            if not axis_words:
                other = [w for w in other if w.address not in "PQRE"]
        self.act(axis_words, other)
        self.machine_codes(m, before=False)
        return self.flow(m, other)

    def is_lathe_preset(self, g):
        return self.dialect in ("fanuc", "mazak") and self.setup.get("lathe") and 50 in g

    # -- pieces of a block
    def machine_codes(self, m, before):
        for code in list(m):
            if code in (98, 99, 97, 96) or (code in (2, 30, 17) and before):
                continue
            is_before = code in M_BEFORE or code == 6 or (self.dialect == "linuxcnc" and code in (70, 71, 73))
            if is_before != before:
                continue
            m.remove(code)
            if code in (2, 30) or (code == 17 and self.is_sinumerik):
                m.append(code)
                continue
            self.code("M", code)
            if code == 6:
                self.lose_tcp()
                self.spindle = self.called_tool
                self.lose_at_tool_change()
            elif code in M_AFTER or code in M_BEFORE or code in M_MORE[self.dialect]:
                pass
            elif self.dialect == "linuxcnc" and code in (428, 429, 430):
                self.leave("kinematics")
                if code != 428 or True:
                    self.enter("kinematics")
            elif code in self.setup.get("harmless", ()):
                pass
            else:
                self.lose(self.axes)  # a macro of the builder

    def flow(self, m, other):
        p = self.parameters(other)
        if 98 in m and not self.is_sinumerik:
            number, times = int(p.get("P", 0)), int(p.get("L", 1))
            if number in self.programs:
                return ("call", self.programs[number], times)
            self.code("call", number)
            self.lose(self.axes)
        if 97 in m and self.dialect == "haas":
            return ("call", self.labels[int(p["P"])] - 1, int(p.get("L", 1)))
        if 99 in m:
            return ("return", 0, 0)
        if 17 in m and self.is_sinumerik:
            return ("return", 0, 0)
        if 2 in m or 30 in m:
            self.code("M", 30)
            return ("end", 0, 0)
        return None

    def tool_length(self, has, axis_words, other):
        lengths = self.setup["lengths"]
        if self.is_sinumerik:
            d = self.take(other, "D").get("D")
            if d:
                self.edge = int(d.value)
                of_tool = self.setup.get("edges", {}).get("T%sD%d" % (self.spindle, int(d.value)))
                self.set_length(lengths.get(int(d.value), 0.0) if of_tool is None else of_tool, axis_words)
                self.code("D", d.value)
            return
        h = self.take(other, "H").get("H")
        code = has(43, 44, 49, 43.1, 43.2, 43.4, 43.5, 234)
        if code is None:
            if h and self.length_number is not None and self.dialect != "linuxcnc" and "tcp" not in self.foreign:
                self.set_length(lengths.get(int(h.value), 0.0), axis_words)
            if h:
                self.code("H", h.value)
            return
        self.code("length", code, h.value if h else None)
        if code == 49:
            self.end_tcp(axis_words, by_length=True)
            self.length, self.length_number = 0.0, None
            self.leave("tcp")
        elif code in (43, 44):
            self.lose_tcp()
            self.length_number = int(h.value) if h else 0
            self.length = lengths.get(self.length_number, 0.0) * (-1 if code == 44 else 1)
        elif code in (43.1, 43.2) and self.dialect == "linuxcnc":
            self.enter("tcp")  # a length that only the program's words or a table say
            self.raw("G43.x", [], axis_words, other, moves=False)
            axis_words.clear()
        elif (code in (43.4, 234) or (code == 43.5 and self.dialect != "haas")) and h:
            self.states_vectors = code == 43.5
            before = self.length
            self.end_tcp()
            self.length_number = int(h.value)
            self.length = lengths.get(self.length_number, 0.0)
            self.begin_tcp(axis_words, by_length=before != self.length)
        else:
            self.end_tcp()
            self.enter("tcp")
            self.length_number = int(h.value) if h else 0

    def set_length(self, length, named):
        changes = self.tcp and length != self.length
        self.length = length
        if changes:
            self.lose([a for a in self.linear if a not in named])
            self.opaque -= set(named)

    def modes(self, has, axis_words, other):
        """Modes in which axis words are no axis positions."""
        d = self.dialect
        if self.is_sinumerik:
            code = has(41, 42)
            if code:
                self.cutter_on(1 if code == 41 else -1, self.edge, self.plane == 17)
            if has(40):
                self.cutter_off()
            code = has(110, 111, 112)
            if code:  # a pole, for AP and RP alone
                self.raw("G%d" % code, [], dict(axis_words), list(other), moves=False)
                axis_words.clear()
            return
        code = has(41, 42, 41.1, 42.1, 41.2, 42.2)
        d_words = {} if d == "linuxcnc" and code not in (41, 42) else self.take(other, "D") if code or d != "linuxcnc" else {}
        for w in d_words.values():
            self.radius_number = int(w.value)
            self.code("D", w.value)
        if code in (41, 42):
            number = self.radius_number
            if d == "linuxcnc" and not d_words:
                number = None  # of the tool in the spindle
            self.code("comp", code)
            self.cutter_on(1 if code == 41 else -1, number, self.plane == 17)
        elif code:
            self.cutter, self.cutter_state = None, "off"
            self.enter("comp")
            self.code("comp", code, tuple((w.address, w.value) for w in self.take(other, "D").values()))
        if has(40):
            self.cutter_off()

        def mode(name, on, off, takes):
            code = has(*on)
            if code:
                self.enter(name)
                self.raw("G%g" % code, [], dict(axis_words), list(other), moves=False)
                axis_words.clear()
                del other[:]
            code = has(*off)
            if code:
                self.code("G%g" % code, tuple(sorted((a, v) for a, v in axis_words.items())) if takes else ())
                self.leave(name)
                if takes:
                    axis_words.clear()

        if d != "linuxcnc":
            self.placed_modes(has, axis_words, other)
            mode("tilt", (68, 68.2, 68.3, 68.4, 254, 268) if d == "haas" else (68, 68.2, 68.3, 68.4),
                 (69, 255, 269) if d == "haas" else (69, 69.1), False)
            if not self.setup.get("lathe"):
                mode("scale", (51,), (50,), False)
            mode("mirror", (51.1,), (50.1,), True)
            mode("modal call", (66, 66.1), (67,), False)
            if d != "haas":
                mode("polar", (16,), (15,), False)
                mode("polar interpolation", (12.1,), (13.1,), False)
                if has(7.1):
                    value = next(iter(axis_words.values()), (0,))[0]
                    (self.enter if value else self.leave)("cylinder")
                    self.raw("G7.1", [], dict(axis_words), list(other), moves=False)
                    axis_words.clear()
        else:
            if has(7):
                self.enter("diameter")
            if has(8):
                self.leave("diameter")

    def placed_modes(self, has, axis_words, other):
        """G68, G68.2, G51, G51.1, G254 with plain words, and their ends."""
        d, p = self.dialect, self.parameters(other)
        at = [axis_words[a][0] * self.unit(a) if a in axis_words else 0.0 for a in "XYZ"]
        named, letters = set(axis_words), set(p)
        is_plain = not self.incremental and named <= set("XYZ") and self.plane in (17, 18, 19)
        ends = {69: ("rotation", "tilt") if d != "haas" else ("rotation",), 269: ("tilt",), 50: ("scale",)}
        for code, modes in ends.items():
            if code == 50 and (axis_words or other):
                continue
            if (code != 269 or d == "haas") and has(code):
                for name in modes:
                    self.unturn(name)
                    self.untilt(name)
                self.code("G%g" % code, ())
                self.leave("tilt" if code != 50 else "scale")
        if d == "haas" and has(255):
            self.origin_moves = False
            self.code("G255")
            self.leave("tilt")
        for code in has_one(has, (68, 68.2, 51, 51.1) + ((268, 254, 101) if d == "haas" else ())):
            done = False
            if code == 68 and is_plain and self.plane == 17 and named == {"X", "Y"} and letters == {"R"}:
                done = self.turn("rotation", about("Z", p["R"]), [at[0], at[1], 0.0])
            elif code == 51 and is_plain and named == set("XYZ") and letters == {"P"}:
                done = self.turn("scale", along(*[p["P"]] * 3), at)
            elif code in (51.1, 101) and is_plain and named and named <= {"X", "Y"} and not letters and not self.inner:
                done = self.turn("mirror", along(*[-1.0 if a in named else 1.0 for a in "XYZ"]), at)
                self.mirrored = set(named)
            elif code == 68.2 and is_plain and letters == set("IJK"):
                euler = chain(chain(about("Z", p["I"]), about("X", p["J"])), about("Z", p["K"]))
                done = self.tilt("tilt", euler, at)
            elif code == 268 and is_plain and letters == set("IJK") and sum(1 for v in p.values() if v) <= 1:
                turned = chain(chain(about("X", p["I"]), about("Y", p["J"])), about("Z", p["K"]))
                done = self.tilt("tilt", turned, at)
            elif code == 254 and not named and not letters and len(self.rotary()) == 2 and not self.slope and not self.inner and not self.tcp:
                done = self.origin_moves = True
            if not done:
                self.enter({51: "scale", 51.1: "mirror", 101: "mirror"}.get(code, "tilt"))
                self.inner = self.inner_mode = self.slope = self.slope_mode = None
            self.raw("G%g" % code, [], dict(axis_words), list(other), moves=False)
            axis_words.clear()
            del other[:]
        if self.inner_mode == "mirror":
            for code in has_one(has, (50.1,) + ((100,) if d == "haas" else ())):
                self.code("G%g" % code, tuple(sorted(axis_words.items())))
                self.mirrored -= named or set("XYZ")
                self.unturn("mirror")
                if self.mirrored:
                    self.enter("mirror")
                axis_words.clear()

    mirrored = frozenset()
    motion_before = 80

    def work_offset(self, has, other):
        if self.is_sinumerik:
            code = has(*([500, 54, 55, 56, 57] + list(range(505, 600))))
            if code:
                self.wcs = "" if code == 500 else "G%d" % code
            return
        code = has(54, 55, 56, 57, 58, 59, 59.1, 59.2, 59.3)
        if code:
            self.wcs = "G%g" % code
        if self.dialect in ("fanuc", "mazak"):
            code = has(54.1)
        elif self.dialect == "haas":
            more = has(*range(110, 130))
            if more:
                self.wcs = "G%d" % more
            code = has(154)
        else:
            code = None
        if code:
            p = self.take(other, "P")
            self.wcs = "G%g P%d" % (code, int(p["P"].value))

    def data_input(self, axis_words, other):
        """G10 L2 P1 X..: the offset itself changes."""
        p = self.parameters(other)
        kind, number = p.get("L"), int(p.get("P", 0))
        plain = ["G54", "G55", "G56", "G57", "G58", "G59"]
        names = []
        if self.dialect == "linuxcnc":
            plain += ["G59.1", "G59.2", "G59.3"]
        if kind in (2, 20) and self.dialect == "linuxcnc":
            names = [self.wcs if number == 0 else plain[number - 1]]
        elif kind == 2 and number > 0:
            names = [plain[number - 1]]
        elif kind == 20:
            names = ["G54.1 P%d" % number]
            if self.dialect == "haas":  # G154 P1 to P20 are G110 to G129
                names = ["G154 P%d" % number] + ["G%d" % (109 + number)] * (number <= 20)
        for name in names:
            table = self.setup["offsets"].setdefault(name, {})
            for a, (v, _) in axis_words.items():
                value = v * self.unit(a)
                if kind == 20 and self.dialect == "linuxcnc":  # counted from where the control stands
                    value = self.pos[a] - value - self.preset[a] - self.shift[a] - (self.length if a == "Z" else 0.0)
                elif self.incremental and self.dialect != "linuxcnc":
                    value += table.get(a, 0.0)
                table[a] = value
        if not names:  # the external offset, tools
            self.enter("data")
        self.raw("G10", [], axis_words, other, moves=False)

    edge = 0  # D of Sinumerik
    radius_number = None

    block_flags = frozenset()

    def keywords(self, other, axis_words):
        """Words of more than one letter."""
        self.block_flags = set()
        for w in list(other):
            a = w.address
            if len(a) < 2 or a[0] == ",":
                continue
            if a in ("IF", "GOTO", "WHILE", "DO", "END"):
                raise Alarm("not read here: " + a)
            if a in ("DPRNT", "POPEN", "PCLOS", "MSG", "STOPRE", "FFWON", "SOFT", "BRISK", "CFTCP", "CYCLE832", "FGROUP",
                     "FNORM", "ORIAXES", "FLIN", "FCUB", "DYNNORM", "DYNFINISH", "G_"):
                self.code(a, w.value)
                other.remove(w)
            elif a in ("ORIVECT", "ORIWKS", "ORIMKS"):
                # The group of ORIAXES: how the tool turns under TRAORI. Axis by axis is what is followed here: what departs from
                # that is to be refused.
                self.code(a, w.value)
                other.remove(w)
            elif a in ("SUPA",):
                self.block_flags.add("machine")
                other.remove(w)
            elif a in ("TRAORI",):
                self.begin_tcp()
                self.code(a, w.value)
                other.remove(w)
            elif a == "TRAFOOF":
                self.code(a)
                self.leave("tcp")
                self.end_tcp()
                self.leave("transmit")
                other.remove(w)
            elif a in ("TRANSMIT", "TRACYL"):
                self.enter("transmit")
                self.code(a, w.value)
                other.remove(w)
            elif a in FRAMES:
                self.code(a, w.value, tuple(sorted(axis_words.items())))
                axis_words.clear()
                words = re.findall(r"([XYZABC])=?([-+]?(?:\d+\.?\d*|\.\d+))(?:\s+|$)", w.value.strip()[len(a):].strip() + " ")
                is_shift = a in ("TRANS", "ATRANS") and words and "".join(x + y for x, y in words) == \
                    re.sub(r"[\s=]", "", w.value.strip()[len(a):])
                turned = self.turned(a, w.value.strip()[len(a):])
                if turned is not None and "frame" not in self.foreign and \
                        (a[0] != "A" or not self.inner or self.inner_mode == "frame"):
                    if a[0] != "A":  # replaces all that frames stated
                        self.unturn("frame")
                        self.trans = {x: 0.0 for x in self.axes}
                    if not self.turn("frame", turned, [0.0] * 3, adds=True):
                        self.enter("frame")
                elif is_shift and a == "ATRANS" and self.inner_mode == "frame" and all(x in self.linear for x, _ in words):
                    shift = [sum(float(y) * self.unit(x) for x, y in words if x == axis) for axis in "XYZ"]
                    matrix, zero = self.inner
                    self.inner = (matrix, [z + v for z, v in zip(zero, times(matrix, shift))])
                elif w.value.strip() == a and a in ("TRANS", "ROT", "SCALE", "MIRROR"):  # alone: frames off
                    self.unturn("frame")
                    self.leave("frame")
                    self.trans = {x: 0.0 for x in self.axes}
                elif is_shift and not (a == "ATRANS" and "frame" in self.foreign):
                    if a == "TRANS":  # replaces all that frames stated
                        self.unturn("frame")
                        self.leave("frame")
                        self.trans = {x: 0.0 for x in self.axes}
                    for x, y in words:
                        self.trans[x] += float(y) * self.unit(x)
                else:
                    self.inner = self.inner_mode = None
                    self.enter("frame")
                other.remove(w)
            elif a == "CYCLE800":
                self.code(a, w.value)
                if w.value.replace(" ", "") == "CYCLE800()":
                    self.untilt("swivel")
                    self.frames_inside = False
                    self.leave("tilt")
                    self.lose(self.axes)
                elif self.swivelled(w.value):
                    pass
                else:
                    self.enter("tilt")
                    self.lose(self.axes)
                other.remove(w)
            elif re.fullmatch("CYCLE8[1-79]", a) and self.called(w.value) is not None:
                self.code(a, w.value)
                if self.plane == 17 and not self.incremental and not self.foreign and not self.tcp:
                    self.call_cycle(a, self.called(w.value), {}, ())
                else:
                    self.lose(self.axes)
                other.remove(w)
            elif a in ("HOLES1", "HOLES2") and self.modal_cycle and self.places(w.value) is not None and not self.foreign and \
                    not self.tcp and self.plane == 17 and not self.incremental and not self.inch and self.motion in (0, 1):
                for x, y in self.places(w.value):
                    self.call_cycle("MCALL", self.modal_cycle, {"X": (x, False), "Y": (y, False)}, (x, y))
                other.remove(w)
            elif a.startswith(("CYCLE", "POCKET", "HOLES", "SLOT")):
                self.code(a, w.value)
                self.lose(self.axes)
                other.remove(w)
            elif a == "MCALL":
                rest = w.value.replace(" ", "")
                self.code(a, rest)
                call = re.fullmatch(r"MCALL(CYCLE8[1-79])(\(.*\))", rest)
                self.modal_cycle = self.called(rest[5:]) if call and "modal call" not in self.foreign else None
                (self.leave if rest == "MCALL" or self.modal_cycle else self.enter)("modal call")
                other.remove(w)
            elif re.fullmatch(r"L\d+|[A-Z_]\w*", a) and a not in ("CR", "FRC", "FRCM", "RND", "CHF", "CHR", "RNDM", "ADIS", "SPOS",
                                                                 "AP", "RP", "ANG", "AR", "TURN", "CT", "CIP", "A3", "B3", "C3"):
                self.code("call", a)
                self.lose(self.axes)
                other.remove(w)

    def turned(self, name, text):
        """The matrix of ROT Z30, ROT RPL=30, MIRROR X0, SCALE X2 and those that add; None: it turns the plane, or is no plain
        number."""
        words = re.findall(r"(RPL|[XYZ])\s*=?\s*([-+]?(?:\d+\.?\d*|\.\d+))(?:\s+|$)", text.strip() + " ")
        if not words or "".join(x + y for x, y in words) != re.sub(r"[\s=]", "", text):
            return None
        values = {x: float(y) for x, y in words}
        kind = name[1:] if name[0] == "A" else name
        if kind == "ROT" and (self.plane == 17 or "RPL" not in values) and not values.get("X") and not values.get("Y"):
            return about("Z", values.get("RPL", values.get("Z", 0.0)))
        if kind == "MIRROR" and "Z" not in values:
            return along(*[-1.0 if a in values else 1.0 for a in "XYZ"])
        if kind == "SCALE":
            return along(*[values.get(a, 1.0) for a in "XYZ"])
        return None

    def swivelled(self, text):
        """CYCLE800(retraction, record, status, mode, X0, Y0, Z0, A, B, C, X1, Y1, Z1, direction): axis by axis, new."""
        arguments = [v.strip() for v in text[text.index("(") + 1:text.rindex(")")].split(",")] + [""] * 14
        try:
            n = [0.0 if i == 1 or not v else float(v) for i, v in enumerate(arguments[:14])]
        except ValueError:
            return False
        mode = int(n[3])
        if self.inch or mode > 63 or n[2] % 10 or any(self.trans.values()) or self.foreign:
            return False
        matrix = along()
        for k in range(3):
            axis = (mode >> 2 * k) & 3
            if axis:
                matrix = chain(matrix, about(" XYZ"[axis], n[7 + k]))
        at = [a + b for a, b in zip(n[4:7], times(matrix, n[10:13]))]
        if not self.tilt("swivel", matrix, at):
            return False
        self.frames_inside = True
        if n[13]:
            self.lose(self.linear)  # it retracts
            self.turn_to_plane()
        return True

    # -- moves
    def raw(self, name, g, axis_words, other, moves=True):
        event = self.emit("raw")
        event.key = (name, tuple(sorted(g)), tuple(sorted(self.foreign)),
                     tuple(sorted((a, round(v, 9), how or "") for a, (v, how) in axis_words.items())),
                     tuple(sorted((w.address, w.value, w.how or "") for w in other)), self.incremental, self.inch)
        return event

    def act(self, axis_words, other):
        corner = self.take(other, ",R", ",C", "RND", "CHF", "CHR", "ADIS")
        all_corners = self.take(other, "RNDM", "FRCM")
        if "RNDM" in all_corners:
            self.corner_all = all_corners["RNDM"].value * self.length_unit() or None
        if "FRCM" in all_corners:
            self.corner_feed_all = all_corners["FRCM"].value * self.length_unit() or None
        frc = self.take(other, "FRC").get("FRC")
        corner_feed = frc.value * self.length_unit() or None if frc else self.corner_feed_all
        for address, w in self.take(other, "SPOS").items():
            self.code(address, w.value)
        has_centre = any(w.address in ("I", "J", "K", "R", "CR") for w in other)
        has_vector = self.tcp and any(w.address in (("A3", "B3", "C3") if self.is_sinumerik else ("I", "J", "K")) for w in other)
        if not axis_words and not has_vector and not (self.motion in (2, 3) and has_centre):
            for address, w in corner.items():
                self.code(address, w.value)
            for w in other:
                self.code(w.address, w.value)
            return
        sin = self.is_sinumerik
        words = {}
        self.how = {a: how for a, (_, how) in axis_words.items()}
        for a, (value, how) in axis_words.items():
            incremental = self.incremental if how is None else how == "IC"
            words[a] = (value, incremental)
        self.vector = self.tool_vector(other)
        turned = [a for a in words if a not in self.linear]
        if self.tcp and turned and (self.vector or (self.states_vectors and not self.is_sinumerik)):
            self.raw("rotary words and a vector", [self.motion], axis_words, other)
            self.lose(self.axes)
            return
        special = [w for w in other if w.address in ("AP", "RP", "ANG", "AR", "TURN", "I1", "J1", "K1")]
        if "machine" in self.block_flags:
            if any(isinstance(v, str) for v, _ in axis_words.values()):
                self.code("machine", self.motion, tuple(sorted(axis_words.items())))
                self.lose(self.axes)
                return
            self.raw("machine", [self.motion], axis_words, other)
            for a, (v, how) in axis_words.items():
                self.pos[a] = v * self.unit(a) if how != "IC" else self.pos[a] + v * self.unit(a)
                self.opaque.discard(a)
                self.unsure.add(a)
            if self.tcp:
                self.lose(self.axes)
            return
        if self.modal_cycle and not special and not self.foreign and not self.tcp and self.motion == 0 and self.plane == 17 and \
                not self.incremental:
            above = {a: v for a, v in words.items() if a == "Z"}
            raw = tuple(sorted((a, round(v, 9), i) for a, (v, i) in words.items()))
            if above:
                place = dict(self.standing())
                place["Z"] = above["Z"][0] * self.unit("Z") + (place["Z"] if above["Z"][1] else self.offset("Z"))
                frame = self.words_frame()
                self.pos.update(frame.to_axes(place, self.length) if frame else place)
            self.call_cycle("MCALL", self.modal_cycle, {a: v for a, v in words.items() if a != "Z"}, raw)
            return
        if self.modal_cycle:
            self.raw("MCALL", [self.motion], axis_words, other)
            self.lose(self.axes)
            return
        if self.cycle and not special and not self.foreign and not self.tcp and self.drills(axis_words, other):
            return
        if self.cycle or special or self.motion in (33,):
            self.raw("cycle %s" % self.cycle, [self.motion], axis_words, other)
            for a, (v, inc) in words.items():
                if a not in ("Z",):
                    self.pos[a] = self.target(a, v, inc)
            self.lose(["Z"] if not special else self.linear)
            return
        if self.foreign or (self.tcp and self.motion in (2, 3)):
            self.raw("mode", [self.motion], axis_words, other)
            if self.tcp:
                self.lose(self.linear)
                return
            for a, (v, inc) in words.items():
                self.pos[a] = self.target(a, v, inc)
            return
        if self.motion == 80:
            raise Alarm("axis words while G80 is in force")
        if self.motion in (0, 1):
            if other and any(w.address in ("I", "J", "K", "R", "CR") for w in other):
                raise Alarm("I, J, K or R in a straight move")
            event = self.straight(words)
        else:
            event = self.arc(words, other)
        for w in other:
            if w.address not in ("I", "J", "K", "R", "CR", "P", "L"):
                self.code(w.address, w.value)
        made = [a for a in ("RND", "CHF", "CHR") if a in corner]
        if made or self.corner_all:  # what the control makes of it: corners.py
            kind, size = (made[0], corner[made[0]].value * self.length_unit()) if made else ("RND", self.corner_all)
            event.corner = (kind, size, self.plane, corner_feed, bool(made))
        event.words += tuple(sorted((a, w.value) for a, w in corner.items() if a not in made))

    def tool_vector(self, other):
        """I, J and K of G43.5, A3=, B3= and C3= of Sinumerik; its words are taken out of the block."""
        names = ("A3", "B3", "C3") if self.is_sinumerik else ("I", "J", "K") if self.states_vectors else ()
        if not self.tcp or self.foreign or self.motion not in (0, 1) or not any(w.address in names for w in other):
            return None
        words = self.take(other, *names)
        return [words[n].value if n in words else 0.0 for n in names]

    modal_cycle = None

    def called(self, text):
        """Heights of CYCLE81(RTP, RFP, SDIS, DP, DPR): where it feeds from and to, and where it retracts to (axis positions)."""
        match = re.fullmatch(r"(?:CYCLE8\d)?\s*\(([-+.,\d\s]*)\)", text.strip())
        if not match or self.inch:  # under G70 the arguments may be in the machine's unit
            return None
        a = [v.strip() for v in match.group(1).split(",")] + [""] * 5
        number = [float(v) if v else None for v in a[:5]]
        if number[0] is None or number[1] is None or (number[3] is None and number[4] is None):
            return None
        depth = number[3] if number[3] is not None else number[1] - abs(number[4])
        heights = [number[1] + abs(number[2] or 0.0), depth, number[0]]
        return [h * self.length_unit() + self.offset("Z") for h in heights]

    def places(self, text):
        """Of HOLES1(SPCA, SPCO, STA1, FDIS, DBH, NUM), a row from its nearer end on, and HOLES2(CPA, CPO, RAD, STA1, INDA, NUM)."""
        match = re.fullmatch(r"HOLES([12])\s*\(([-+.,\d\s]*)\)", text.strip(), re.I)
        n = [float(v) if v.strip() else 0.0 for v in match.group(2).split(",")] if match else []
        if len(n) != 6 or n[5] < 1 or n[5] != int(n[5]):
            return None
        if match.group(1) == "1":
            c, s = math.cos(math.radians(n[2])), math.sin(math.radians(n[2]))
            found = [(n[0] + (n[3] + i * n[4]) * c, n[1] + (n[3] + i * n[4]) * s) for i in range(int(n[5]))]
            here = [self.standing()[a] - self.offset(a) for a in "XY"]
            if self.opaque & {"X", "Y"}:
                return found
            return found[::-1] if math.dist(here, found[-1]) < math.dist(here, found[0]) - 1e-6 else found
        turns = [math.radians(n[3] + i * (n[4] or 360.0 / n[5])) for i in range(int(n[5]))]
        return [(n[0] + n[2] * math.cos(t), n[1] + n[2] * math.sin(t)) for t in turns]

    def call_cycle(self, name, heights, words, raw):
        entry, bottom, level = heights
        self.hole(("called", name), words, raw, entry, bottom, level)
        self.opaque.discard("Z")
        self.unsure.discard("Z")

    # Cycles that feed along Z between R and Z, by the manuals of all these controls. Of the others (boring by hand, back
    # boring, threads of lathes), of G91 and of other planes they say different things.
    DRILLING = {73, 74, 76, 81, 82, 83, 84, 85, 86, 89}

    def drills(self, axis_words, other):
        d = self.dialect
        if self.is_sinumerik or self.incremental or self.plane != 17 or self.feed_mode == 93 or \
                self.cycle not in self.DRILLING - ({76} if d == "linuxcnc" else set()) or \
                set(axis_words) - {"X", "Y", "Z"} or any(how for _, how in axis_words.values()):
            return False
        p = self.parameters(other)
        if "R" in p:
            self.cycle_r = p["R"] * self.length_unit() + self.offset("Z")
        if "Z" in axis_words:
            self.cycle_z = axis_words["Z"][0] * self.unit("Z") + self.offset("Z")
        if self.cycle_r is None or self.cycle_z is None:
            raise Alarm("a drilling cycle without R or Z")
        repeats = p.get("L", p.get("K", 1) if d in ("fanuc", "mazak") else 1)
        rest = tuple(sorted((a, v) for a, v in p.items() if a != "R"))
        if repeats == 0:
            self.code("cycle data", self.cycle, rest)
            return True
        level = self.cycle_r if self.return_level == 99 else self.cycle_level
        if d == "linuxcnc":
            level = max(level, self.cycle_r)
        words = {a: (v, False) for a, (v, _) in axis_words.items() if a != "Z"}
        raw = (tuple(sorted((a, round(v, 9)) for a, (v, _) in axis_words.items())), p.get("R"))
        self.hole(("cycle", self.cycle, rest, self.return_level), words, raw, self.cycle_r, self.cycle_z, level)
        known = self.return_level == 99 or self.level_is_known
        (self.opaque.discard if known else self.opaque.add)("Z")
        self.unsure.discard("Z")
        return True

    def straight(self, words):
        raw = ("straight",)
        rapid = self.motion == 0
        return self.move_(words, rapid, None, raw)

    def move_(self, words, rapid, arc, raw):
        event = self.move(words, rapid, arc, raw)
        for a in words:  # a modulo axis counts from 0 to 360 deg again
            if self.how.get(a) in ("DC", "ACP", "ACN"):
                self.pos[a] = words[a][0] + self.offset(a)
        return event

    def arc(self, words, other):
        first, second, i, j = PLANES[self.plane]
        unit = self.length_unit()
        p = {}
        for w in other:
            if w.address in ("I", "J", "K", "R", "CR"):
                p[w.address] = (w.value * unit, w.how)
        radius = p.pop("CR" if self.is_sinumerik else "R", None)
        raw = ("arc", self.motion, self.plane,
               tuple(sorted((w.address, w.value, w.how or "") for w in other if w.address in ("I", "J", "K", "R", "CR"))))
        if radius is not None:
            if p:
                raise Alarm("centre and radius")
            return self.move_(words, False, (first, second, radius[0], self.motion == 2), raw)
        if not p:
            raise Alarm("arc without centre")
        centre = []
        for axis, letter in ((first, i), (second, j)):
            value, how = p.pop(letter, (None, None))
            if how == "AC" or (self.centre_absolute and how is None):
                if value is None:
                    raise Alarm("absolute centre without " + letter)
                centre.append(value + self.offset(axis))
            else:
                centre.append(self.standing()[axis] + (value or 0.0))
        if p and not self.is_sinumerik:
            raise Alarm("centre word of another plane")
        return self.move_(words, False, (first, second, tuple(centre), self.motion == 2), raw)

    def target(self, axis, value, incremental):
        how = self.how.get(axis) if self.is_sinumerik else None
        if how in ("DC", "ACP", "ACN"):
            goal = value + self.offset(axis)
            travel = math.fmod(goal - self.pos[axis], 360.0)
            if travel < 0:
                travel += 360.0
            if (how == "ACN" and travel) or (how == "DC" and travel > 180.0):
                travel -= 360.0
            return self.pos[axis] + travel
        return super().target(axis, value, incremental)

    how = {}

    def minutes(self, event):
        if self.feed_mode == 93:
            return super().minutes(event)
        if self.dialect != "linuxcnc" or self.feed_mode != 94 or self.feed <= 0:
            return None
        # LinuxCNC, "Feed Rate": of XYZ where one of them moves, else of UVW, else of the rotary axes in degrees.
        xyz = self.path_length(event)
        if xyz > 0:
            return xyz / self.feed
        turn = math.sqrt(sum((event.end[a] - event.start[a]) ** 2 for a in self.axes if a not in self.linear))
        return turn / (self.feed / self.length_unit())


def has_one(has, codes):
    code = has(*codes)
    return [code] if code is not None else []


FRAMES = ("TRANS", "ATRANS", "ROT", "AROT", "ROTS", "AROTS", "SCALE", "ASCALE", "MIRROR", "AMIRROR")
