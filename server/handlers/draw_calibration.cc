#include "server/handlers/draw_calibration.h"

#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "core/base/error_detail.h"
#include "core/identify/identify.h"
#include "core/loop/pictures.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "server/handlers/get_server_info.h"
#include "server/jobs/job_sessions.h"

namespace axiscal::handlers {
namespace {

// Of the message; the rest is room for names and the envelope.
constexpr size_t kMaxPictureBytes = kMaxMessageBytes - (256 << 10);

// The set-ups fitted where the errors of `model` act at their values: what is left of the readings shows what the model
// does not explain, and no freedom of a new fit hides it.
absl::StatusOr<identify::Fit> FitSetUps(const machine::Machine& machine, std::vector<instruments::MeasuringRun> runs,
                                        const machine::ErrorModel& model, const Call& call) {
  identify::Options options;
  options.model = machine::ErrorModel{};
  // Only residuals are asked for.
  options.scale_uncertainties = options.judge_correlation = options.profile_intervals = false;
  options.cancelled = call.is_cancelled;
  if (!model.terms.empty()) {
    ASSIGN_OR_RETURN(options.held_errors, identify::HoldErrors(model, std::nullopt, machine));
  }
  return identify::FitRuns(machine, std::move(runs), options);
}

// As JSON, which is longer than the binary form.
size_t BytesOfNumbers(const loop::Picture& picture) {
  constexpr size_t kBytesOfPoint = 40;
  size_t bytes = 0;
  for (const plot::Panel& panel : picture.panels) {
    for (const plot::Series& series : panel.series)
      bytes += kBytesOfPoint * series.points.size() + panel.title.size() + series.name.size();
  }
  return bytes;
}

// To the digits that a picture is read with.
double Rounded(double number) {
  double rounded = 0.0;
  return absl::SimpleAtod(absl::StrFormat("%.6g", number), &rounded) ? rounded : number;
}

void AddNumbers(const loop::Picture& picture, v1::CalibrationPicture* sent) {
  sent->set_x_label(picture.x_label);
  sent->set_y_label(picture.y_label);
  for (const plot::Panel& panel : picture.panels) {
    for (const plot::Series& series : panel.series) {
      v1::PictureSeries& added = *sent->add_series();
      added.set_panel(panel.title);
      added.set_name(series.name);
      for (const plot::Point& point : series.points) {
        if (!std::isfinite(point.x) || !std::isfinite(point.y)) continue;
        added.add_x(Rounded(point.x));
        added.add_y(Rounded(point.y));
      }
    }
  }
}

}  // namespace

absl::StatusOr<v1::DrawCalibrationResponse> DrawCalibration(Core& core, const Call& call,
                                                            const v1::DrawCalibrationRequest& request) {
  ASSIGN_OR_RETURN(const records::CalibrationRecord calibration,
                   core.database.GetCalibration(CalibrationId(request.calibration_id())));
  const records::NewCalibration& content = calibration.content;
  ASSIGN_OR_RETURN(const records::MachineRecord described,
                   core.database.GetMachineRevision(content.machine, content.machine_revision));
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::MachineFromJson(described.description_json));
  ASSIGN_OR_RETURN(const machine::ErrorModel model, machine::ReadErrors(content.model_json, machine));
  ASSIGN_OR_RETURN(const jobs::MeasuredSessions measured,
                   jobs::LoadSessions(core.database, content.sessions, machine, call.is_cancelled));
  ASSIGN_OR_RETURN(const identify::Fit before, FitSetUps(machine, measured.runs, {}, call));
  ASSIGN_OR_RETURN(const identify::Fit after, FitSetUps(machine, measured.runs, model, call));

  v1::DrawCalibrationResponse response;
  loop::Report report;
  for (size_t i = 0; i < measured.runs.size(); ++i) {
    report.residuals.push_back({measured.runs[i].session, false, before.residuals_mm[i], after.residuals_mm[i]});
    response.set_readings(response.readings() + after.residuals_mm[i].size());
  }
  std::vector<loop::Picture> pictures = loop::Pictures(machine, measured.runs, {}, report);
  if (!request.file().empty()) {
    std::erase_if(pictures, [&](const loop::Picture& picture) { return picture.file != request.file(); });
    if (pictures.empty()) {
      return base::Error(
          absl::StatusCode::kNotFound,
          absl::StrCat("calibration ", request.calibration_id(), " has no picture '", request.file(), "'"),
          {"PICTURE_NOT_FOUND", {}});
    }
  }
  size_t bytes = 0;
  std::vector<const loop::Picture*> shown;
  for (loop::Picture& picture : pictures) {
    if (bytes + picture.svg.size() > kMaxPictureBytes) {
      response.add_left_out(picture.file);
      continue;
    }
    bytes += picture.svg.size();
    v1::CalibrationPicture& sent = *response.add_pictures();
    sent.set_file(std::move(picture.file));
    sent.set_svg(std::move(picture.svg));
    shown.push_back(&picture);
  }
  // Pictures come first: the numbers of one can be asked for alone.
  for (size_t i = 0; i < shown.size(); ++i) {
    const size_t numbers = BytesOfNumbers(*shown[i]);
    if (bytes + numbers > kMaxPictureBytes) continue;
    bytes += numbers;
    AddNumbers(*shown[i], response.mutable_pictures(static_cast<int>(i)));
  }
  return response;
}

}  // namespace axiscal::handlers
