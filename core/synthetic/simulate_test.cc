// What a simulated probe latches.
#include "core/synthetic/simulate.h"

#include <gtest/gtest.h>

#include "core/machine/testing/machines.h"

namespace axiscal::synthetic {
namespace {

// A face at x = 85 mm, touched by a stylus of 3 mm from +x: on the nominal machine X stands at 88 mm then.
session::Session TouchPlannedAt(double x_mm) {
  session::Session session;
  session.header = {
      {"machine", "mt"},           {"session", "face"},       {"instrument", "touch"},        {"sigma_um", "1"},
      {"tool_tip_mm", "0 0 -350"}, {"stylus_radius_mm", "3"}, {"plane face", "85 0 70 1 0 0"}};
  session.columns = {{"t_s", {0}, {}},   {"X_mm", {x_mm}, {}},     {"Y_mm", {0}, {}}, {"Z_mm", {420}, {}},
                     {"B_deg", {0}, {}}, {"C_deg", {0}, {}},       {"nx", {-1}, {}},  {"ny", {0}, {}},
                     {"nz", {0}, {}},    {"feature", {}, {"face"}}};
  return session;
}

// The probe triggers where it meets the face, and errors along the axis are those of there: a scale of 1 mm/m has
// X (1 + 0.001) = 88 mm, wherever the plan expected the face.
TEST(Simulate, ATouchHasTheErrorsOfWhereItTriggers) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const int x = machine::FindAxis(machine, "X");
  machine::ErrorModel truth;
  truth.terms.push_back({x, machine::Component::kX, shapes::Linear{x}, {1.0}});
  NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  for (const double planned_mm : {88.0, 93.0, 80.0}) {
    const auto touched = Simulate(machine, truth, TouchPlannedAt(planned_mm), exact);
    ASSERT_TRUE(touched.ok()) << touched.status();
    EXPECT_NEAR(session::FindColumn(*touched, "X_mm")->values[0], 88.0 / 1.001, 1e-7) << planned_mm;
  }
}

}  // namespace
}  // namespace axiscal::synthetic
