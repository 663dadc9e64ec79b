#include "core/loop/pictures.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>

#include "core/base/units.h"
#include "core/shapes/depends_on.h"

namespace axiscal::loop {
namespace {

using base::kDegPerRad;
using base::kUmPerMm;
using instruments::MeasuringRun;
using machine::Machine;

bool IsRotary(const Machine& machine, int axis) { return machine.axes[axis].kind == machine::AxisKind::kRotary; }

class Painter {
 public:
  Painter(const Machine& machine, const std::vector<MeasuringRun>& fit, const std::vector<MeasuringRun>& check,
          const Report& report, base::Language language)
      : machine_(machine), report_(report), language_(language) {
    for (const auto* runs : {&fit, &check}) {
      for (const MeasuringRun& run : *runs) runs_.push_back(&run);
    }
  }

  void AddResiduals() {
    for (int axis = 0; axis < machine_.axis_count(); ++axis) {
      const std::string& name = machine_.axes[axis].name;
      const bool is_rotary = IsRotary(machine_, axis);
      const double unit = is_rotary ? kDegPerRad : 1.0;
      AddResidual(
          "residual-" + name, absl::StrCat(name, is_rotary ? Degrees() : ", mm"), name,
          [axis, unit](const MeasuringRun& run, int k) { return run.PositionsOf(k)[axis] * unit; }, axis);
    }
    AddResidual("residual-time", In("time, s", "Zeit, s"), In("time", "Zeit"),
                [](const MeasuringRun& run, int k) { return run.time_s[k]; });
    AddResidual("residual-temperature", In("temperature, deg C", "Temperatur, °C"), In("temperature", "Temperatur"),
                [](const MeasuringRun& run, int k) { return run.temperature_celsius[k]; });
  }

  // The order of what is periodic, which a curve hardly shows.
  void AddSpectra() {
    for (int axis = 0; axis < machine_.axis_count(); ++axis) AddSpectrum(axis);
  }

  void AddTraces() {
    std::map<std::string, std::vector<size_t>> groups;
    std::vector<std::string> order;
    for (size_t i = 0; i < runs_.size(); ++i) {
      if (runs_[i]->kind != instruments::Kind::kBallbar) continue;
      const std::string key = absl::StrCat(report_.residuals[i].is_check, "|", PlaceOf(*runs_[i]));
      if (groups[key].empty()) order.push_back(key);
      groups[key].push_back(i);
    }
    for (const std::string& key : order) AddTrace(groups[key]);
  }

  // Errors that change along one axis alone, as the model has them, and the orders that they are made of.
  void AddFound() {
    std::map<std::pair<std::string, int>, std::vector<const machine::ErrorTerm*>> groups;
    for (const machine::ErrorTerm& term : report_.fitted.model.terms) {
      const std::optional<int> axis = shapes::VariableAxis(term.shape);
      const bool is_of_position = axis && !shapes::SecondAxis(term.shape) && !shapes::DependsOnTime(term.shape) &&
                                  !shapes::ChannelOf(term.shape) && !shapes::IsAlongApproach(term.shape);
      if (is_of_position && machine::HasName(term)) groups[{machine::SymbolOf(machine_, term), *axis}].push_back(&term);
    }
    for (const auto& [key, terms] : groups) AddFound(key.first, key.second, terms);
  }

  void AddRanking() {
    std::vector<plot::Bar> bars;
    for (const Ranked& scored : report_.ranking) {
      bars.push_back({NameOf(scored.candidate), scored.score});
    }
    if (bars.empty()) return;
    pictures_.push_back(
        {"ranking.svg",
         plot::BarChart(absl::StrFormat("What the declared model lacks: the best of %d candidates", report_.candidates),
                        "score: chi-square gained, less the penalty for looking", bars, report_.evidence,
                        "significant beyond here"),
         {},
         {},
         {}});
  }

  std::vector<Picture> Finish() { return std::move(pictures_); }

 private:
  using Variable = std::function<double(const MeasuringRun&, int)>;

  std::string NameOf(const Candidate& candidate) const {
    if (candidate.family == Family::kStep) return absl::StrCat("slip at reading ", candidate.first_reading + 1);
    const auto* bump = std::get_if<shapes::Bump>(&candidate.term.shape);
    if (bump == nullptr) return machine::NameOf(machine_, candidate.term);
    const bool is_rotary = IsRotary(machine_, bump->axis);
    return absl::StrFormat("%s: local at %s %.0f %s", machine::SymbolOf(machine_, candidate.term),
                           machine_.axes[bump->axis].name, bump->at * (is_rotary ? kDegPerRad : 1.0),
                           is_rotary ? "deg" : "mm");
  }

  std::string In(const char* english, const char* german) const {
    return language_ == base::Language::kGerman ? german : english;
  }
  std::string Degrees() const { return In(", deg", ", °"); }
  std::string Um() const { return In("um", "µm"); }
  std::string When(bool is_after) const { return is_after ? In("after", "nachher") : In("before", "vorher"); }
  std::string MeasuredLessPredicted() const {
    return In("measured - predicted, um", "gemessen minus vorhergesagt, µm");
  }

  // "before: rms 12 um"
  std::string PanelTitle(bool is_after, double sum, double count) const {
    const std::string rms = absl::StrFormat("%.3g", count > 0.0 ? std::sqrt(sum / count) : 0.0);
    return absl::StrCat(When(is_after), ": ", In("rms", "quadr. Mittel"), " ", base::NumberIn(language_, rms), " ",
                        Um());
  }

  // measured - predicted, um.
  const Eigen::MatrixXd& ResidualsOf(size_t run, bool is_after) const {
    return is_after ? report_.residuals[run].after_mm : report_.residuals[run].before_mm;
  }

  // Of each reading the sense in which the axis came there, as stated or as it moved: 1, -1, or 0 where that is not
  // known.
  static std::vector<int> SensesOf(const MeasuringRun& run, int axis) {
    constexpr double kMoved = 1e-6;  // mm or rad
    std::vector<int> senses(static_cast<size_t>(run.reading_count()), 0);
    int sense = 0;
    size_t unknown = 0;  // readings before the first motion came from where it begins
    for (int k = 0; k < run.reading_count(); ++k) {
      const size_t at = static_cast<size_t>(k) * run.axis_count + axis;
      const double step = k > 0 ? run.PositionsOf(k)[axis] - run.PositionsOf(k - 1)[axis] : 0.0;
      if (std::abs(step) > kMoved) sense = step > 0.0 ? 1 : -1;
      if (sense != 0 && unknown == 0) {
        std::fill(senses.begin(), senses.begin() + k, sense);
        unknown = 1;
      }
      senses[static_cast<size_t>(k)] = sense;
      if (!run.stated_senses.empty()) senses[static_cast<size_t>(k)] = static_cast<int>(run.stated_senses[at]);
    }
    return senses;
  }

  // The readings in series: those of an axis that was gone along both ways by the sense of its motion, as backlash
  // shows between them.
  static std::vector<plot::Series> BySense(const MeasuringRun& run, std::optional<int> axis, const std::string& name,
                                           const Eigen::MatrixXd& residuals_um, const Variable& variable) {
    std::vector<plot::Series> series = {{name, {}}};
    std::vector<int> senses;
    if (axis) senses = SensesOf(run, *axis);
    constexpr int64_t kFew = 3;
    const auto count = [&](int sense) { return std::count(senses.begin(), senses.end(), sense); };
    const bool goes_both_ways = count(1) > kFew && count(-1) > kFew;
    if (goes_both_ways) series = {{name + " +", {}}, {name + " -", {}}, {name, {}}};
    for (Eigen::Index k = 0; k < residuals_um.cols(); ++k) {
      const int sense = goes_both_ways ? senses[static_cast<size_t>(k)] : 1;
      plot::Series& of = series[sense > 0 ? 0 : sense < 0 ? 1 : 2];
      for (Eigen::Index row = 0; row < residuals_um.rows(); ++row)
        of.points.push_back({variable(run, static_cast<int>(k)), residuals_um(row, k)});
    }
    std::erase_if(series, [](const plot::Series& one) { return one.points.empty(); });
    return series;
  }

  void AddResidual(const std::string& file, const std::string& label, const std::string& name, const Variable& variable,
                   std::optional<int> axis = {}) {
    double lowest = INFINITY, highest = -INFINITY;
    for (const MeasuringRun* run : runs_) {
      for (int k = 0; k < run->reading_count(); ++k) {
        lowest = std::min(lowest, variable(*run, k));
        highest = std::max(highest, variable(*run, k));
      }
    }
    constexpr double kStandsStill = 1e-3;
    if (!(highest - lowest > kStandsStill)) return;
    std::vector<plot::Panel> panels;
    for (const bool is_after : {false, true}) {
      plot::Panel panel;
      double sum = 0.0, count = 0.0;
      for (size_t i = 0; i < runs_.size(); ++i) {
        const Eigen::MatrixXd residuals_um = -kUmPerMm * ResidualsOf(i, is_after);
        const std::string session =
            absl::StrCat(report_.residuals[i].session, report_.residuals[i].is_check ? In(" (check)", " (prüft)") : "");
        for (plot::Series& series : BySense(*runs_[i], axis, session, residuals_um, variable)) {
          series.points = plot::Thinned(std::move(series.points));
          panel.series.push_back(std::move(series));
        }
        sum += residuals_um.squaredNorm();
        count += static_cast<double>(residuals_um.size());
      }
      panel.title = PanelTitle(is_after, sum, count);
      panels.push_back(std::move(panel));
    }
    const std::string value = MeasuredLessPredicted();
    pictures_.push_back({file + ".svg",
                         plot::ScatterChart(In("Residuals against ", "Restfehler über ") + name, label, value, panels,
                                            plot::Ground::kMiddle, language_),
                         label, value, panels});
  }

  // How many different positions of an axis a run has.
  static int PositionCount(const MeasuringRun& run, int axis) {
    constexpr double kApart = 1e-6;  // mm or rad
    std::set<int64_t> found;
    for (int k = 0; k < run.reading_count(); ++k) found.insert(std::llround(run.PositionsOf(k)[axis] / kApart));
    return static_cast<int>(found.size());
  }

  // Amplitudes of orders 1, 2 ... of a run's residuals over an axis, um.
  plot::Series OrdersOf(size_t run, int axis, double period, bool is_after) const {
    constexpr int kMostOrders = 36, kPositionsPerOrder = 3;
    const MeasuringRun& measured = *runs_[run];
    const Eigen::MatrixXd& residuals_mm = ResidualsOf(run, is_after);
    plot::Series series = {report_.residuals[run].session, {}};
    const int most = std::min(kMostOrders, PositionCount(measured, axis) / kPositionsPerOrder);
    Eigen::MatrixXd columns(measured.reading_count(), 3);
    for (int order = 1; order <= most; ++order) {
      for (int k = 0; k < measured.reading_count(); ++k) {
        const double angle = 2.0 * M_PI * order * measured.PositionsOf(k)[axis] / period;
        columns.row(k) << 1.0, std::cos(angle), std::sin(angle);
      }
      const Eigen::MatrixXd fitted = columns.colPivHouseholderQr().solve(residuals_mm.transpose());  // 3 x rows
      series.points.push_back({static_cast<double>(order), kUmPerMm * fitted.bottomRows(2).norm()});
    }
    return series;
  }

  void AddSpectrum(int axis) {
    const bool is_rotary = IsRotary(machine_, axis);
    const std::string& name = machine_.axes[axis].name;
    double lowest = INFINITY, highest = -INFINITY;
    for (const MeasuringRun* run : runs_) {
      const auto [low, high] = RangeOf(*run, axis);
      lowest = std::min(lowest, low);
      highest = std::max(highest, high);
    }
    const double period = is_rotary ? 2.0 * M_PI : highest - lowest;
    constexpr double kMostOfIt = 0.8;
    constexpr int kFewPositions = 12;
    std::vector<plot::Panel> panels = {{When(false), {}}, {When(true), {}}};
    for (size_t i = 0; i < runs_.size(); ++i) {
      const auto [low, high] = RangeOf(*runs_[i], axis);
      // Readings at rest are left to the drift; over a part of the period orders are not told apart.
      const bool has_many = high > low && PositionCount(*runs_[i], axis) >= kFewPositions;
      if (!has_many || high - low < kMostOfIt * period || ResidualsOf(i, false).cols() != runs_[i]->reading_count())
        continue;
      for (const bool is_after : {false, true}) panels[is_after].series.push_back(OrdersOf(i, axis, period, is_after));
    }
    if (panels[0].series.empty()) return;
    const std::string label = OrderLabel(axis, period);
    const std::string value = In("amplitude, um", "Amplitude, µm");
    pictures_.push_back(
        {"spectrum-" + name + ".svg",
         plot::ScatterChart(In("Spectrum of the residuals over ", "Spektrum der Restfehler über ") + name, label, value,
                            panels, plot::Ground::kBottom, language_),
         label, value, panels});
  }

  static constexpr int kFoundPoints = 720;  // of a curve

  // um or urad at a position, mm or rad, that the axis came to in this sense.
  double ErrorAt(const std::vector<const machine::ErrorTerm*>& terms, int axis, double position, double sense) const {
    std::vector<shapes::AxisState> axes(static_cast<size_t>(machine_.axis_count()));
    axes[static_cast<size_t>(axis)].position = position;
    axes[static_cast<size_t>(axis)].sense = sense;
    shapes::State state;
    state.axes = axes;
    double error = 0.0;
    for (const machine::ErrorTerm* term : terms) {
      std::array<double, shapes::kMaxBasisCount> basis = {};
      shapes::Basis(term->shape, state, basis.data());
      for (int i = 0; i < shapes::BasisCount(term->shape); ++i) error += term->amplitude[i] * basis[i];
    }
    return error * (machine::IsAngle(terms[0]->component) ? base::kUradPerRad : kUmPerMm);
  }

  void AddFound(const std::string& symbol, int axis, const std::vector<const machine::ErrorTerm*>& terms) {
    double low = INFINITY, high = -INFINITY;
    for (const MeasuringRun* run : runs_) {
      const auto [least, greatest] = RangeOf(*run, axis);
      low = std::min(low, least);
      high = std::max(high, greatest);
    }
    constexpr double kStandsStill = 1e-3;
    if (!(high - low > kStandsStill)) return;
    const bool is_rotary = IsRotary(machine_, axis);
    const std::string& name = machine_.axes[axis].name;
    const std::string unit = machine::IsAngle(terms[0]->component) ? In("urad", "µrad") : Um();
    plot::Panel panel = {In("found", "gefunden"), {{"+", {}}, {"-", {}}}};
    bool is_by_sense = false;
    for (int k = 0; k <= kFoundPoints; ++k) {
      const double position = low + (high - low) * k / kFoundPoints;
      for (const int way : {0, 1}) {
        panel.series[static_cast<size_t>(way)].points.push_back(
            {position * (is_rotary ? kDegPerRad : 1.0), ErrorAt(terms, axis, position, way == 0 ? 1.0 : -1.0)});
      }
      is_by_sense |= panel.series[0].points.back().y != panel.series[1].points.back().y;
    }
    if (!is_by_sense) {
      panel.series.pop_back();
      panel.series[0].name = symbol;
    }
    const std::string file = absl::StrCat(symbol, "-", name),
                      label = absl::StrCat(name, is_rotary ? Degrees() : ", mm"),
                      value = absl::StrCat(symbol, ", ", unit);
    pictures_.push_back(
        {absl::StrCat("found-", file, ".svg"),
         plot::ScatterChart(absl::StrCat(symbol, In(" over ", " über "), name, In(" as found", ", wie gefunden")),
                            label, value, {panel}, plot::Ground::kMiddle, language_),
         label,
         value,
         {panel}});
    AddOrders(symbol, axis, terms, unit, is_rotary ? 2.0 * M_PI : high - low, low, high);
  }

  // Of a rotary axis over a turn, where the most of one was measured; of a linear one over the measured way.
  void AddOrders(const std::string& symbol, int axis, const std::vector<const machine::ErrorTerm*>& terms,
                 const std::string& unit, double period, double low, double high) {
    constexpr double kMostOfIt = 0.8;
    if (high - low < kMostOfIt * period) return;
    constexpr int kOrders = 60;
    std::vector<double> errors;
    for (int k = 0; k < kFoundPoints; ++k) {
      const double position = low + period * k / kFoundPoints;
      errors.push_back(0.5 * (ErrorAt(terms, axis, position, 1.0) + ErrorAt(terms, axis, position, -1.0)));
    }
    plot::Series series = {symbol, {}};
    for (int order = 1; order <= kOrders; ++order) {
      double cosine = 0.0, sine = 0.0;
      for (int k = 0; k < kFoundPoints; ++k) {
        const double angle = 2.0 * M_PI * order * k / kFoundPoints;
        cosine += errors[static_cast<size_t>(k)] * std::cos(angle);
        sine += errors[static_cast<size_t>(k)] * std::sin(angle);
      }
      series.points.push_back({static_cast<double>(order), 2.0 / kFoundPoints * std::hypot(cosine, sine)});
    }
    const std::string &name = machine_.axes[axis].name, label = OrderLabel(axis, period),
                      value = absl::StrCat(In("amplitude, ", "Amplitude, "), unit);
    const std::vector<plot::Panel> panels = {{In("found", "gefunden"), {series}}};
    pictures_.push_back(
        {absl::StrCat("orders-", symbol, "-", name, ".svg"),
         plot::ScatterChart(absl::StrCat(In("Spectrum of ", "Spektrum von "), symbol, In(" over ", " über "), name,
                                         In(" as found", ", wie gefunden")),
                            label, value, panels, plot::Ground::kBottom, language_),
         label, value, panels});
  }

  // `period`: of order 1, mm or rad.
  std::string OrderLabel(int axis, double period) const {
    const std::string& name = machine_.axes[axis].name;
    return IsRotary(machine_, axis)
               ? In("order: cycles per turn of ", "Ordnung: Perioden je Umdrehung von ") + name
               : absl::StrCat(In("order: cycles over the ", "Ordnung: Perioden über die "),
                              base::NumberIn(language_, absl::StrFormat("%.4g", period)), In(" mm of ", " mm von "),
                              name, In(" that were measured", ", die gemessen wurden"));
  }

  std::vector<int> MovingAxes(const MeasuringRun& run) const {
    std::vector<int> moving;
    for (int axis = 0; axis < run.axis_count; ++axis) {
      const auto [lowest, highest] = RangeOf(run, axis);
      constexpr double kMoves = 1e-2;  // mm or rad
      if (highest - lowest > kMoves) moving.push_back(axis);
    }
    return moving;
  }

  static std::pair<double, double> RangeOf(const MeasuringRun& run, int axis) {
    double lowest = INFINITY, highest = -INFINITY;
    for (int k = 0; k < run.reading_count(); ++k) {
      lowest = std::min(lowest, run.PositionsOf(k)[axis]);
      highest = std::max(highest, run.PositionsOf(k)[axis]);
    }
    return {lowest, highest};
  }

  // Runs with the same text went over the same positions.
  std::string PlaceOf(const MeasuringRun& run) const {
    std::string place =
        absl::StrFormat("%.1f %.0f %.0f %.0f %.0f %.0f %.0f", run.bar_length_mm, run.tip_mm.x(), run.tip_mm.y(),
                        run.tip_mm.z(), run.ball_mm.x(), run.ball_mm.y(), run.ball_mm.z());
    for (int axis = 0; axis < run.axis_count; ++axis) {
      const auto [lowest, highest] = RangeOf(run, axis);
      const double unit = IsRotary(machine_, axis) ? kDegPerRad : 1.0;
      absl::StrAppend(&place, absl::StrFormat("|%.0f %.0f", lowest * unit + 0.25, highest * unit + 0.25));
    }
    return place;
  }

  // Where on the trace a reading stands: the rotary axis that turns, or the angle in the plane of two linear axes.
  // Unwrapped, so that its sense is that of the motion. Empty where nothing turns.
  std::vector<double> AnglesOf(const MeasuringRun& run, std::string* text) const {
    const std::vector<int> moving = MovingAxes(run);
    std::vector<double> angles;
    for (const int axis : moving) {
      if (!IsRotary(machine_, axis)) continue;
      *text = absl::StrCat(In("angle of ", "Winkel von "), machine_.axes[axis].name, Degrees());
      for (int k = 0; k < run.reading_count(); ++k) angles.push_back(run.PositionsOf(k)[axis]);
      return angles;
    }
    if (moving.size() != 2) return {};
    // XY, YZ and ZX as ISO 230-4 draws them, whatever the order of the description.
    int first = moving[0], second = moving[1];
    if (machine_.axes[first].name > machine_.axes[second].name) std::swap(first, second);
    if (machine_.axes[first].name == "X" && machine_.axes[second].name == "Z") std::swap(first, second);
    *text =
        absl::StrCat(In("angle in ", "Winkel in "), machine_.axes[first].name, machine_.axes[second].name, Degrees());
    const auto [low1, high1] = RangeOf(run, first);
    const auto [low2, high2] = RangeOf(run, second);
    double last = 0.0;
    for (int k = 0; k < run.reading_count(); ++k) {
      double angle = std::atan2(run.PositionsOf(k)[second] - 0.5 * (low2 + high2),
                                run.PositionsOf(k)[first] - 0.5 * (low1 + high1));
      angle += 2.0 * M_PI * std::round((last - angle) / (2.0 * M_PI));
      angles.push_back(angle);
      last = angle;
    }
    return angles;
  }

  void AddTrace(const std::vector<size_t>& group) {
    std::string text, names;
    std::vector<plot::Panel> panels(2);
    for (const bool is_after : {false, true}) {
      plot::Panel& panel = panels[is_after];
      double sum = 0.0, count = 0.0;
      for (const size_t i : group) {
        const MeasuringRun& run = *runs_[i];
        const std::vector<double> angles = AnglesOf(run, &text);
        if (angles.empty()) return;
        if (!is_after) absl::StrAppend(&names, names.empty() ? "" : ", ", run.session);
        for (const bool is_clockwise : {false, true}) {
          plot::Series series = {
              absl::StrCat(run.session, is_clockwise ? In(" CW", " im UZS") : In(" CCW", " gegen UZS")), {}};
          for (int k = 0; k < run.reading_count(); ++k) {
            const double step =
                k > 0 ? angles[k] - angles[k - 1] : angles[std::min<size_t>(1, angles.size() - 1)] - angles[0];
            if ((step < 0.0) != is_clockwise) continue;
            series.points.push_back({angles[k], -kUmPerMm * ResidualsOf(i, is_after)(0, k)});
          }
          constexpr size_t kFew = 3;
          if (series.points.size() > kFew) panel.series.push_back(std::move(series));
        }
        sum += ResidualsOf(i, is_after).squaredNorm() * kUmPerMm * kUmPerMm;
        count += static_cast<double>(run.reading_count());
      }
      panel.title = PanelTitle(is_after, sum, count);
    }
    const SessionResiduals& first = report_.residuals[group[0]];
    std::vector<plot::Panel> in_degrees = panels;
    for (plot::Panel& panel : in_degrees) {
      for (plot::Series& series : panel.series) {
        for (plot::Point& point : series.points) point.x *= kDegPerRad;
        series.points = plot::Thinned(std::move(series.points));
      }
    }
    pictures_.push_back(
        {NewFile(absl::StrCat("trace-", first.is_check ? "check-" : "", FileName(first.session))),
         plot::PolarChart(absl::StrCat(In("Ball bar ", "Kreisformtest "), names,
                                       In(": measured - predicted, ", ": gemessen minus vorhergesagt, "), text),
                          Um(), panels, language_),
         text, MeasuredLessPredicted(), in_degrees});
  }

  // The name with .svg, counted on where sessions whose names differ by other characters alone came before.
  std::string NewFile(const std::string& name) const {
    std::string file = name + ".svg";
    const auto is_it = [&file](const Picture& picture) { return picture.file == file; };
    for (int i = 2; std::any_of(pictures_.begin(), pictures_.end(), is_it); ++i)
      file = absl::StrCat(name, "-", i, ".svg");
    return file;
  }

  static std::string FileName(const std::string& session) {
    std::string name = session;
    for (char& c : name) {
      const bool is_plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-';
      if (!is_plain) c = '-';
    }
    return name;
  }

  const Machine& machine_;
  const Report& report_;
  const base::Language language_;
  std::vector<const MeasuringRun*> runs_;
  std::vector<Picture> pictures_;
};

}  // namespace

std::vector<Picture> Pictures(const Machine& machine, const std::vector<MeasuringRun>& fit,
                              const std::vector<MeasuringRun>& check, const Report& report, base::Language language) {
  Painter painter(machine, fit, check, report, language);
  painter.AddResiduals();
  painter.AddSpectra();
  painter.AddTraces();
  painter.AddFound();
  painter.AddRanking();
  return painter.Finish();
}

}  // namespace axiscal::loop
