#include "client/cli/toolsetter_curve.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "client/cli/context.h"
#include "client/cli/output_paths.h"
#include "core/base/files.h"
#include "core/base/units.h"
#include "core/session/text.h"
#include "core/toolsetter/cutter_keys.h"
#include "core/toolsetter/length_curve.h"

namespace axiscal::cli {
namespace {

using base::kDegPerRad;
using base::kRadPerDeg;
using base::kUmPerMm;

constexpr double kUsualSigmaUm = 1.0;  // of a tool setter's reading, for which a cutter.json has no field

struct CurveArguments {
  std::string cutter, output, wear;
  std::optional<double> rpm, feed, height;
  double step_deg = 1.0;
};

absl::StatusOr<toolsetter::CutterDescription> Describe(const CurveArguments& arguments) {
  ASSIGN_OR_RETURN(toolsetter::CutterDescription described, toolsetter::ReadCutterFile(arguments.cutter));
  described.run.spindle_rpm = arguments.rpm.value_or(described.run.spindle_rpm);
  described.run.feed_mm_min = arguments.feed.value_or(described.run.feed_mm_min);
  described.run.start_height_mm = arguments.height.value_or(described.run.start_height_mm);
  if (!arguments.wear.empty() && !session::ParseNumbers(arguments.wear, &described.wear_mm))
    return absl::InvalidArgumentError("--wear '" + arguments.wear + "': expected one number in mm per insert");
  return described;
}

std::string CurveCsv(const std::vector<toolsetter::CurvePoint>& curve) {
  std::string csv = "start_deg,Zt_mm,insert,turned_deg,um_per_deg\n";
  for (const toolsetter::CurvePoint& point : curve) {
    absl::StrAppendFormat(&csv, "%.6g,%.9f,%d,%.6f,%.6f\n", point.start_rad * kDegPerRad, point.height_mm,
                          point.insert + 1, point.turned_rad * kDegPerRad, point.by_start * kUmPerMm * kRadPerDeg);
  }
  return csv;
}

absl::Status Curve(Context& context, const CurveArguments& arguments) {
  RETURN_IF_ERROR(CheckOutputs({{"the cutter", arguments.cutter}}, {{"--output", arguments.output}}));
  ASSIGN_OR_RETURN(const toolsetter::CutterDescription described, Describe(arguments));
  std::vector<double> starts;
  const int count = static_cast<int>(std::ceil(360.0 / arguments.step_deg - 1e-9));
  for (int i = 0; i < count; ++i) starts.push_back(i * arguments.step_deg * kRadPerDeg);
  ASSIGN_OR_RETURN(const auto curve,
                   toolsetter::ComputeCurve(described.cutter, described.run, described.wear_mm, starts));
  const auto lower = [](const auto& a, const auto& b) { return a.height_mm < b.height_mm; };
  const auto [lowest, highest] = std::minmax_element(curve.begin(), curve.end(), lower);
  Json inserts = Json::Array();
  std::vector<std::vector<std::string>> rows = {{"insert", "wear um", "fires first deg", "peak um", "at deg"}};
  for (int k = 0; k < described.cutter.inserts; ++k) {
    const toolsetter::CurvePoint* peak = nullptr;
    double share_deg = 0.0;
    for (const toolsetter::CurvePoint& point : curve) {
      if (point.insert != k) continue;
      share_deg += arguments.step_deg;
      if (peak == nullptr || point.height_mm > peak->height_mm) peak = &point;
    }
    Json insert = {{"insert", k + 1}, {"wear_um", described.wear_mm[k] * kUmPerMm}, {"fires_first_deg", share_deg}};
    if (peak != nullptr) {
      insert["peak_mm"] = peak->height_mm;
      insert["peak_start_deg"] = peak->start_rad * kDegPerRad;
    }
    inserts.push_back(std::move(insert));
    rows.push_back({std::to_string(k + 1), NumberText(described.wear_mm[k] * kUmPerMm), NumberText(share_deg),
                    peak != nullptr ? NumberText(peak->height_mm * kUmPerMm) : "never",
                    peak != nullptr ? NumberText(peak->start_rad * kDegPerRad) : "-"});
  }
  ASSIGN_OR_RETURN(const toolsetter::InsertHeights heights, toolsetter::HeightsOf(described.cutter, described.run));
  const std::vector<double> unseen_mm = toolsetter::UnseenFromMm(heights, described.cutter, described.run);
  const double unseen_um = *std::min_element(unseen_mm.begin(), unseen_mm.end()) * kUmPerMm;
  const absl::Status apart =
      toolsetter::CheckInsertsApart(heights, described.cutter, described.run, kUsualSigmaUm * base::kMmPerUm);
  Json warnings = Json::Array();
  if (!apart.ok()) warnings.push_back(std::string(apart.message()));
  Json points = Json::Array();
  for (const toolsetter::CurvePoint& point : curve) {
    points.push_back({{"start_deg", point.start_rad * kDegPerRad},
                      {"Zt_mm", point.height_mm},
                      {"insert", point.insert + 1},
                      {"um_per_deg", point.by_start * kUmPerMm * kRadPerDeg}});
  }
  if (!arguments.output.empty()) RETURN_IF_ERROR(base::WriteFileAtomically(arguments.output, CurveCsv(curve)));
  context.Print(
      {{"cutter", described.cutter.id},
       {"spindle_rpm", described.run.spindle_rpm},
       {"feed_mm_min", described.run.feed_mm_min},
       {"highest_mm", highest->height_mm},
       {"highest_start_deg", highest->start_rad * kDegPerRad},
       {"lowest_mm", lowest->height_mm},
       {"lowest_start_deg", lowest->start_rad * kDegPerRad},
       {"unseen_from_um", unseen_um},
       {"warnings", warnings},
       {"inserts", inserts},
       {"curve", points}},
      absl::StrFormat("Z_t from %.3f um (start at %g deg) to %.3f um (%g deg); a length that ignores it reads so "
                      "much too low\n%swear from %.4g um more than the others is not seen at this feed, speed and "
                      "offset\n%s",
                      highest->height_mm * kUmPerMm, highest->start_rad * kDegPerRad, lowest->height_mm * kUmPerMm,
                      lowest->start_rad * kDegPerRad, Table(rows), unseen_um,
                      apart.ok() ? "" : absl::StrCat("warning: ", apart.message(), "\n")));
  return absl::OkStatus();
}

}  // namespace

void AddToolSetterCurve(CLI::App& toolsetter, Context& context) {
  auto arguments = std::make_shared<CurveArguments>();
  CLI::App* curve = toolsetter.add_subcommand(
      "curve",
      "The length characteristic curve of a round-insert mill: what each start angle of the spindle would read");
  curve->add_option("CUTTER", arguments->cutter, "its cutter.json")->required();
  curve->add_option("--rpm", arguments->rpm, "spindle speed, instead of the file's");
  curve->add_option("--feed", arguments->feed, "feed in mm/min, instead of the file's");
  curve->add_option("--height", arguments->height, "start height in mm above the beam, instead of the file's");
  curve->add_option("--wear", arguments->wear, "wear of each insert in mm, instead of the file's: \"0 0.005\"");
  curve->add_option("--step", arguments->step_deg, "degrees between start angles")
      ->check(CLI::Range(0.001, 90.0))
      ->capture_default_str();
  curve->add_option("-o,--output", arguments->output, "write the curve as CSV");
  curve->footer("Example: axiscal toolsetter curve cutter.json --feed 10 --wear \"0 0.005\" -o curve.csv");
  SetAction(curve, context, [&context, arguments] { return Curve(context, *arguments); });
}

}  // namespace axiscal::cli
