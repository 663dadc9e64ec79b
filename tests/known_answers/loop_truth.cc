#include "tests/known_answers/loop_truth.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "core/base/testing/source_path.h"

namespace axiscal::known_answers::loop_truth {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

std::string Folder(const std::string& name) { return base::SourcePath("/tests/data/loop/") + name; }

std::optional<shapes::Shape> ShapeOf(const json& effect, const machine::Machine& machine) {
  const std::string shape = effect["shape"];
  const int axis = machine::FindAxis(machine, effect.value("var", ""));
  const bool is_rotary = axis >= 0 && machine.axes[axis].kind == machine::AxisKind::kRotary;
  if (shape == "constant") return shapes::Constant{};
  if (shape == "linear") {
    return shapes::Linear{axis, is_rotary ? shapes::Linear::kReferenceRad : shapes::Linear::kReferenceMm};
  }
  if (shape == "quad") {
    return shapes::Quadratic{axis, is_rotary ? shapes::Quadratic::kReferenceRad : shapes::Quadratic::kReferenceMm};
  }
  if (shape == "harmonic") return shapes::Harmonic{axis, effect["n"].get<double>()};
  if (shape == "backlash") return shapes::Backlash{axis};
  if (shape == "reversal") return shapes::Reversal{axis};
  if (shape == "drift") return shapes::Drift{};
  if (shape == "drift-exp") return shapes::DriftExp{};
  if (shape == "thermal") return shapes::Thermal{};
  return std::nullopt;
}

}  // namespace

std::vector<std::string> CaseNames() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(Folder(""))) {
    if (entry.is_directory()) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string NameOf(const testing::TestParamInfo<std::string>& param) {
  std::string name = param.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

session::Case ReadCase(const std::string& name) { return session::ReadCase(Folder(name)).value(); }

json ReadTruth(const std::string& name) { return json::parse(std::ifstream(Folder(name) + "/truth.json")); }

bool IsDirty(const json& truth) { return truth["category"] == "hard"; }

std::optional<machine::ErrorTerm> TermOf(const json& effect, const machine::Machine& machine) {
  const std::optional<shapes::Shape> shape = ShapeOf(effect, machine);
  const int joint = machine::FindJoint(machine, effect.value("axis", ""));
  const size_t component = std::string("XYZABC").find(effect.value("comp", "?"));
  if (!shape || joint < 0 || component == std::string::npos) return std::nullopt;
  return machine::ErrorTerm{joint, static_cast<machine::Component>(component), *shape, {}};
}

}  // namespace axiscal::known_answers::loop_truth
