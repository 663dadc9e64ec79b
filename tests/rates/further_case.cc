#include "tests/rates/further_case.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <sstream>

#include "core/base/files.h"
#include "core/base/random.h"
#include "core/base/testing/source_path.h"
#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/logs/testing/planned_log.h"
#include "core/plan/testing/situations.h"
#include "core/session/read_session.h"
#include "core/synthetic/simulate.h"
#include "core/toolsetter/cutter.h"
#include "core/toolsetter/plan.h"

namespace axiscal::rates {
namespace {

using machine::Machine;
using session::Session;

std::vector<std::string> NamesOf(const std::string& instrument) { return {"all", "instrument " + instrument}; }

// --- Eccentricities: one mounting per rotary axis, the bar along each machine axis and turning along, both senses.

struct Runs {
  Session session;                      // zeros where a component is sensed
  std::vector<std::string> components;  // "ex_um", "ey_um"
};

Runs RunsOf(const Machine& machine, const machine::Axis& axis) {
  int along = 0;
  axis.direction.cwiseAbs().maxCoeff(&along);
  const int degrees = along == 2 ? 360 : 90;  // C turns round, A and B tilt
  std::string header = absl::StrCat("# machine: ", machine.id, "\n# session: runs-", axis.name,
                                    "\n# instrument: eccentricity\n# sigma_um: 0.3\n# tool_tip_mm: 0 0 -350\n"
                                    "# table_ball_mm: 40 0 60\n# bar_length_mm: 100\n");
  std::string rows = "run,sense,ex_um,ey_um,ez_um\n";
  const auto add = [&](const std::string& name, const char* how, int bar_along) {
    absl::StrAppend(&header, "# path ", name, ": ", axis.name, " 0 ", degrees, " ", how);
    for (int i = 0; i < 3; ++i) absl::StrAppend(&header, i == bar_along ? " 1" : " 0");
    header += "\n";
    for (const char* const sense : {"1", "-1"}) {
      absl::StrAppend(&rows, name, ",", sense);
      for (int i = 0; i < 3; ++i) rows += i == along ? "," : ",0";
      rows += "\n";
    }
  };
  for (int i = 0; i < 3; ++i) {
    const std::string direction(1, "XYZ"[i]);
    add(axis.name + direction, "fixed", i);
    if (i != along) add(axis.name + "-turning-" + direction, "turning", i);
  }
  Runs runs{session::ReadSessionText(header + rows, "runs.csv").value(), {}};
  for (int i = 0; i < 3; ++i) {
    if (i != along) runs.components.push_back(absl::StrCat("e", std::string(1, "xyz"[i]), "_um"));
  }
  return runs;
}

// As somebody types them off charts: a line per run and sense with the two components that it shows.
absl::StatusOr<Session> TypedOff(const Runs& runs, const Session& measured, const Machine& machine) {
  std::string rules;
  for (const session::HeaderEntry& entry : measured.header)
    absl::StrAppend(&rules, "# ", entry.key, ": ", entry.value, "\n");
  absl::StrAppend(&rules, "line: {run} {sense} {", runs.components[0], "} {", runs.components[1], "}\n");
  std::string log;
  for (size_t k = 0; k < session::FindColumn(measured, "run")->texts.size(); ++k) {
    absl::StrAppendFormat(&log, "%s %.0f", session::FindColumn(measured, "run")->texts[k],
                          session::FindColumn(measured, "sense")->values[k]);
    for (const std::string& component : runs.components)
      absl::StrAppendFormat(&log, " %.3f", session::FindColumn(measured, component)->values[k]);
    log += "\n";
  }
  std::istringstream in(log);
  ASSIGN_OR_RETURN(const logs::LogTemplate log_template, logs::ParseTemplate(rules, "charts.txt"));
  ASSIGN_OR_RETURN(logs::Reduced reduced, logs::Reduce(in, "charts.log", log_template, {.machine = &machine}));
  return std::move(reduced.session);
}

absl::Status IdentifyEccentricities(uint64_t seed, CoverageByKind* coverage) {
  const std::vector<Machine> machines = plan::testing::Machines();
  const Machine& machine = machines[seed % machines.size()];
  constexpr double kPlaceMm = 30e-3, kTiltRad = 70e-6;  // one standard deviation, as in planned_case.cc
  base::Random random(base::StreamSeed(seed, 0));
  machine::ErrorModel truth = machine::DeclaredModel(machine);
  for (machine::ErrorTerm& term : truth.terms)
    term.amplitude[0] = random.Normal() * (machine::IsAngle(term.component) ? kTiltRad : kPlaceMm);
  std::vector<Session> measured;
  for (const machine::Axis& axis : machine.axes) {
    if (axis.kind != machine::AxisKind::kRotary) continue;
    const Runs runs = RunsOf(machine, axis);
    synthetic::NoiseOptions noise;
    noise.seed = base::StreamSeed(seed, measured.size() + 1);
    ASSIGN_OR_RETURN(const Session read, synthetic::Simulate(machine, truth, runs.session, noise));
    ASSIGN_OR_RETURN(measured.emplace_back(), TypedOff(runs, read, machine));
  }
  identify::Options options;
  options.model = truth;
  for (machine::ErrorTerm& term : options.model->terms) term.amplitude.fill(0.0);
  ASSIGN_OR_RETURN(const identify::Fit fit, identify::FitSessions(machine, measured, options));
  AddResult(
      fit.result, truth, NamesOf("eccentricity"), [](const identify::Parameter*) { return "together"; }, coverage);
  return absl::OkStatus();
}

// --- The tool setter: the plan's file, the log with the readings alone, and the session that `reduce` makes of both.

absl::StatusOr<Session> ReducedOf(const std::string& table, const std::string& column,
                                  const std::vector<double>& readings) {
  ASSIGN_OR_RETURN(const Session plan, session::ReadPlanText(table, "plan.csv"));
  const session::Column read{column, readings, {}};
  ASSIGN_OR_RETURN(logs::Reduced reduced, logs::testing::ReduceText(logs::testing::LogOf({&read}, readings.size()),
                                                                    logs::testing::TemplateOf({&read}), nullptr, plan));
  return std::move(reduced.session);
}

// The beam is turned by what nobody knows, and each rod is longer than its certificate says, within its uncertainty.
absl::Status IdentifyBeam(uint64_t seed, CoverageByKind* coverage) {
  constexpr double kLengthSigmaMm = 2e-3, kTurnRad = 0.3 * base::kRadPerDeg;
  ASSIGN_OR_RETURN(
      Session rods,
      session::ReadSessionFile(base::SourcePath("/deploy/examples/fang-tool-setter/tool-setter-misaligned-1.csv")));
  for (const char* const name : {"standard", "rod-1", "rod-2"})
    rods.header.push_back({absl::StrCat("rod_sigma ", name), absl::StrCat("0 0 0 0 ", kLengthSigmaMm)});
  ASSIGN_OR_RETURN(const toolsetter::RodSession stated, toolsetter::ReadRodSession(rods));
  ASSIGN_OR_RETURN(const toolsetter::RodSession planned, toolsetter::PlanRods(stated, "rod-2", 12, 3));
  base::Random random(base::StreamSeed(seed, 0));
  toolsetter::Beam truth = planned.beam;
  truth.yaw_rad += kTurnRad * random.Normal();
  truth.pitch_rad += kTurnRad * random.Normal();
  const double reference_mm = -510.0 + random.Normal();
  std::map<std::string, double> longer_mm;  // by body
  std::vector<double> readings;
  for (const toolsetter::MeasuredRod& rod : planned.rods) {
    const auto [longer, is_new] = longer_mm.try_emplace(rod.body(), 0.0);
    if (is_new) longer->second = kLengthSigmaMm * random.Normal();
    ASSIGN_OR_RETURN(const toolsetter::Trigger trigger, toolsetter::TriggerOf(rod.rod, truth));
    for (size_t k = 0; k < rod.readouts_mm.size(); ++k) {
      readings.push_back(reference_mm + rod.rod.length_mm + longer->second + trigger.height_mm +
                         planned.sigma_mm * random.Normal());
    }
  }
  ASSIGN_OR_RETURN(const Session session, ReducedOf(toolsetter::ToTable(rods, planned), "Z_mm", readings));
  ASSIGN_OR_RETURN(const toolsetter::RodSession read, toolsetter::ReadRodSession(session));
  ASSIGN_OR_RETURN(const toolsetter::Reference found, toolsetter::FitReference(read, {true, true}));
  const double truths[] = {reference_mm, truth.yaw_rad, truth.pitch_rad};
  for (int i = 0; i < toolsetter::kReferenceParameters; ++i) {
    const toolsetter::Fitted& one = found.parameters[static_cast<size_t>(i)];
    if (!one.is_identifiable || !found.has_interval[static_cast<size_t>(i)]) continue;
    Count(one.estimate - truths[i], one.sigma, found.coverage_factor, NamesOf("tool-setter"), coverage);
  }
  return absl::OkStatus();
}

// Each insert is worn by something, the tool stands in the spindle somehow.
absl::Status IdentifyWear(uint64_t seed, CoverageByKind* coverage) {
  constexpr double kSigmaMm = 1e-3, kLengthMm = 176.641;
  const std::string file = base::SourcePath("/deploy/examples/fang-round-insert/cutter.json");
  ASSIGN_OR_RETURN(const toolsetter::CutterDescription cutter, toolsetter::ReadCutterFile(file));
  ASSIGN_OR_RETURN(const std::string cutter_json, base::ReadFile(file, 1 << 20));
  toolsetter::CurveSession session;
  session.session = "starts";
  session.sigma_mm = kSigmaMm;
  session.start_sigma_rad = toolsetter::kUsualStartSigmaDeg * base::kRadPerDeg;
  session.cutter = cutter.cutter;
  session.run = cutter.run;
  ASSIGN_OR_RETURN(const toolsetter::CurveSession planned, toolsetter::PlanStarts(session, 12));
  base::Random random(base::StreamSeed(seed, 0));
  std::vector<double> wear_mm(static_cast<size_t>(planned.cutter.inserts), 0.0);
  for (size_t k = 1; k < wear_mm.size(); ++k) wear_mm[k] = 1e-3 + 3e-3 * random.Uniform();
  // Inserts look alike: which is the first one is known as long as it stands nearer to its place than to another's.
  const double apart_rad = 2.0 * std::numbers::pi / planned.cutter.inserts;
  const double phase_rad = 0.6 * apart_rad * (random.Uniform() - 0.5);
  std::vector<double> starts_rad;
  for (const double start_rad : planned.starts_rad)
    starts_rad.push_back(start_rad + phase_rad + planned.start_sigma_rad * random.Normal());
  ASSIGN_OR_RETURN(const std::vector<toolsetter::CurvePoint> curve,
                   toolsetter::ComputeCurve(planned.cutter, planned.run, wear_mm, starts_rad));
  std::vector<double> readings;
  for (const toolsetter::CurvePoint& point : curve)
    readings.push_back(kLengthMm + point.height_mm + kSigmaMm * random.Normal());
  ASSIGN_OR_RETURN(const std::string table, toolsetter::ToTable(cutter_json, "mt", "starts", planned));
  ASSIGN_OR_RETURN(const Session reduced, ReducedOf(table, "length_mm", readings));
  ASSIGN_OR_RETURN(const toolsetter::CurveSession read, toolsetter::ReadCurveSession(reduced));
  ASSIGN_OR_RETURN(const toolsetter::WearReport found, toolsetter::FitWear(read));
  Count(found.length_mm - kLengthMm, found.length_sigma_mm, found.coverage_factor, NamesOf("tool-curve"), coverage);
  // The longest one has 0 by definition. Where noise makes another one the longest, both differ by what they differ.
  size_t longest = 0;
  for (size_t k = 0; k < found.inserts.size(); ++k) {
    if (found.inserts[k].is_identifiable && found.inserts[k].sigma_mm == 0.0) longest = k;
  }
  for (size_t k = 0; k < found.inserts.size(); ++k) {
    const toolsetter::InsertWear& insert = found.inserts[k];
    if (k == longest || !insert.is_identifiable) continue;
    Count(insert.wear_mm - (wear_mm[k] - wear_mm[longest]), insert.sigma_mm, found.coverage_factor,
          NamesOf("tool-curve"), coverage);
  }
  return absl::OkStatus();
}

}  // namespace

const std::vector<FurtherCase>& FurtherCases() {
  static const auto& cases = *new std::vector<FurtherCase>{{"eccentricity", "charts", IdentifyEccentricities, 2000},
                                                           {"tool-setter", "tool-setter", IdentifyBeam, 2000},
                                                           {"tool-curve", "tool-curve", IdentifyWear, 200}};
  return cases;
}

PlannedScore JudgeFurther(const FurtherCase& further, int intervals, int most_fits) {
  PlannedScore score;
  score.cases = 1;
  intervals = std::min(intervals, further.most_intervals);
  while (score.fits < most_fits && score.coverage["all"].intervals < intervals) {
    const absl::Status status = further.identify(static_cast<uint64_t>(score.fits++), &score.coverage);
    if (!status.ok()) score.refused.push_back(std::string(status.message()));
  }
  return score;
}

}  // namespace axiscal::rates
