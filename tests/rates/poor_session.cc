#include "tests/rates/poor_session.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/base/demand.h"
#include "core/base/random.h"
#include "core/base/units.h"
#include "core/instruments/centres/centres_model.h"
#include "core/machine/testing/machines.h"
#include "core/synthetic/simulate.h"
#include "tests/known_answers/touch_session.h"

namespace axiscal::rates {
namespace {

using base::Random;
using Eigen::Vector3d;
using known_answers::Face;
using known_answers::TouchSession;

constexpr double kToolMm = 200.0;

int Among(int count, Random* random) { return std::min(count - 1, static_cast<int>(random->Uniform() * count)); }

machine::Machine AnyMachine(Random* random) {
  const int which = Among(3, random);
  return which == 0   ? machine::testing::MultiTasking()
         : which == 1 ? machine::testing::TiltingTable()
                      : machine::testing::SwivelHead();
}

// The rotary axis beside C.
std::string TiltOf(const machine::Machine& machine) { return machine.id == "tt" ? "A" : "B"; }

// The errors of C, and by chance those of the other rotary axis, of the tool's length and of a squareness.
machine::ErrorModel AnyErrors(const machine::Machine& machine, Random* random) {
  const std::string tilt = TiltOf(machine);
  std::set<std::string> symbols = {"EX0C", "EY0C", "EA0C", "EB0C"};
  if (Among(2, random) == 0) symbols.insert({"EA0" + tilt, "EB0" + tilt});
  if (Among(2, random) == 0) symbols.insert("EC0" + tilt);
  if (Among(2, random) == 0) symbols.insert({"EX0" + tilt, "EY0" + tilt, "EZ0" + tilt});
  if (Among(3, random) == 0) symbols.insert("EZ0T");
  if (Among(3, random) == 0) symbols.insert("EC0Y");
  machine::ErrorModel truth;
  for (const std::string& symbol : symbols) {
    machine::ErrorTerm term = machine::ConstantTerm(machine, machine::ParseErrorSymbol(symbol).value());
    term.amplitude[0] =
        machine::IsAngle(term.component) ? random->Uniform(-350e-6, 350e-6) : random->Uniform(-0.04, 0.04);
    truth.terms.push_back(term);
  }
  return truth;
}

// A cube on the table, its sides and its top touched at some positions, once each or twice.
session::Session Touched(const machine::Machine& machine, Random* random) {
  TouchSession session(machine, "touched", {0, 0, -kToolMm}, 3.0, 1.0);
  const double half_mm = random->Uniform(10.0, 40.0);
  const Vector3d centre_mm(Among(2, random) * random->Uniform(-80, 80), Among(2, random) * random->Uniform(-80, 80),
                           random->Uniform(20, 80));
  const char* const names[] = {"x+", "x-", "y+", "y-", "z+"};
  for (int face = 0; face < 5; ++face) {
    const Vector3d normal = (face % 2 == 1 ? -1.0 : 1.0) * Vector3d::Unit(face / 2);
    session.AddFace(names[face], {centre_mm + half_mm * normal, normal});
  }
  const bool is_twice = Among(2, random) == 1;
  for (int poses = 2 + Among(5, random); poses > 0; --poses) {
    std::map<std::string, double> rotary_deg = {{"C", 90.0 * Among(4, random)}};
    if (Among(2, random) == 1) rotary_deg[TiltOf(machine)] = -45.0 * Among(3, random);
    for (int face = 0; face < 5; ++face) {
      const Vector3d aside_mm = 5.0 * Vector3d::Unit((face / 2 + 1) % 3);
      if (!is_twice) session.Touch(names[face], rotary_deg);
      if (is_twice) session.Touch(names[face], rotary_deg, aside_mm);
      if (is_twice) session.Touch(names[face], rotary_deg, -aside_mm);
    }
  }
  return session.planned();
}

// A ball on the table that the tool follows (R-test), or stands a bar's length off, while a rotary axis turns by some
// steps; or a tool point that a tracker sees anywhere.
session::Session Followed(const machine::Machine& machine, const std::string& instrument, int number, Random* random) {
  const Vector3d tip_mm(0, 0, -kToolMm - random->Uniform(0, 60));
  const Vector3d ball_mm(random->Uniform(-100, 100), random->Uniform(-100, 100), random->Uniform(20, 100));
  constexpr double kBarMm = 100.0;
  const auto text = [](const Vector3d& v) { return absl::StrFormat("%.10g %.10g %.10g", v.x(), v.y(), v.z()); };
  session::Session session;
  session.header = {{"machine", machine.id},
                    {"session", absl::StrCat(instrument, number)},
                    {"instrument", instrument},
                    {"sigma_um", instrument == "tracker" ? "5" : "0.5"},
                    {"tool_tip_mm", text(tip_mm)}};
  if (instrument != "tracker") session.header.push_back({"table_ball_mm", text(ball_mm)});
  if (instrument == "ballbar") session.header.push_back({"bar_length_mm", "100"});
  session.columns.push_back({"t_s", {}, {}});
  for (const machine::Axis& axis : machine.axes)
    session.columns.push_back({axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg"), {}, {}});
  const int tilt = machine::FindAxis(machine, TiltOf(machine)), c = machine::FindAxis(machine, "C");
  const bool turns_c = Among(3, random) != 0, turns_tilt = !turns_c || Among(2, random) == 0;
  const Vector3d bar = Vector3d(random->Normal(), random->Normal(), random->Normal()).normalized();
  const int steps = 6 + Among(30, random);
  for (int k = 0; k < steps; ++k) {
    std::vector<double> positions(machine.axis_count(), 0.0);
    std::vector<double> deg(machine.axis_count(), 0.0);
    if (turns_c) deg[c] = 360.0 * k / steps;
    if (turns_tilt) deg[tilt] = -90.0 * k / steps;
    for (const int axis : {c, tilt}) positions[axis] = deg[axis] * base::kRadPerDeg;
    Vector3d target_mm = ball_mm;
    if (instrument == "ballbar") target_mm += kBarMm * bar;
    if (instrument == "tracker")
      target_mm = Vector3d(random->Uniform(-300, 300), random->Uniform(-300, 300), random->Uniform(0, 300));
    DEMAND(centres::SolveNominalCommands(machine, tip_mm, target_mm, positions.data()).ok());
    session.columns[0].values.push_back(10.0 * k);
    for (int axis = 0; axis < machine.axis_count(); ++axis) {
      const bool is_linear = machine.axes[axis].kind == machine::AxisKind::kLinear;
      session.columns[1 + axis].values.push_back(is_linear ? positions[axis] : deg[axis]);
    }
  }
  return session;
}

}  // namespace

PoorSession DrawPoorSession(const std::string& instrument, uint64_t seed) {
  Random random(seed);
  PoorSession out;
  out.machine = AnyMachine(&random);
  out.truth = AnyErrors(out.machine, &random);
  const int count = instrument == "touch" ? 1 : 1 + Among(3, &random);
  for (int i = 0; i < count; ++i) {
    const session::Session planned =
        instrument == "touch" ? Touched(out.machine, &random) : Followed(out.machine, instrument, i, &random);
    synthetic::NoiseOptions noise;
    noise.seed = 1000 * seed + static_cast<uint64_t>(i);
    absl::StatusOr<session::Session> simulated = synthetic::Simulate(out.machine, out.truth, planned, noise);
    DEMAND(simulated.ok());
    out.sessions.push_back(*std::move(simulated));
  }
  return out;
}

}  // namespace axiscal::rates
