#include "core/predict/poses.h"

#include <algorithm>
#include <cmath>

#include "core/base/files.h"
#include "core/base/units.h"
#include "core/instruments/motion.h"
#include "core/predict/number_cells.h"
#include "core/session/pose_reader.h"

namespace axiscal::predict {
namespace {

using session::PoseBlock;
using session::PoseReader;

// A thousandth of a nanometre: far below what any model knows, so that differences of rows are those of the model.
constexpr int kDigits = 6;
constexpr double kReadShare = 0.3;  // of the progress: the first reading

// What one row alone does not say.
struct WholeFile {
  std::vector<instruments::FirstMotion::Start> starts;            // the motion to its first row
  std::shared_ptr<const shapes::Temperatures> history = nullptr;  // where an error remembers temperatures
};

bool RemembersTemperatures(const machine::ErrorModel& model) {
  return std::any_of(model.terms.begin(), model.terms.end(), [](const machine::ErrorTerm& term) {
    return std::holds_alternative<shapes::ThermalLag>(term.shape);
  });
}

// Reads every row once, and that it can be read.
absl::StatusOr<WholeFile> ReadWhole(const std::string& poses, const machine::Machine& machine,
                                    const machine::ErrorModel& model, const std::function<void(double)>& progress) {
  ASSIGN_OR_RETURN(const std::unique_ptr<PoseReader> reader, PoseReader::Open(poses, machine));
  RETURN_IF_ERROR(base::Within(poses, RequireState(machine, model, reader->has_time(), reader->channels())));
  instruments::FirstMotion first(machine.axis_count());
  std::vector<double> time_s;
  std::vector<shapes::Temperatures::Channel> channels;
  if (RemembersTemperatures(model)) {
    for (const std::string& name : reader->channels()) channels.push_back({name, {}});
  }
  WholeFile file;
  PoseBlock block;
  while (true) {
    RETURN_IF_ERROR(reader->Next(&block));
    if (block.count == 0) break;
    for (size_t k = 0; k < block.count; ++k)
      first.Add(&block.positions[k * machine.axes.size()], reader->has_time() ? &block.time_s[k] : nullptr);
    for (size_t i = 0; i < channels.size(); ++i)
      channels[i].celsius.insert(channels[i].celsius.end(), block.celsius[i].begin(), block.celsius[i].end());
    if (!channels.empty()) {
      block.time_s.resize(block.count, 0.0);  // without a clock only what acts at once may stand in the model
      time_s.insert(time_s.end(), block.time_s.begin(), block.time_s.end());
    }
    if (progress) progress(kReadShare * reader->fraction());
  }
  file.starts = first.starts();
  if (!channels.empty())
    file.history = std::make_shared<const shapes::Temperatures>(std::move(time_s), std::move(channels));
  return file;
}

void AppendErrors(const ToolPointError& error, std::string* line) {
  for (int i = 0; i < 6; ++i) {
    if (i > 0) line->push_back(',');
    AppendCell(error[i] * (i < 3 ? base::kUmPerMm : base::kUradPerRad), kDigits, line);
  }
}

struct Sums {
  PredictedPoses made;
  double squares = 0.0, turn_squares = 0.0;

  void Add(const ToolPointError& error) {
    ++made.rows;
    squares += error.head<3>().squaredNorm();
    turn_squares += error.tail<3>().squaredNorm();
    made.max_mm = std::max(made.max_mm, error.head<3>().norm());
    made.max_rad = std::max(made.max_rad, error.tail<3>().norm());
  }
  PredictedPoses Made() const {
    PredictedPoses out = made;
    out.rms_mm = std::sqrt(squares / static_cast<double>(made.rows));
    out.rms_rad = std::sqrt(turn_squares / static_cast<double>(made.rows));
    return out;
  }
};

}  // namespace

absl::StatusOr<PredictedPoses> PredictPoses(const std::string& poses, const std::string& output,
                                            const machine::Machine& machine, const machine::KnownErrors& errors,
                                            const Eigen::Vector3d& tip_mm,
                                            const std::function<void(double fraction)>& progress) {
  ASSIGN_OR_RETURN(const WholeFile whole, ReadWhole(poses, machine, errors.model, progress));
  ASSIGN_OR_RETURN(const std::unique_ptr<PoseReader> reader, PoseReader::Open(poses, machine));
  base::AtomicFile file;
  RETURN_IF_ERROR(file.Open(output));
  RETURN_IF_ERROR(
      file.Write("ex_um,ey_um,ez_um,ea_urad,eb_urad,ec_urad,"
                 "ex_sigma_um,ey_sigma_um,ez_sigma_um,ea_sigma_urad,eb_sigma_urad,ec_sigma_urad\n"));
  ToolPoint tool(machine, errors, tip_mm);
  instruments::Motion motion(whole.starts);
  std::vector<shapes::AxisState> axes(machine.axes.size());
  Sums sums;
  sums.made.has_sigma = !errors.covariance.is_empty();
  PoseBlock block, following;  // how fast an axis is at a row its next one says, too
  const auto moment_of = [&](const PoseBlock& of, size_t k) {
    return k < of.count ? instruments::Moment{&of.positions[k * axes.size()],
                                              reader->has_time() ? &of.time_s[k] : nullptr, nullptr}
                        : instruments::Moment();
  };
  int moment = 0;
  std::string text;
  RETURN_IF_ERROR(reader->Next(&following));
  while (following.count > 0) {
    std::swap(block, following);
    RETURN_IF_ERROR(reader->Next(&following));
    text.clear();
    for (size_t k = 0; k < block.count; ++k) {
      const double* const time_s = moment_of(block, k).time_s;
      motion.Next(moment_of(block, k), k + 1 < block.count ? moment_of(block, k + 1) : moment_of(following, 0),
                  axes.data());
      shapes::State state{axes};
      if (time_s != nullptr) state.time_s = *time_s;
      if (reader->has_temperature()) state.temperature_celsius = block.temperature_celsius[k];
      state.temperatures = whole.history.get();
      state.moment = moment++;
      const ToolPointError error = tool.ErrorAt(state);
      if (!error.allFinite())
        return absl::InvalidArgumentError(absl::StrCat(poses, ": pose ", sums.made.rows + 1, " (t_s = ", state.time_s,
                                                       "): the tool point's error is without bound, must be finite"));
      sums.Add(error);
      AppendErrors(error, &text);
      text.push_back(',');
      if (sums.made.has_sigma) {
        AppendErrors(tool.SigmaAt(state), &text);
      } else {
        text += ",,,,,";
      }
      text.push_back('\n');
    }
    RETURN_IF_ERROR(file.Write(text));
    if (progress) progress(kReadShare + (1.0 - kReadShare) * reader->fraction());
  }
  RETURN_IF_ERROR(file.Commit());
  return sums.Made();
}

}  // namespace axiscal::predict
