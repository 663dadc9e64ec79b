// What the loop's rates do when a constant of its decisions (core/objective/policy.h) is halved or doubled, as the
// table of docs/loop.md: `policy_rates COUNT [FIRST_SEED]`, COUNT dirty machines with faint effects, as many dirty ones
// with nothing, and as many of each of four kinds of physics beyond the named effects.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "absl/strings/str_format.h"
#include "core/base/units.h"
#include "core/decide/close_loop.h"
#include "core/identify/identify.h"
#include "tests/rates/physics_case.h"
#include "tests/rates/score.h"

namespace {

namespace rates = axiscal::rates;
using axiscal::objective::Policy;

struct Setting {
  std::string name;  // of the constant, and by what it was multiplied
  Policy policy;
};

struct Rates {
  int effects = 0, named = 0, spurious = 0, false_alarms = 0, harmed = 0;
  std::vector<double> left;  // share of the error over the box
};

std::vector<Setting> SettingsOf() {
  std::vector<Setting> settings = {{"as they are", {}}};
  const auto add = [&settings](const char* name, auto Policy::*constant, double most = INFINITY) {
    for (const double factor : {0.5, 2.0}) {
      Setting& one = settings.emplace_back(Setting{absl::StrFormat("%s x %g", name, factor), {}});
      auto& value = one.policy.*constant;
      value =
          static_cast<std::remove_reference_t<decltype(value)>>(std::min(most, factor * static_cast<double>(value)));
    }
  };
  add("evidence", &Policy::evidence);
  add("per_look", &Policy::per_look);
  add("per_column", &Policy::per_column);
  add("exotic", &Policy::exotic);
  add("largest_hidden", &Policy::largest_hidden);
  add("visible", &Policy::visible);
  add("scan_visible", &Policy::scan_visible);
  add("distinct", &Policy::distinct);
  add("smallest_log_variance", &Policy::smallest_log_variance);
  add("largest_log_variance", &Policy::largest_log_variance);
  add("design_columns", &Policy::design_columns);
  add("design_quantile", &Policy::design_quantile, 1.0);  // a share: doubled, the largest of all columns
  add("fewest_clusters", &Policy::fewest_clusters);
  add("replacement_gain", &Policy::replacement_gain);
  add("beam", &Policy::beam);
  add("trials", &Policy::trials);
  add("alike", &Policy::alike);
  add("most_effects", &Policy::most_effects);
  add("harm_share", &Policy::harm_share);
  add("harm_mm", &Policy::harm_mm);
  add("harm_probability", &Policy::harm_probability);
  add("least_gain", &Policy::least_gain);
  add("order_falloff", &Policy::order_falloff);
  return settings;
}

void JudgePhysics(rates::Physics kind, uint64_t seed, const axiscal::decide::Options& options, Rates* out) {
  const rates::PhysicsCase physics = rates::DrawPhysics(kind, seed);
  const auto declared = axiscal::identify::Identify(physics.machine, physics.simulated.measured.fit);
  const auto closed = axiscal::decide::CloseLoop(physics.machine, physics.fit, physics.check, options);
  if (!declared.ok()) return;
  const double before_mm = rates::ErrorOverBox(physics, declared->model);
  const double after_mm =
      closed.ok() ? rates::ErrorOverBox(physics, axiscal::machine::NamedErrors(closed->fitted.model)) : before_mm;
  constexpr double kWorse = 1.1, kWorseMm = 0.2e-3;  // as loop_rates calls it harmed
  out->harmed += after_mm > kWorse * before_mm && after_mm > before_mm + kWorseMm;
  out->left.push_back(after_mm / before_mm);
}

Rates RatesOf(const Policy& policy, int count, int first) {
  axiscal::decide::Options options;
  options.policy = policy;
  Rates out;
  for (int seed = first; seed < first + count; ++seed) {
    const rates::Score dirty = rates::Judge(rates::Draw(rates::Kind::kDirty, seed), rates::Kind::kDirty, options);
    out.effects += dirty.effects;
    out.named += dirty.named;
    out.spurious += dirty.spurious;
    const rates::Score null =
        rates::Judge(rates::Draw(rates::Kind::kDirtyNull, seed), rates::Kind::kDirtyNull, options);
    out.false_alarms += null.spurious > 0;
    for (const rates::Physics kind :
         {rates::Physics::kGravity, rates::Physics::kRipple, rates::Physics::kHeat, rates::Physics::kInstrument})
      JudgePhysics(kind, seed, options, &out);
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 0;
  if (count <= 0) {
    std::fprintf(stderr, "usage: policy_rates COUNT [FIRST_SEED]\n");
    return 2;
  }
  const int first = argc > 2 ? std::atoi(argv[2]) : 1;
  const std::vector<Setting> settings = SettingsOf();
  std::vector<Rates> all(settings.size());
  std::atomic<size_t> next = 0;
  {
    std::vector<std::jthread> threads;
    for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i)
      threads.emplace_back([&] {
        for (size_t s = next++; s < settings.size(); s = next++) {
          all[s] = RatesOf(settings[s].policy, count, first);
          std::fprintf(stderr, "%s\n", settings[s].name.c_str());
        }
      });
  }
  std::printf(
      "| constant | named, dirty | beside them | nulls not left alone | box after / before, median | harmed |\n");
  std::printf("|---|---|---|---|---|---|\n");
  for (size_t s = 0; s < settings.size(); ++s) {
    Rates& one = all[s];
    std::sort(one.left.begin(), one.left.end());
    std::printf("| %s | %d of %d | %d | %d of %d | %.3f | %d of %zu |\n", settings[s].name.c_str(), one.named,
                one.effects, one.spurious, one.false_alarms, count,
                one.left.empty() ? 1.0 : one.left[one.left.size() / 2], one.harmed, one.left.size());
  }
  return 0;
}
