#include "tests/known_answers/example_sessions.h"

#include <cmath>
#include <optional>

#include "core/base/files.h"
#include "core/machine/error_json.h"
#include "core/synthetic/simulate.h"
#include "tests/known_answers/fang_grinder.h"
#include "tests/known_answers/ibaraki_columns.h"

namespace axiscal::known_answers {
namespace {

struct Planned {
  std::string folder, file;
  const machine::Machine* machine;
  session::Session session;                                        // where everything stands
  std::optional<std::vector<session::HeaderEntry>> stated_header;  // where the cell says that it stands
};

std::vector<Planned> PlannedSessions() {
  constexpr double kCertificateUm = 1.0;  // of the sphere's place on the flange
  const Eigen::Vector3d elsewhere_mm(40, -60, 0), by_hand_mm(0.2, -0.1, 0.15);
  const auto elsewhere = [&](const Eigen::Vector3d& off_mm) {
    return ColumnsSession("columns-elsewhere", {-15, -45, -75}, {30, 120, 210, 330}, elsewhere_mm + off_mm);
  };
  return {
      {"ibaraki-columns", "fit/columns.csv", &TiltingTableAc(), ColumnsSession(), ColumnsSession(by_hand_mm).header},
      {"ibaraki-columns", "check/columns-elsewhere.csv", &TiltingTableAc(), elsewhere(Eigen::Vector3d::Zero()),
       elsewhere(-by_hand_mm).header},
      {"fang-grinder",
       "fit/pattern-1.csv",
       &grinder::Machine(),
       grinder::CentresSession("pattern-1", grinder::PatternOne(), 0.0, kCertificateUm),
       {}},
      {"fang-grinder",
       "fit/pattern-2.csv",
       &grinder::Machine(),
       grinder::CentresSession("pattern-2", grinder::PatternTwo(), 1200.0, kCertificateUm),
       {}},
      {"fang-grinder",
       "check/between.csv",
       &grinder::Machine(),
       grinder::CentresSession("between", {{-15, 20}, {-5, 35}, {5, 50}, {15, 65}, {25, 80}, {35, 40}, {40, 10}},
                               2400.0, kCertificateUm),
       {}},
  };
}

// Controls report 0.1 um.
void Round(session::Session* session) {
  for (session::Column& column : session->columns) {
    if (column.name == "t_s" || column.name.find("_deg") != std::string::npos) continue;
    const double steps = column.name.find("_mm") != std::string::npos ? 1e4 : 1e6;
    for (double& value : column.values) value = std::round(value * steps) / steps + 0.0;
  }
}

}  // namespace

absl::StatusOr<std::vector<ExampleSession>> ExampleSessions() {
  std::vector<ExampleSession> sessions;
  for (const Planned& planned : PlannedSessions()) {
    const std::string root = std::string(AXISCAL_SOURCE_DIR "/deploy/examples/") + planned.folder + "/";
    ASSIGN_OR_RETURN(const std::string text, base::ReadFile(root + "truth.json", 1 << 20));
    ASSIGN_OR_RETURN(const machine::ErrorModel truth, machine::ReadErrors(text, *planned.machine));
    synthetic::NoiseOptions noise;
    noise.seed = sessions.size() + 1;
    noise.draw_setup = false;
    ASSIGN_OR_RETURN(session::Session session, synthetic::Simulate(*planned.machine, truth, planned.session, noise));
    Round(&session);
    if (planned.stated_header) session.header = *planned.stated_header;
    session.header.push_back({"note", "made by the product's simulator from truth.json"});
    sessions.push_back({planned.folder + "/" + planned.file, std::move(session)});
  }
  return sessions;
}

}  // namespace axiscal::known_answers
