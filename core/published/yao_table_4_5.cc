#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/instruments/eccentricity/eccentricity_bind.h"
#include "core/instruments/eccentricity/eccentricity_path.h"
#include "core/instruments/registry.h"
#include "core/published/sources.h"
#include "core/published/yao_machine.h"
#include "core/session/text.h"

namespace axiscal::published {
namespace {

using machine::Machine;
using session::Session;

// One of the four patterns with one tool, mean over its runs; mm. NaN where it was not measured.
struct Trace {
  double ex = NAN, ey = NAN, ez = NAN;
  double ex_sigma = 0, ey_sigma = 0, ez_sigma = 0;  // of the means, as stated
  double rb = NAN, rc = NAN, zc = NAN;  // levers: B's pivot to the tool ball, C's line and table to the table ball
  double zt = NAN, xt = NAN;            // as the header states them
};

struct Measured {
  std::map<std::string, Trace> traces;  // "BX" ... "CA"
  Trace cr_long;                        // CR with a tool of another length
};

// "BX" ... of a path, empty where the formulas know none like it.
std::string PatternOf(const Machine& machine, const eccentricity::Path& path) {
  constexpr double kTolerance = 1e-9;
  const bool is_quarter = std::abs(path.to_rad - path.from_rad - 90.0 * base::kRadPerDeg) < kTolerance;
  const bool is_turn = std::abs(path.to_rad - path.from_rad - 360.0 * base::kRadPerDeg) < kTolerance;
  const auto along = [&](double x, double y, double z) { return (path.bar - Eigen::Vector3d(x, y, z)).norm() < 1e-9; };
  for (const double angle : path.at_rest_rad) {
    if (angle != 0.0) return "";
  }
  const std::string& axis = machine.axes[path.axis].name;
  if (axis == "B" && is_quarter && path.from_rad == 0.0 && !path.is_turning)
    return along(1, 0, 0) ? "BX" : along(0, 1, 0) ? "BY" : "";
  if (axis == "C" && is_turn && path.is_turning) return along(-1, 0, 0) ? "CR" : "";
  if (axis == "C" && is_turn && !path.is_turning) return along(0, 0, 1) ? "CA" : "";
  return "";
}

double HeaderNumber(const Session& session, const std::string& key) {
  std::vector<double> numbers;
  const std::optional<std::string> text = session::FindHeader(session, key);
  return text && session::ParseNumbers(*text, &numbers) && numbers.size() == 1 ? numbers[0] : NAN;
}

Trace LeversOf(const Machine& machine, const Session& session, const instruments::MeasuringRun& run) {
  Trace trace;
  const Eigen::Vector3d pivot_mm = machine.axes[machine::FindAxis(machine, "B")].point_mm;
  const Eigen::Vector3d table_mm = machine.axes[machine::FindAxis(machine, "C")].point_mm;
  trace.rb = pivot_mm.z() - run.tip_mm.z();
  trace.rc = run.ball_mm.x() - table_mm.x();
  trace.zc = run.ball_mm.z() - table_mm.z();
  trace.zt = HeaderNumber(session, "zt_mm");
  trace.xt = HeaderNumber(session, "xt_mm");
  return trace;
}

// The formulas are printed for levers above zero.
absl::Status CheckLevers(const std::string& session, const std::string& pattern, const Trace& trace) {
  const bool is_of_c = pattern[0] == 'C';
  for (const auto& [name, what, lever_mm] :
       {std::tuple("R_B", "tool_tip_mm below the pivot of B", trace.rb),
        std::tuple("Rc", "table_ball_mm beside the line of C, along +x", is_of_c ? trace.rc : 1.0),
        std::tuple("Zc", "table_ball_mm above the point of C", is_of_c ? trace.zc : 1.0)}) {
    if (lever_mm > 0.0) continue;
    return absl::InvalidArgumentError(
        absl::StrFormat("session %s: %s of %s is %g mm, expected above 0: %s", session, name, pattern, lever_mm, what));
  }
  return absl::OkStatus();
}

absl::Status ReadTraces(const Machine& machine, const Session& session, Measured* measured) {
  const std::string name = session::FindHeader(session, "session").value_or("");
  if (session::FindHeader(session, "instrument").value_or("") != "eccentricity") {
    return absl::InvalidArgumentError("session " + name + ": expected instrument eccentricity");
  }
  ASSIGN_OR_RETURN(const instruments::MeasuringRun run, instruments::BindSession(session, machine));
  const session::Column* const runs = session::FindColumn(session, "run");
  for (const session::HeaderEntry& entry : session.header) {
    if (entry.key.rfind("path ", 0) != 0) continue;
    const std::string path_name = entry.key.substr(5);
    ASSIGN_OR_RETURN(const eccentricity::Path path, eccentricity::ParsePath(machine, path_name, entry.value));
    const std::string pattern = PatternOf(machine, path);
    if (pattern.empty()) continue;
    Trace trace = LeversOf(machine, session, run);
    RETURN_IF_ERROR(CheckLevers(name, pattern, trace));
    for (const auto& [column, into, sigma] :
         {std::tuple("ex_um", &trace.ex, &trace.ex_sigma), std::tuple("ey_um", &trace.ey, &trace.ey_sigma),
          std::tuple("ez_um", &trace.ez, &trace.ez_sigma)}) {
      const session::Column* const cells = session::FindColumn(session, column);
      double sum_um = 0.0;
      int count = 0;
      for (size_t row = 0; cells != nullptr && row < session.reading_count(); ++row) {
        if (runs->texts[row] != path_name || !std::isfinite(cells->values[row])) continue;
        sum_um += cells->values[row];
        ++count;
      }
      if (count == 0) continue;
      *into = base::kMmPerUm * sum_um / count;
      *sigma = run.sigma_mm / std::sqrt(count);
    }
    Trace& known = measured->traces[pattern];
    const bool is_first = std::isnan(known.rb);
    if (!is_first && (pattern != "CR" || known.rb == trace.rb)) {
      return absl::InvalidArgumentError(absl::StrCat("session ", name, ": ", pattern,
                                                     " is there twice, expected each pattern once and CR with two "
                                                     "tool lengths"));
    }
    if (is_first) {
      known = trace;
    } else {
      const bool is_longer = trace.rb > known.rb;
      measured->cr_long = is_longer ? trace : known;
      if (!is_longer) known = trace;
    }
  }
  return absl::OkStatus();
}

std::vector<Row> ByFormulas(const Measured& measured) {
  const auto of = [&](const char* pattern) {
    const auto found = measured.traces.find(pattern);
    return found == measured.traces.end() ? Trace() : found->second;
  };
  const Trace bx = of("BX"), by = of("BY"), cr = of("CR"), ca = of("CA"), &cr_long = measured.cr_long;
  constexpr double kArcsec = base::kArcsecPerRad, kUm = base::kUmPerMm;
  std::vector<Row> rows;
  const auto add = [&](const char* quantity, const char* unit, double published, double corrected, const char* symbol,
                       const char* formula, const char* erratum) {
    rows.push_back({quantity, unit, published, corrected, symbol, NAN, NAN, formula, erratum});
  };
  add("aCZ", "arcsec", kArcsec * -ca.ey / ca.rc, kArcsec * -ca.ey / ca.rc, "EA0C", "-eyCA / Rc", "");
  add("bCZ", "arcsec", kArcsec * ca.ex / ca.rc, kArcsec * ca.ex / ca.rc, "EB0C", "exCA / Rc", "");
  add("aXB", "arcsec", kArcsec * by.ez / by.rb, kArcsec * by.ez / by.rb, "EA0B", "ezBY / R_B", "");
  add("bXB", "arcsec", kArcsec * bx.ez / bx.rb, kArcsec * -bx.ez / bx.rb, "EB0B", "ezBX / R_B",
      "sign of bXB in BX (Table 2.6)");
  add("gXB", "arcsec", kArcsec * -by.ex / by.rb, kArcsec * -by.ex / by.rb, "EC0B", "-exBY / R_B", "");
  const double by_zt = (cr_long.ey - cr.ey) / (cr_long.zt - cr.zt), by_rb = (cr_long.ey - cr.ey) / (cr_long.rb - cr.rb);
  add("aBT", "arcsec", kArcsec * (by_zt - by.ez / by.rb), kArcsec * (-by_rb - by.ez / by.rb), "EA0T",
      "(ey'CR - eyCR) / (Zt' - Zt) - ezBY / R_B", "Zt for R_B");
  add("dxCZ - dxBT", "um", kUm * (-cr.ex + ca.zc * ca.ex / ca.rc - cr.zt * bx.ez / bx.rb),
      kUm * (cr.ex + bx.ez * cr.rb / bx.rb - ca.zc * ca.ex / ca.rc), "EX0C - EX0T",
      "-exCR + Zc exCA / Rc - Zt ezBX / R_B", "Zt for R_B; signs of bXB in BX and of bCZ in CR (Table 2.6)");
  add("dyCZ", "um",
      kUm * (ca.zc * ca.ey / ca.rc + (cr.zt * cr_long.ey - cr_long.zt * cr.ey) / (cr_long.zt - cr.zt) +
             cr.xt * by.ex / by.rb),
      kUm * (cr.ey - cr.rb * by_rb - ca.zc * ca.ey / ca.rc), "EY0C",
      "Zc eyCA / Rc + (Zt ey'CR - Zt' eyCR) / (Zt' - Zt) + Xt exBY / R_B",
      "Zt for R_B; Xt gXB for Xt gXY; sign of aCZ in CR (Table 2.6)");
  return rows;
}

// The formulas are linear in the eccentricities.
void AddPublishedSigma(const Measured& measured, std::vector<Row>* rows) {
  constexpr std::pair<double Trace::*, double Trace::*> kComponents[] = {
      {&Trace::ex, &Trace::ex_sigma}, {&Trace::ey, &Trace::ey_sigma}, {&Trace::ez, &Trace::ez_sigma}};
  Measured moved = measured;
  std::vector<Trace*> traces = {&moved.cr_long};
  for (auto& [pattern, trace] : moved.traces) traces.push_back(&trace);
  for (Row& row : *rows) row.published_sigma = 0.0;
  for (Trace* const trace : traces) {
    for (const auto& [component, sigma] : kComponents) {
      const double measured_mm = trace->*component;
      trace->*component += trace->*sigma;
      const std::vector<Row> there = ByFormulas(moved);
      trace->*component = measured_mm;
      for (size_t i = 0; i < rows->size(); ++i) {
        Row& row = (*rows)[i];
        row.published_sigma = std::hypot(row.published_sigma, there[i].published - row.published);
      }
    }
  }
}

// Why a printed formula has no number.
std::string Missing(const Row& row, const Measured& measured) {
  for (const char* const pattern : {"BX", "BY", "CR", "CA"}) {
    if (row.formula.find(pattern) != std::string::npos && measured.traces.count(pattern) == 0)
      return absl::StrCat("needs ", pattern);
  }
  if (row.formula.find('\'') != std::string::npos && std::isnan(measured.cr_long.rb))
    return "needs CR with a second tool length";
  if (std::isfinite(row.corrected)) return "needs the headers zt_mm and xt_mm";
  return "needs both components of each trace";
}

absl::Status AddExact(const Machine& machine, const std::vector<Session>& sessions, std::vector<Row>* rows) {
  identify::Options options;
  options.model.emplace();
  for (const char* const symbol : {"EZ0T", "EA0T", "EA0B", "EB0B", "EC0B", "EX0C", "EY0C", "EA0C", "EB0C"}) {
    ASSIGN_OR_RETURN(const machine::ErrorSymbol parsed, machine::ParseErrorSymbol(symbol));
    options.model->terms.push_back(machine::ConstantTerm(machine, parsed));
  }
  ASSIGN_OR_RETURN(const identify::Result result, identify::Identify(machine, sessions, options));
  for (Row& row : *rows) {
    const std::string symbol = row.symbol.substr(0, row.symbol.find(' '));  // EX0T is what EX0C stands for too
    for (const identify::Estimate& estimate : result.estimates) {
      if (estimate.name != symbol || !estimate.identifiable) continue;
      const double per_unit = row.unit == "um" ? base::kUmPerMm : base::kArcsecPerRad;
      row.exact = per_unit * estimate.value;
      row.sigma = per_unit * estimate.sigma;
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Comparison> YaoTable45(const Machine& machine, const std::vector<Session>& sessions) {
  RETURN_IF_ERROR(CheckYaoMachine(machine));
  Measured measured;
  for (const Session& session : sessions) RETURN_IF_ERROR(ReadTraces(machine, session, &measured));
  if (measured.traces.empty()) {
    return absl::InvalidArgumentError(
        "none of the paths is BX (B 0 90 fixed 1 0 0), BY (B 0 90 fixed 0 1 0), CR (C 0 360 turning -1 0 0) or CA (C "
        "0 360 fixed 0 0 1)");
  }
  Comparison out;
  out.rows = ByFormulas(measured);
  AddPublishedSigma(measured, &out.rows);
  RETURN_IF_ERROR(AddExact(machine, sessions, &out.rows));
  for (Row& row : out.rows) {
    if (!std::isfinite(row.published)) row.note = Missing(row, measured);
  }
  const Trace& cr = measured.traces["CR"];
  const double predicted_mm =
      cr.ex - (measured.cr_long.zt - cr.zt) * measured.traces["BX"].ez / measured.traces["BX"].rb;
  if (std::isfinite(predicted_mm) && std::isfinite(measured.cr_long.ex)) {
    out.notes.push_back(absl::StrFormat(
        "ex of CR with the longer tool is redundant: %.2f um predicted by the published formulas, %.2f um measured; "
        "no deviation of theirs explains the closure of %.2f um",
        base::kUmPerMm * predicted_mm, base::kUmPerMm * measured.cr_long.ex,
        base::kUmPerMm * (measured.cr_long.ex - predicted_mm)));
  }
  return out;
}

}  // namespace axiscal::published
