#include "tests/end_to_end/testing/fixture.h"

#include <stdlib.h>

#include <cmath>
#include <filesystem>

namespace axiscal::testing {

std::string MachineJson(const std::string& id) {
  return R"({"id": ")" + id + R"(", "structure": "w-C'bZYXB(C1)-t",
 "axes": {
  "X": {"kind": "linear", "direction": [1, 0, 0]},
  "Y": {"kind": "linear", "direction": [0, 1, 0]},
  "Z": {"kind": "linear", "direction": [0, 0, 1]},
  "B": {"kind": "rotary", "direction": [0, 1, 0], "point_mm": [0, 0, 0]},
  "C": {"kind": "rotary", "direction": [0, 0, 1], "point_mm": [0, 0, 0]}
 },
 "tool_branch": ["Z", "Y", "X", "B"], "work_branch": ["C"], "tool_direction": [0, 0, -1],
 "declared": ["EX0C", "EY0C"]})";
}

session::Session BallbarSession(const std::string& machine, const std::string& name, int readings) {
  session::Session session;
  session.header = {{"machine", machine},          {"session", name},
                    {"instrument", "ballbar"},     {"sigma_um", "0.3"},
                    {"tool_tip_mm", "0 0 -356.4"}, {"table_ball_mm", "0 0 65.5"},
                    {"bar_length_mm", "100"}};
  for (const char* column : {"t_s", "X_mm", "Y_mm", "Z_mm", "B_deg", "C_deg", "dL_mm"}) {
    session.columns.push_back({column, {}, {}});
  }
  // A circle about the table ball while C turns with it; the deviation is what EX0C = 12 um, EY0C = -5 um would give.
  const double radius_mm = 100, phase = static_cast<double>(name.size() + name.back());
  for (int i = 0; i < readings; ++i) {
    const double angle = 2 * M_PI * i / std::max(readings, 360),
                 c_deg = std::fmod(i * 360.0 / std::max(readings, 360) + phase, 360);
    const double deviation_mm = -0.012 * std::cos(angle) + 0.005 * std::sin(angle);
    const double row[] = {0.01 * i,    radius_mm * std::cos(angle), radius_mm * std::sin(angle), 421.9, 0, c_deg,
                          deviation_mm};
    for (size_t k = 0; k < session.columns.size(); ++k) session.columns[k].values.push_back(row[k]);
  }
  return session;
}

TempDir::TempDir() {
  std::string name = ::testing::TempDir() + "/axiscal.XXXXXX";
  if (mkdtemp(name.data()) != nullptr) path_ = name;
}

TempDir::~TempDir() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

void EndToEnd::SetUp() { Restart(); }

void EndToEnd::Restart() {
  embedded_.reset();
  absl::StatusOr<server::Embedded> embedded = server::StartEmbedded(dir_.File("axiscal.db"), {.user = "test"});
  ASSERT_OK(embedded);
  embedded_ = std::make_unique<server::Embedded>(*std::move(embedded));
}

}  // namespace axiscal::testing
