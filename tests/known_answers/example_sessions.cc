#include "tests/known_answers/example_sessions.h"

#include <cmath>
#include <optional>

#include "core/base/files.h"
#include "core/base/testing/source_path.h"
#include "core/machine/error_json.h"
#include "core/synthetic/simulate.h"
#include "tests/known_answers/chang_linked.h"
#include "tests/known_answers/fang_grinder.h"
#include "tests/known_answers/ibaraki_columns.h"
#include "tests/known_answers/liu_blocks.h"

namespace axiscal::known_answers {
namespace {

struct Planned {
  std::string folder, file;
  const machine::Machine* machine;
  session::Session session;                                        // where everything stands
  std::optional<std::vector<session::HeaderEntry>> stated_header;  // where the cell says that it stands
  std::string truth_file = "truth.json";
};

// Every third reading: 241 in place of 721.
session::Session Thinned(session::Session session) {
  constexpr size_t kEvery = 3;
  for (session::Column& column : session.columns) {
    size_t kept = 0;
    for (size_t k = 0; k < column.values.size(); k += kEvery) column.values[kept++] = column.values[k];
    column.values.resize(kept);
  }
  return session;
}

std::vector<Planned> PlannedSessions() {
  constexpr double kCertificateUm = 1.0;  // of the sphere's place on the flange
  const Eigen::Vector3d elsewhere_mm(40, -60, 0), by_hand_mm(0.2, -0.1, 0.15);
  const auto elsewhere = [&](const Eigen::Vector3d& off_mm) {
    return ColumnsSession("columns-elsewhere", {-15, -45, -75}, {30, 120, 210, 330}, elsewhere_mm + off_mm);
  };
  std::vector<Planned> all = {
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
  for (const double height_mm : {100.0, 250.0, 160.0}) {
    for (const char axis : {'X', 'Y'}) {
      constexpr double kMountedUm = 0.5;  // found with an indicator before the test
      const session::Session planned = Thinned(linked::Planned(axis, height_mm, kMountedUm));
      const std::string file =
          absl::StrCat(height_mm == 160.0 ? "check/" : "fit/", std::string(1, axis), "C-", height_mm, ".csv");
      all.push_back({"chang-linked", file, &linked::Machine(), planned, {}});
    }
  }
  // The head's cubes stand on the linear axes, where C's errors do not move them.
  constexpr double kFoundUm = 1.0;
  all.push_back({"liu-blocks/swivel-head",
                 "head.csv",
                 &blocks::SwivelHead(),
                 blocks::Touches(blocks::SwivelHead(), "head", blocks::kHeadMm, blocks::HeadPatterns(), kFoundUm),
                 {},
                 "truth-head.json"});
  all.push_back(
      {"liu-blocks/swivel-head", "table.csv", &blocks::SwivelHead(),
       blocks::Touches(blocks::SwivelHead(), "table", blocks::kHeadMm, blocks::TablePatterns(), {}),
       blocks::Touches(blocks::SwivelHead(), "table", blocks::kHeadMm, blocks::TablePatterns(), {}, by_hand_mm)
           .header});
  all.push_back(
      {"liu-blocks/double-head",
       "fit/patterns.csv",
       &blocks::DoubleHead(),
       blocks::Touches(blocks::DoubleHead(), "patterns", blocks::kDoubleMm, blocks::DoubleHeadPatterns(), kFoundUm),
       {}});
  const std::vector<blocks::Pattern> between = {{"x", {{"B", -45}, {"A", -20}}}, {"y", {{"B", -45}, {"A", -20}}},
                                                {"x", {{"B", -15}, {"A", -60}}}, {"y", {{"B", -15}, {"A", -60}}},
                                                {"x", {{"B", 30}, {"A", -40}}},  {"y", {{"B", 30}, {"A", -40}}}};
  all.push_back({"liu-blocks/double-head",
                 "check/between.csv",
                 &blocks::DoubleHead(),
                 blocks::Touches(blocks::DoubleHead(), "between", blocks::kDoubleMm, between, kFoundUm),
                 {}});
  return all;
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
    const std::string root = base::SourcePath("/deploy/examples/") + planned.folder + "/";
    ASSIGN_OR_RETURN(const std::string text, base::ReadFile(root + planned.truth_file, 1 << 20));
    ASSIGN_OR_RETURN(const machine::ErrorModel truth, machine::ReadErrors(text, *planned.machine));
    synthetic::NoiseOptions noise;
    noise.seed = sessions.size() + 1;
    noise.draw_setup = session::FindHeader(planned.session, "instrument") == "ballbar";  // balls of the others: above
    ASSIGN_OR_RETURN(session::Session session, synthetic::Simulate(*planned.machine, truth, planned.session, noise));
    Round(&session);
    if (planned.stated_header) session.header = *planned.stated_header;
    session.header.push_back({"note", "made by the product's simulator from truth.json"});
    sessions.push_back({planned.folder + "/" + planned.file, std::move(session)});
  }
  return sessions;
}

}  // namespace axiscal::known_answers
