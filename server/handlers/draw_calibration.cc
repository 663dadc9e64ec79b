#include "server/handlers/draw_calibration.h"

#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "core/base/error_detail.h"
#include "core/base/language.h"
#include "core/loop/pictures.h"
#include "server/handlers/calibration_fit.h"
#include "server/handlers/get_server_info.h"

namespace axiscal::handlers {
namespace {

// Of the message; the rest is room for names and the envelope.
constexpr size_t kMaxPictureBytes = kMaxMessageBytes - (256 << 10);

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

absl::StatusOr<base::Language> LanguageOf(const std::string& name) {
  if (name.empty() || name == "en") return base::Language::kEnglish;
  if (name == "de") return base::Language::kGerman;
  return base::Error(absl::StatusCode::kInvalidArgument, absl::StrCat("language = '", name, "', must be en or de"),
                     {"FIELD_INVALID", {{"field", "language"}}});
}

}  // namespace

absl::StatusOr<v1::DrawCalibrationResponse> DrawCalibration(Core& core, const Call& call,
                                                            const v1::DrawCalibrationRequest& request) {
  ASSIGN_OR_RETURN(const base::Language language, LanguageOf(request.language()));
  ASSIGN_OR_RETURN(const std::shared_ptr<const CalibrationFit> fit,
                   core.fits->Of(core.database, CalibrationId(request.calibration_id()), call.is_cancelled));
  v1::DrawCalibrationResponse response;
  response.set_readings(fit->readings());
  loop::Report report;
  report.fitted.model = fit->model;
  for (size_t i = 0; i < fit->runs.size(); ++i)
    report.residuals.push_back({fit->runs[i].session, false, fit->before_mm[i], fit->after_mm[i]});
  std::vector<loop::Picture> pictures = loop::Pictures(fit->machine, fit->runs, {}, report, language);
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
