#include "core/nc/tool_chain.h"

#include <gtest/gtest.h>

#include <random>

#include "core/machine/chain.h"
#include "core/machine/testing/machines.h"

namespace axiscal::nc {
namespace {

// Random poses on three structures, constant errors alone and with some that vary on linear, rotary and end joints, of
// sizes that no machine has (1 mrad, 1 mm): the same as the chain and the errors as everybody evaluates them.
TEST(ToolChain, IsTheChainWithTheErrorsOfTheModel) {
  std::mt19937 random(20261129);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const machine::Machine& machine :
       {machine::testing::MultiTasking(), machine::testing::TiltingTable(), machine::testing::SwivelHead()}) {
    for (const bool has_varying : {false, true}) {
      machine::ErrorModel errors = machine::DeclaredModel(machine);
      for (auto& term : errors.terms) term.amplitude[0] = unit(random) * (machine::IsAngle(term.component) ? 1e-3 : 1);
      if (has_varying) {
        const int z = machine::FindAxis(machine, "Z"), c = machine::FindAxis(machine, "C");
        const auto add = [&](const std::string& symbol, double amplitude, const shapes::Shape& shape) {
          machine::ErrorTerm term = machine::ConstantTerm(machine, *machine::ParseErrorSymbol(symbol), amplitude);
          term.shape = shape;
          errors.terms.push_back(term);
        };
        add("EX0Z", 0.5, shapes::Linear{z, shapes::Linear::kReferenceMm});
        add("EB0C", 1e-3, shapes::Harmonic{c, 2.0});
        add("EZ0Z", 0.5, shapes::Backlash{z});
      }
      constexpr double kTimeS = 120.0, kCelsius = 23.0;
      const ToolChain chain(machine, errors, kTimeS, kCelsius);
      for (int pose = 0; pose < 200; ++pose) {
        std::array<double, machine::kMaxAxes> positions{};
        AxisSenses senses{};
        std::array<shapes::AxisState, machine::kMaxAxes> states;
        for (size_t i = 0; i < static_cast<size_t>(machine.axis_count()); ++i) {
          positions[i] = unit(random) * (machine.axes[i].kind == machine::AxisKind::kRotary ? 4.0 : 500.0);
          senses[i] = unit(random) > 0 ? 1 : -1;
          states[i].position = positions[i];
          states[i].sense = senses[i];
        }
        const Eigen::Vector3d tip_mm(10 * unit(random), 10 * unit(random), -150);
        shapes::State state;
        state.axes = {states.data(), static_cast<size_t>(machine.axis_count())};
        state.time_s = kTimeS;
        state.temperature_celsius = kCelsius;
        const auto expected =
            machine::EvaluateChain<double>(machine, positions.data(), machine::ErrorsAt(machine, errors, state));
        const AxesAt axes = ToolChain::Prepare(machine, positions, nullptr);
        const ToolPose found = chain.At(ToolChain::Prepare(machine, positions, &axes), senses, tip_mm);
        EXPECT_LT((found.tip_mm - machine::TipInTable(expected, tip_mm)).norm(), 1e-10) << machine.id;
        EXPECT_LT((found.direction - machine::ToolDirectionInTable(machine, expected)).norm(), 1e-13) << machine.id;
      }
    }
  }
}

}  // namespace
}  // namespace axiscal::nc
