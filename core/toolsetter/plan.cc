#include "core/toolsetter/plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/units.h"
#include "core/toolsetter/cutter_keys.h"

namespace axiscal::toolsetter {
namespace {

absl::Status InRange(const char* name, int value, int least, int most) {
  if (value >= least && value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(name, " = ", value, ", expected ", least, " to ", most));
}

std::string Number(double number) { return absl::StrFormat("%.10g", number); }

}  // namespace

const std::vector<PlannableTest>& PlannableTests() {
  static const auto& tests = *new std::vector<PlannableTest>{
      {"tool-setter", "measuring rods in a laser tool setter: its reference point, yaw and pitch of its beam",
       "a tool-setter session whose rods are meant (FILE.csv)"},
      {"tool-curve", "a mill with round inserts in a laser tool setter: its length and each insert's wear",
       "a cutter.json"}};
  return tests;
}

const PlannableTest* FindPlannable(const std::string& name) {
  for (const PlannableTest& test : PlannableTests()) {
    if (test.name == name) return &test;
  }
  return nullptr;
}

bool FeedsAlongTool(const machine::Machine& machine) {
  return std::any_of(machine.axes.begin(), machine.axes.end(), [&](const machine::Axis& axis) {
    return axis.kind == machine::AxisKind::kLinear && std::abs(axis.direction.dot(machine.tool_direction)) > 1.0 - 1e-9;
  });
}

absl::StatusOr<RodSession> PlanRods(RodSession session, const std::string& turned, int holders, int readouts) {
  RETURN_IF_ERROR(InRange("readouts", readouts, 1, 100));
  RETURN_IF_ERROR(InRange("holders", holders, 2, 360));
  std::vector<MeasuredRod> rods;
  for (const MeasuredRod& rod : session.rods) {
    const int positions = rod.name == turned ? holders : 1;
    for (int i = 0; i < positions; ++i) {
      const double angle_deg = 360.0 * i / holders;
      rods.push_back(rod);
      rods.back().rod.holder_rad += angle_deg * base::kRadPerDeg;
      if (i > 0) absl::StrAppend(&rods.back().name, absl::StrFormat("@%g", angle_deg));
      ASSIGN_OR_RETURN(const Trigger trigger, TriggerOf(rods.back().rod, session.beam));
      rods.back().readouts_mm.assign(readouts, rod.rod.length_mm + trigger.height_mm);
    }
  }
  const bool is_there = turned.empty() || std::any_of(session.rods.begin(), session.rods.end(),
                                                      [&](const MeasuredRod& rod) { return rod.name == turned; });
  if (!is_there) return absl::InvalidArgumentError("'" + turned + "' is no rod of session " + session.session);
  session.rods = std::move(rods);
  return session;
}

absl::StatusOr<CurveSession> PlanStarts(CurveSession session, int starts) {
  RETURN_IF_ERROR(Validate(session.cutter, session.run));
  RETURN_IF_ERROR(InRange("starts", starts, session.cutter.inserts + 2, 360));
  session.starts_rad.clear();
  for (int i = 0; i < starts; ++i) session.starts_rad.push_back(2.0 * std::numbers::pi * i / starts);
  ASSIGN_OR_RETURN(const InsertHeights heights, HeightsOf(session.cutter, session.run));
  RETURN_IF_ERROR(CheckInsertsApart(heights, session.cutter, session.run, session.sigma_mm));
  const LengthCurve curve(heights, session.cutter, session.run, std::vector<double>(session.cutter.inserts, 0.0));
  session.lengths_mm.clear();
  for (const CurvePoint& point : curve.At(session.starts_rad)) session.lengths_mm.push_back(point.height_mm);
  return session;
}

absl::StatusOr<Reference> ExpectedOf(const RodSession& planned) { return FitReference(planned, {true, true}); }

absl::StatusOr<WearReport> ExpectedOf(const CurveSession& planned) { return FitWear(planned); }

std::string ToTable(const session::Session& session, const RodSession& planned) {
  std::string text;
  for (const session::HeaderEntry& entry : session.header)
    absl::StrAppend(&text, "# ", entry.key, ": ", entry.value, "\n");
  for (const MeasuredRod& rod : planned.rods) {
    if (rod.name == rod.body() || session::FindHeader(session, "rod " + rod.name)) continue;
    const Rod& r = rod.rod;
    absl::StrAppend(&text, "# rod ", rod.name, ":");
    for (const double number :
         {r.radius_mm, r.fillet_mm, r.face_rad * base::kDegPerRad, r.azimuth_rad * base::kDegPerRad, r.length_mm,
          r.holder_rad * base::kDegPerRad})
      absl::StrAppend(&text, " ", Number(number));
    text += "\n";
  }
  text += "rod,readout,Z_mm\n";
  for (const MeasuredRod& rod : planned.rods) {
    for (size_t i = 1; i <= rod.readouts_mm.size(); ++i) absl::StrAppend(&text, rod.name, ",", i, ",\n");
  }
  return text;
}

absl::StatusOr<std::string> ToTable(const std::string& cutter_json, const std::string& machine,
                                    const std::string& session, const CurveSession& planned) {
  ASSIGN_OR_RETURN(const std::string cutter, HeaderOfCutter(cutter_json));
  std::string text = absl::StrCat("# machine: ", machine, "\n# session: ", session,
                                  "\n# instrument: tool-curve\n# sigma_um: ",
                                  Number(planned.sigma_mm * base::kUmPerMm), "\n# tool_tip_mm: 0 0 0\n", cutter,
                                  "start_deg,length_mm\n");
  for (const double start_rad : planned.starts_rad)
    absl::StrAppend(&text, Number(start_rad * base::kDegPerRad), ",\n");
  return text;
}

}  // namespace axiscal::toolsetter
