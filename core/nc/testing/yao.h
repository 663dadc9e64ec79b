// The machine of Yao 2022 with the one error of its published compensation, for tests: known answers by hand.
// EB0B = b: the head leans by b about Y, so the tool point (R below the pivot at B = 0) is off by -b R (cos B, -sin B)
// in (X, Z); the correction is +b R (cos B, -sin B): 41.66 um at B = 0, (29.46, -29.46) at 45 degrees, (0, -41.66) at
// 90.
#ifndef AXISCAL_CORE_NC_TESTING_YAO_H_
#define AXISCAL_CORE_NC_TESTING_YAO_H_

#include <gtest/gtest.h>

#include <string>

#include "core/base/units.h"
#include "core/compensate/compensator.h"
#include "core/machine/testing/machines.h"
#include "core/nc/options.h"

namespace axiscal::nc::testing {

inline constexpr double kTiltRad = 24.11 * base::kRadPerArcsec;
inline constexpr double kToolMm = 356.3945;

// Programs of tests are in mm where they do not say so.
inline RewriteOptions InMm() {
  RewriteOptions options;
  options.unit = ProgramUnit::kMillimetre;
  return options;
}

inline machine::ErrorModel ConstantErrors(const machine::Machine& machine,
                                          const std::vector<std::pair<std::string, double>>& values) {
  machine::ErrorModel errors;
  for (const auto& [symbol, value] : values) {
    errors.terms.push_back(machine::ConstantTerm(machine, *machine::ParseErrorSymbol(symbol), value));
  }
  return errors;
}

inline compensate::Compensator MustCreate(const machine::Machine& machine, const machine::ErrorModel& errors,
                                          const Eigen::Vector3d& tool_tip_mm) {
  compensate::Options options;
  options.tool_tip_mm = tool_tip_mm;
  auto compensator = compensate::Compensator::Create(machine, errors, options);
  EXPECT_TRUE(compensator.ok()) << compensator.status();
  return *std::move(compensator);
}

// Rotary axes that count on: what machines of tests do where nothing else is said.
inline machine::Machine CountingOn(machine::Machine machine) {
  for (machine::Axis& axis : machine.axes) {
    if (axis.kind == machine::AxisKind::kRotary) axis.roll_over = machine::RollOver::kNone;
  }
  return machine;
}

// At B = 0: X + 0.04166 mm (0.0417 at four decimals), nothing else but second order.
inline compensate::Compensator LeaningHead() {
  const machine::Machine machine = CountingOn(machine::testing::MultiTasking());
  return MustCreate(machine, ConstantErrors(machine, {{"EB0B", kTiltRad}}), {0, 0, -kToolMm});
}

inline compensate::Compensator PerfectMachine() {
  return MustCreate(CountingOn(machine::testing::MultiTasking()), {}, {0, 0, -kToolMm});
}

}  // namespace axiscal::nc::testing

#endif  // AXISCAL_CORE_NC_TESTING_YAO_H_
