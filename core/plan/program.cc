#include "core/plan/program.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/plan/overrun.h"

namespace axiscal::plan {
namespace {

struct Style {
  std::string name;
  std::string head, tail;
  std::string timed_begin, timed_end;  // around blocks of inverse-time feed; empty: there is none
  std::string (*dwell)(double seconds);
  std::string comment_begin, comment_end;
  bool is_klartext = false;
};

const std::vector<Style>& Styles() {
  const auto milliseconds = [](double s) {
    return absl::StrFormat("G04 P%d", static_cast<int>(std::lround(1000.0 * s)));
  };
  const auto seconds = [](double s) { return absl::StrFormat("G04 P%.3f", s); };
  const auto f_seconds = [](double s) { return absl::StrFormat("G4 F%.3f", s); };
  const auto none = [](double) { return std::string("STOP"); };
  static const auto& styles = *new std::vector<Style>{
      {"fanuc", "G21 G40 G49 G80 G90 G94\n", "M30\n%\n", "G93", "G94", milliseconds, "(", ")"},
      {"mazak", "G21 G40 G49 G80 G90 G94\n", "M30\n%\n", "G93", "G94", milliseconds, "(", ")"},
      {"haas", "G21 G40 G49 G80 G90 G94\n", "M30\n%\n", "G93", "G94", milliseconds, "(", ")"},
      {"linuxcnc", "G21 G40 G49 G80 G90 G94\n", "M2\n", "G93", "G94", seconds, "(", ")"},
      {"sinumerik", "G71 G40 G90 G94\n", "M30\n", "G93", "G94", f_seconds, "; ", ""},
      {"heidenhain", "", "", "", "", none, "; ", "", true},
  };
  return styles;
}

std::string Position(double position) { return absl::StrFormat("%.4f", position + 0.0); }

// Where axes first go so that row `row` is approached from the side that its sense states: per axis what is added to
// its position, mm or deg. Empty where the move from the row before comes from there anyway. FAILED_PRECONDITION where
// an axis has no room.
absl::StatusOr<std::vector<double>> Overrun(const machine::Machine& machine,
                                            const std::vector<const session::Column*>& columns,
                                            const std::vector<const session::Column*>& senses, size_t row) {
  std::vector<double> beyond(columns.size(), 0.0);
  bool is_any = false;
  for (size_t i = 0; i < columns.size(); ++i) {
    if (senses[i] == nullptr || senses[i]->values[row] == 0.0) continue;
    const double moved = row > 0 ? columns[i]->values[row] - columns[i]->values[row - 1] : 0.0;
    if (moved * senses[i]->values[row] > 0.0) continue;
    const machine::Axis& axis = machine.axes[i];
    const double unit = axis.kind == machine::AxisKind::kRotary ? base::kRadPerDeg : 1.0;
    beyond[i] = -senses[i]->values[row] * OverrunOf(axis) / unit;
    const double to = (columns[i]->values[row] + beyond[i]) * unit;
    if ((axis.min_position && to < *axis.min_position) || (axis.max_position && to > *axis.max_position))
      return absl::FailedPreconditionError(absl::StrFormat(
          "row %d: %s must go to %.4f and back to be approached from the stated side, beyond its travel", row + 1,
          axis.name, to / unit));
    is_any = true;
  }
  if (!is_any) beyond.clear();
  return beyond;
}

// Text that a controller takes as a comment, whatever a session is called.
std::string Plain(const std::string& text) {
  std::string plain;
  for (const char c : text) plain += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.' ? c : ' ';
  return plain;
}

bool IsOfSetter(const std::string& instrument) { return instrument == "tool-setter" || instrument == "tool-curve"; }

absl::StatusOr<std::string> ProbingProgram(const machine::Machine& machine, const session::Session& session,
                                           const Style& style, const ProgramOptions& options) {
  const bool is_linuxcnc = style.name == "linuxcnc", is_sinumerik = style.name == "sinumerik";
  if (style.is_klartext) {
    return absl::FailedPreconditionError(
        "dialect 'heidenhain' logs touches (TCH PROBE 4) only through FN 16 and a mask file of its own, which is not "
        "written, expected fanuc, mazak, haas, linuxcnc or sinumerik: write the plan (-o FILE.csv), touch its lines "
        "with the control's own cycle, and read its log with axiscal reduce --plan FILE.csv");
  }
  for (const machine::Axis& axis : machine.axes) {
    if (axis.name.size() != 1) return absl::FailedPreconditionError("axis " + axis.name + " has no word of one letter");
  }
  const ProbeDialect dialect = is_linuxcnc    ? ProbeDialect{"G38.2", TouchLog::kOfTheControl}
                               : is_sinumerik ? ProbeDialect{"MEAS=1 G01", TouchLog::kSinumerik}
                                              : ProbeDialect{};
  const std::string instrument = session::FindHeader(session, "instrument").value_or("");
  const bool is_of_touches = instrument == "touch", is_of_setter = IsOfSetter(instrument);
  const SpindleWords words = is_sinumerik ? SpindleWords{"SPOS=", "M00"} : SpindleWords{};
  ASSIGN_OR_RETURN(const std::string blocks,
                   is_of_setter    ? SetterBlocks(machine, session, options.setter, dialect, words)
                   : is_of_touches ? TouchBlocks(machine, session, options.probing, dialect)
                                   : ProbingBlocks(machine, session, options.probing, dialect));
  const std::string name = Plain(session::FindHeader(session, "session").value_or("session"));
  const size_t touches = session.reading_count() * (is_of_touches || is_of_setter ? 1 : kTouchesPerCentre);
  const auto comment = [&](const std::string& text) { return style.comment_begin + text + style.comment_end + "\n"; };
  const std::string comments =
      comment("MEASURING RUN " + name + " OF MACHINE " + Plain(machine.id)) +
      comment(is_of_setter ? "AXIS POSITIONS: NO WORK OFFSET. NO TOOL LENGTH"
                           : "AXIS POSITIONS: NO WORK OFFSET. NO TOOL LENGTH. SPINDLE HELD") +
      comment(is_of_setter ? "CHECK THE WAY TO THE BEAM. AT EACH STOP: MOUNT THE NEXT ROD OF THE PLAN"
                           : "CHECK THE WAY BETWEEN POSES");
  const std::string kind = is_of_setter ? "TRIGGER" : is_of_touches ? "TOUCH" : "SPHERE";
  if (is_linuxcnc) {
    // No '%': within a program that has one, LinuxCNC reads nothing else.
    return absl::StrCat(comments, style.head, "(PROBEOPEN ", name, ".txt)\n", blocks, "(PROBECLOSE)\n", style.tail);
  }
  if (is_sinumerik) {
    // Definitions stand before any other block. A touch that finds nothing ends the run: the next way down is not safe.
    return absl::StrCat(
        comments,
        comment("PROBE ON MEASURING INPUT 1, SPRINT NEEDED; WRITE APPENDS: MOVE AN OLD AXISCAL_LOG AWAY FIRST"),
        "DEF INT ERR\nDEF STRING[32] LOG=\"AXISCAL_LOG\"\n", style.head, "WRITE(ERR,LOG,\"Number of Points ", touches,
        "\")\nWRITE(ERR,LOG,\"Feature Model ", kind, "\")\n", blocks, "M30\nNO_TOUCH:\nMSG(\"NO TOUCH\")\nM0\n",
        style.tail);
  }
  return absl::StrCat("%\nO1000\n", comments, style.head, "POPEN\nDPRNT[Number*of*Points*", touches,
                      "]\nDPRNT[Feature*Model*", kind, "]\n", blocks, "PCLOS\n", style.tail);
}

}  // namespace

const std::vector<std::string>& ProgramDialects() {
  static const auto& names = *[] {
    auto* all = new std::vector<std::string>;
    for (const Style& style : Styles()) all->push_back(style.name);
    return all;
  }();
  return names;
}

absl::StatusOr<std::string> ToProgram(const machine::Machine& machine, const session::Session& session,
                                      const ProgramOptions& options) {
  const auto style =
      std::find_if(Styles().begin(), Styles().end(), [&](const Style& s) { return s.name == options.dialect; });
  if (style == Styles().end()) {
    return absl::InvalidArgumentError("dialect '" + options.dialect +
                                      "', expected one of fanuc, mazak, haas, linuxcnc, sinumerik, heidenhain");
  }
  if (!(options.feed_mm_min > 0.0 && options.feed_mm_min <= 1e5))
    return absl::InvalidArgumentError(
        absl::StrFormat("feed_mm_min = %g, expected above 0 to 1e5", options.feed_mm_min));
  if (!(options.dwell_s >= 0.0 && options.dwell_s <= 3600.0))
    return absl::InvalidArgumentError(absl::StrFormat("dwell_s = %g, expected 0 to 3600", options.dwell_s));
  const std::string instrument = session::FindHeader(session, "instrument").value_or("");
  if (instrument == "centres" || instrument == "touch" || IsOfSetter(instrument))
    return ProbingProgram(machine, session, *style, options);
  std::vector<const session::Column*> columns, senses;
  std::vector<std::string> words;
  for (const machine::Axis& axis : machine.axes) {
    const std::string name = axis.name + (axis.kind == machine::AxisKind::kRotary ? "_deg" : "_mm");
    const session::Column* const column = session::FindColumn(session, name);
    if (column == nullptr) return absl::InvalidArgumentError("the session has no column " + name);
    if (axis.name.size() != 1)
      return absl::FailedPreconditionError("axis " + axis.name + " has no word of one letter: write the table instead");
    columns.push_back(column);
    senses.push_back(session::FindColumn(session, axis.name + "_sense"));
    words.push_back(style->is_klartext && axis.name[0] >= 'A' ? " " + axis.name : " " + axis.name);
  }
  const session::Column* const time = session::FindColumn(session, "t_s");
  const bool is_timed = instrument == "ballbar" && time != nullptr;
  const std::string name = Plain(session::FindHeader(session, "session").value_or("session"));
  const std::string& open = style->comment_begin;
  const std::string& close = style->comment_end;

  std::string out;
  if (style->is_klartext) {
    absl::StrAppend(&out, "BEGIN PGM MEASURE MM\n");
  } else if (style->tail.back() == '\n' && style->tail.find('%') != std::string::npos) {
    absl::StrAppend(&out, "%\nO1000\n");
  }
  const auto comment = [&](const std::string& text) { absl::StrAppend(&out, open, text, close, "\n"); };
  comment("MEASURING RUN " + name + " OF MACHINE " + Plain(machine.id));
  comment("AXIS POSITIONS: NO WORK OFFSET. NO TOOL LENGTH. SPINDLE HELD");
  absl::StrAppend(&out, style->head);
  // `beyond`: per axis what is added to the row's position, mm or deg; empty: nothing.
  const auto block = [&](size_t row, const std::string& feed, const std::vector<double>& beyond = {}) {
    absl::StrAppend(&out, style->is_klartext ? "L" : "G01");
    for (size_t i = 0; i < columns.size(); ++i) {
      const std::string position = Position(columns[i]->values[row] + (beyond.empty() ? 0.0 : beyond[i]));
      absl::StrAppend(&out, words[i], style->is_klartext && position[0] != '-' ? "+" : "", position);
    }
    absl::StrAppend(&out, feed, "\n");
  };
  const std::string feed = absl::StrFormat(" F%.4g", options.feed_mm_min);
  const session::Column* const targets = session::FindColumn(session, "target");
  const auto is_reference = [&](size_t row) {
    return targets != nullptr && session::FindHeader(session, "reference " + targets->texts[row]).has_value();
  };
  for (size_t row = 0; row < session.reading_count(); ++row) {
    if (is_reference(row)) {  // a person turns the tracker to them while the machine stands
      block(row, feed);
      if (row > 0 && is_reference(row - 1)) continue;
      comment("MEASURE THE REFERENCE TARGETS OF THE PLAN. THEN START AGAIN");
      absl::StrAppend(&out, style->is_klartext ? "STOP" : "M00", "\n");
      continue;
    }
    const double seconds = is_timed && row > 0 ? time->values[row] - time->values[row - 1] : 0.0;
    if (is_timed && row == 1 && !style->timed_begin.empty()) absl::StrAppend(&out, style->timed_begin, "\n");
    const bool has_time = is_timed && row > 0 && seconds > 0.0 && !style->timed_begin.empty();
    ASSIGN_OR_RETURN(const std::vector<double> beyond, Overrun(machine, columns, senses, row));
    if (!beyond.empty()) block(row, feed, beyond);
    block(row, has_time ? absl::StrFormat(" F%.4f", 60.0 / seconds) : feed);
    if (!is_timed && options.dwell_s > 0.0) absl::StrAppend(&out, style->dwell(options.dwell_s), "\n");
  }
  if (is_timed && session.reading_count() > 1 && !style->timed_end.empty())
    absl::StrAppend(&out, style->timed_end, feed, "\n");
  absl::StrAppend(&out, style->is_klartext ? "END PGM MEASURE MM\n" : style->tail);
  return out;
}

std::string ToTable(const session::Session& session) {
  std::string out;
  for (const session::HeaderEntry& entry : session.header)
    absl::StrAppend(&out, "# ", entry.key, ": ", entry.value, "\n");
  for (size_t c = 0; c < session.columns.size(); ++c) absl::StrAppend(&out, c > 0 ? "," : "", session.columns[c].name);
  out += "\n";
  for (size_t row = 0; row < session.reading_count(); ++row) {
    for (size_t c = 0; c < session.columns.size(); ++c) {
      const session::Column& column = session.columns[c];
      absl::StrAppend(&out, c > 0 ? "," : "",
                      column.texts.empty() ? absl::StrFormat("%.10g", column.values[row]) : column.texts[row]);
    }
    out += "\n";
  }
  return out;
}

}  // namespace axiscal::plan
