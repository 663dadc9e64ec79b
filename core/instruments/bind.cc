#include <charconv>
#include <cmath>
#include <limits>

#include "core/base/units.h"
#include "core/instruments/bind_readings.h"
#include "core/instruments/centres/centres_model.h"
#include "core/instruments/eccentricity/eccentricity_bind.h"
#include "core/instruments/length/length_model.h"
#include "core/instruments/registry.h"
#include "core/instruments/run.h"
#include "core/instruments/stated.h"
#include "core/instruments/touch/touch_bind.h"
#include "core/instruments/tracker/tracker_bind.h"
#include "core/instruments/tracker/tracker_model.h"
#include "core/machine/redundant_facts.h"
#include "core/session/column_rules.h"
#include "core/session/header_rules.h"

namespace axiscal::instruments {
namespace {

using base::kMmPerUm;
using base::kRadPerDeg;
using session::Session;

class Binder {
 public:
  Binder(const Session& session, const machine::Machine& machine, size_t readings_before,
         const std::vector<size_t>* log_lines = nullptr)
      : session_(session), machine_(machine), log_lines_(log_lines) {
    run_.readings_before = static_cast<int>(readings_before);
  }

  absl::StatusOr<MeasuringRun> Bind(bool for_fit) {
    RETURN_IF_ERROR(BindHeader(for_fit));
    if (run_.kind == Kind::kEccentricity) return BindPaths();
    RETURN_IF_ERROR(BindReadings());
    RETURN_IF_ERROR(BindPositions());
    RETURN_IF_ERROR(BindTimes());
    if (run_.kind == Kind::kTouch) {
      RETURN_IF_ERROR(touch::BindTouches(machine_, session_, &run_));
      RETURN_IF_ERROR(touch::GateTouches(machine_, session_, &run_));
    }
    if (for_fit) {
      DeriveMotion(&run_);
      if (run_.kind == Kind::kTracker) run_.tracker_from_machine = tracker::StartingPose(machine_, run_);
      if (run_.kind == Kind::kLength && !length::HasStatedZero(run_))
        run_.length.zero_mm = length::StartingZero(machine_, run_);
    }
    RETURN_IF_ERROR(BindStated(session_, machine_, &run_));
    return std::move(run_);
  }

 private:
  absl::Status Refuse(const std::string& what) const {
    return absl::InvalidArgumentError(absl::StrCat("session '", run_.session, "': ", what));
  }

  absl::StatusOr<std::string> Text(const std::string& key) const {
    const std::optional<std::string> value = session::FindHeader(session_, key);
    if (!value) return Refuse(absl::StrCat("header key '", key, "' is missing"));
    return *value;
  }

  // `count` finite numbers separated by blanks.
  absl::StatusOr<std::vector<double>> Numbers(const std::string& key, size_t count) const {
    ASSIGN_OR_RETURN(const std::string text, Text(key));
    std::vector<double> numbers;
    const char* at = text.data();
    const char* const end = at + text.size();
    while (true) {
      while (at != end && (*at == ' ' || *at == '\t')) ++at;
      if (at == end) break;
      double number = 0.0;
      const auto [next, error] = std::from_chars(at, end, number);
      if (error != std::errc() || !std::isfinite(number)) break;
      numbers.push_back(number);
      at = next;
    }
    if (at != end || numbers.size() != count) {
      return Refuse(absl::StrCat("header '", key, ": ", text, "', expected ", count, " number(s)"));
    }
    return numbers;
  }

  absl::StatusOr<double> PositiveNumber(const std::string& key) const {
    ASSIGN_OR_RETURN(const std::vector<double> numbers, Numbers(key, 1));
    if (numbers[0] <= 0.0) return Refuse(absl::StrCat("header '", key, ": ", numbers[0], "', must be > 0"));
    return numbers[0];
  }

  absl::StatusOr<Eigen::Vector3d> Point(const std::string& key) const {
    ASSIGN_OR_RETURN(const std::vector<double> numbers, Numbers(key, 3));
    return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
  }

  // A header may state the setup better than the prior does: `# ball_x_sigma_um: 2`.
  absl::Status ReadPriors() {
    for (SetupParameter& parameter : run_.setup) {
      const std::string key = absl::StrCat(parameter.name, parameter.is_angle ? "_sigma_urad" : "_sigma_um");
      if (!session::FindHeader(session_, key)) continue;
      ASSIGN_OR_RETURN(const double sigma, PositiveNumber(key));
      parameter.prior_sigma = sigma * (parameter.is_angle ? base::kRadPerUrad : kMmPerUm);
      parameter.is_weak = false;  // stated by whoever mounted it: knowledge
      parameter.is_placed = true;
    }
    return absl::OkStatus();
  }

  absl::StatusOr<Eigen::Vector3d> UnitVector(const std::string& key) const {
    ASSIGN_OR_RETURN(const Eigen::Vector3d vector, Point(key));
    constexpr double kRounding = 1e-3;  // written with a few decimals
    if (std::abs(vector.norm() - 1.0) > kRounding)
      return Refuse(absl::StrCat("header '", key, "' has length ", vector.norm(), ", expected a unit vector"));
    return vector.normalized();
  }

  // Where what a reading counts from stands: `key: table`, the default, or `key: bed`.
  absl::Status ReadCarrier(const std::string& key, bool* is_on_bed) const {
    const std::string on = session::FindHeader(session_, key).value_or("table");
    if (on != "table" && on != "bed")
      return Refuse(absl::StrCat("header '", key, ": ", on, "', expected table or bed"));
    *is_on_bed = on == "bed";
    return absl::OkStatus();
  }

  absl::Status BindLength() {
    const bool has_anchor = session::FindHeader(session_, "anchor_mm").has_value();
    run_.length.is_beam = session::FindHeader(session_, "beam").has_value();
    if (has_anchor == run_.length.is_beam)
      return Refuse("expected either the header 'anchor_mm: x y z' or the header 'beam: ux uy uz'");
    RETURN_IF_ERROR(ReadCarrier("anchor_on", &run_.length.is_on_bed));
    if (has_anchor) {
      ASSIGN_OR_RETURN(run_.ball_mm, Point("anchor_mm"));
      return absl::OkStatus();
    }
    ASSIGN_OR_RETURN(run_.length.beam, UnitVector("beam"));
    run_.setup = length::BeamSetupParameters();
    return absl::OkStatus();
  }

  absl::Status BindDirection() {
    ASSIGN_OR_RETURN(run_.direction.about, UnitVector("about"));
    return ReadCarrier("reference", &run_.direction.is_on_bed);
  }

  absl::Status BindDatum() {
    const std::optional<std::string> text = session::FindHeader(session_, "datum");
    if (!text) return absl::OkStatus();
    if (run_.kind == Kind::kEccentricity) return Refuse("datum: eccentricities have no commanded positions");
    const auto names = session::ParseDatum(*text);
    if (!names.ok()) return base::Within("session '" + run_.session + "': datum", names.status());
    for (const std::string& name : *names) {
      const int axis = machine::FindAxis(machine_, name);
      if (axis < 0 || machine_.axes[axis].kind != machine::AxisKind::kLinear)
        return Refuse(absl::StrCat("datum: '", *text, "': ", name, " is no linear axis of machine ", machine_.id));
      if (run_.free_datum.size() == kMaxDatumAxes)
        return Refuse(absl::StrCat("datum: '", *text, "', expected at most ", kMaxDatumAxes, " axes"));
      AddDatum(machine_, axis, &run_);
    }
    return absl::OkStatus();
  }

  absl::Status BindHeader(bool for_fit) {
    run_.session = session::FindHeader(session_, "session").value_or("");
    ASSIGN_OR_RETURN(run_.session, Text("session"));
    ASSIGN_OR_RETURN(const std::string machine, Text("machine"));
    if (machine != machine_.id) {
      return Refuse(absl::StrCat("was measured on machine '", machine, "', expected '", machine_.id, "'"));
    }
    ASSIGN_OR_RETURN(const std::string name, Text("instrument"));
    instrument_ = FindInstrument(name);
    if (instrument_ == nullptr) return Refuse(absl::StrCat("instrument '", name, "' cannot be identified from yet"));
    run_.kind = instrument_->kind;
    run_.setup = instrument_->setup();
    const std::optional<std::string> setup = session::FindHeader(session_, "setup");
    run_.is_setup_stated = setup.has_value();
    run_.setup_name = setup.value_or(run_.session);
    ASSIGN_OR_RETURN(const double sigma_um, PositiveNumber("sigma_um"));
    run_.sigma_mm = sigma_um * kMmPerUm;
    ASSIGN_OR_RETURN(run_.tip_mm, Point("tool_tip_mm"));
    const absl::Status tip = machine::CheckToolTip(machine_, run_.tip_mm);
    if (!tip.ok()) return Refuse(std::string(tip.message()));
    if (instrument_->has_table_ball) {
      ASSIGN_OR_RETURN(run_.ball_mm, Point("table_ball_mm"));
    }
    if (instrument_->has_bar) {
      ASSIGN_OR_RETURN(run_.bar_length_mm, PositiveNumber("bar_length_mm"));
    }
    if (run_.kind == Kind::kLength) {
      RETURN_IF_ERROR(BindLength());
      if (session::FindHeader(session_, "scale_sigma_um"))
        run_.scale_of = session::FindHeader(session_, "serial").value_or("");
    }
    if (run_.kind == Kind::kDirection) RETURN_IF_ERROR(BindDirection());
    if (run_.kind == Kind::kTracker) {
      const absl::Status targets = tracker::BindTargets(session_, for_fit && run_.readings_before == 0, &run_);
      if (!targets.ok()) return Refuse(std::string(targets.message()));
    }
    if (session::FindHeader(session_, "payload_kg")) {
      ASSIGN_OR_RETURN(const std::vector<double> payload, Numbers("payload_kg", 1));
      run_.payload_kg = payload[0];
    }
    if (session::FindHeader(session_, "gravity")) {
      ASSIGN_OR_RETURN(const Eigen::Vector3d down, Point("gravity"));
      run_.gravity_direction = down.normalized();
    }
    RETURN_IF_ERROR(BindDatum());
    return ReadPriors();
  }

  absl::StatusOr<const session::Column*> ColumnOf(const std::string& name) const {
    const session::Column* column = session::FindColumn(session_, name);
    if (column == nullptr) return Refuse(absl::StrCat("column '", name, "' is missing"));
    if (column->values.size() != session_.reading_count()) {
      return Refuse(absl::StrCat("column '", name, "' has ", column->values.size(), " numbers, expected ",
                                 session_.reading_count()));
    }
    bool all_finite = true;
    for (const double number : column->values) all_finite &= std::isfinite(number);
    for (size_t k = 0; !all_finite && k < column->values.size(); ++k) {
      if (!std::isfinite(column->values[k])) {
        return Refuse(absl::StrCat("reading ", run_.readings_before + k + 1, ": ", name, " = ", column->values[k],
                                   ", expected a number"));
      }
    }
    return column;
  }

  absl::Status BindReadings() {
    const size_t readings = session_.reading_count();
    if (readings == 0) return Refuse("has no readings");
    const size_t columns = instrument_->reading_columns.size();
    run_.row_count = columns == 0 ? 1 : static_cast<int>(columns);
    run_.measured_mm = Eigen::MatrixXd::Zero(run_.row_count, readings);
    for (size_t row = 0; row < columns; ++row) {
      ASSIGN_OR_RETURN(const session::Column* column, ColumnOf(instrument_->reading_columns[row]));
      for (size_t k = 0; k < readings; ++k) run_.measured_mm(row, k) = column->values[k];
    }
    return absl::OkStatus();
  }

  absl::Status BindPositions() {
    run_.axis_count = machine_.axis_count();
    const size_t readings = session_.reading_count();
    run_.positions.assign(run_.axis_count * readings, 0.0);
    for (int axis = 0; axis < run_.axis_count; ++axis) {
      const bool is_rotary = machine_.axes[axis].kind == machine::AxisKind::kRotary;
      if (!is_rotary && !instrument_->has_linear_columns) continue;
      ASSIGN_OR_RETURN(const session::Column* column,
                       ColumnOf(machine_.axes[axis].name + (is_rotary ? "_deg" : "_mm")));
      const double unit = is_rotary ? kRadPerDeg : 1.0;
      for (size_t k = 0; k < readings; ++k) run_.positions[k * run_.axis_count + axis] = column->values[k] * unit;
    }
    if (instrument_->has_linear_columns) return absl::OkStatus();
    for (size_t k = 0; k < readings; ++k) {
      RETURN_IF_ERROR(
          centres::SolveNominalCommands(machine_, run_.tip_mm, run_.ball_mm, &run_.positions[k * run_.axis_count]));
    }
    return absl::OkStatus();
  }

  absl::StatusOr<MeasuringRun> BindPaths() {
    run_.axis_count = machine_.axis_count();
    RETURN_IF_ERROR(eccentricity::BindEccentricities(machine_, session_, log_lines_, &run_));
    BindCertificates(session_, &run_);
    DeriveMotion(&run_);
    return std::move(run_);
  }

  absl::Status BindTimes() {
    const size_t readings = session_.reading_count();
    run_.time_s.assign(readings, 0.0);
    run_.temperature_celsius.assign(readings, shapes::kReferenceTemperatureCelsius);
    run_.has_time = session::FindColumn(session_, "t_s") != nullptr;
    run_.has_temperature = session::FindColumn(session_, "temp_C") != nullptr;
    if (run_.has_time) {
      ASSIGN_OR_RETURN(const session::Column* column, ColumnOf("t_s"));
      run_.time_s = column->values;
    }
    if (run_.has_temperature) {
      ASSIGN_OR_RETURN(const session::Column* column, ColumnOf("temp_C"));
      run_.temperature_celsius = column->values;
    }
    return BindFurtherStates();
  }

  // What is recorded beside commands, time and temperature.
  absl::Status BindFurtherStates() {
    for (const session::Column& named : session_.columns) {
      const std::optional<session::ColumnRule> rule = session::StateColumnRule(named.name);
      if (!rule || named.name == "temp_C") continue;
      if (rule->kind == session::ColumnKind::kTemperature) {
        ASSIGN_OR_RETURN(const session::Column* column, ColumnOf(named.name));
        run_.temperatures.push_back({named.name.substr(2, named.name.size() - 4), column->values});
      }
      if (rule->IsEncoder()) RETURN_IF_ERROR(BindEncoder(*rule));
      if (rule->IsSense()) RETURN_IF_ERROR(BindSense(*rule));
    }
    return absl::OkStatus();
  }

  absl::Status BindEncoder(const session::ColumnRule& rule) {
    const int axis = machine::FindAxis(machine_, rule.axis);
    if (axis < 0 || (machine_.axes[axis].kind == machine::AxisKind::kLinear) != rule.IsLinear())
      return Refuse(absl::StrCat("column '", rule.name, "': no such axis of machine ", machine_.id));
    ASSIGN_OR_RETURN(const session::Column* column, ColumnOf(rule.name));
    if (run_.encoder_positions.empty())
      run_.encoder_positions.assign(run_.positions.size(), std::numeric_limits<double>::quiet_NaN());
    const double unit = rule.IsLinear() ? 1.0 : kRadPerDeg;
    for (size_t k = 0; k < column->values.size(); ++k)
      run_.encoder_positions[k * run_.axis_count + axis] = column->values[k] * unit;
    return absl::OkStatus();
  }

  absl::Status BindSense(const session::ColumnRule& rule) {
    const int axis = machine::FindAxis(machine_, rule.axis);
    if (axis < 0) return Refuse(absl::StrCat("column '", rule.name, "': no such axis of machine ", machine_.id));
    ASSIGN_OR_RETURN(const session::Column* column, ColumnOf(rule.name));
    if (run_.stated_senses.empty()) run_.stated_senses.assign(run_.positions.size(), 0.0);
    for (size_t k = 0; k < column->values.size(); ++k)
      run_.stated_senses[k * run_.axis_count + axis] = column->values[k];
    return absl::OkStatus();
  }

  const Session& session_;
  const machine::Machine& machine_;
  const std::vector<size_t>* const log_lines_;
  const Instrument* instrument_ = nullptr;
  MeasuringRun run_;
};

}  // namespace

absl::StatusOr<MeasuringRun> BindSession(const Session& session, const machine::Machine& machine,
                                         size_t readings_before) {
  return Binder(session, machine, readings_before).Bind(/*for_fit=*/true);
}

absl::StatusOr<MeasuringRun> BindReadings(const Session& session, const machine::Machine& machine,
                                          size_t readings_before, const std::vector<size_t>* log_lines) {
  return Binder(session, machine, readings_before, log_lines).Bind(/*for_fit=*/false);
}

}  // namespace axiscal::instruments
