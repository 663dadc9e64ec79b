// Words of the tool's direction under tool centre point control: I, J and K of G43.5, A3=, B3= and C3= of TRAORI, TX,
// TY and TZ of LN. The rotary axes go where the nominal chain gives that direction; docs/nc.md, "Tool vectors".
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "core/base/units.h"
#include "core/nc/request.h"
#include "core/nc/tilted_axes.h"

namespace axiscal::nc {
namespace {

// rad; a tool that stands so near to the direction stays.
constexpr double kStandsRad = 1e-9;
// Sine of the angle between the tool and the axis that turns it about itself: nearer, 0.1 deg, a last decimal of the
// vector turns that axis by degrees, and controls have rules of their own.
constexpr double kLeastLever = 2e-3;
constexpr double kLeastVector = 1e-3;          // of a vector
constexpr double kUnitVectorTolerance = 1e-3;  // of Klartext, whose vectors have the length 1
constexpr double kAtLimitRad = 1e-9;           // rad, at a travel limit
// rad; ways of turning that are no farther apart are one: a correction of 0.5 mm per rad differs by 0.025 um, and words
// between pieces of a split move turn the tool by no more. Of a rotary axis, which turns the correction with it:
constexpr double kAlikeRad = 5e-5;
constexpr double kAlikeAxisRad = 2e-4;

}  // namespace

std::string Interpreter::WhyNoVector(const Request& request, const Step& step) const {
  const bool has_normals = request.motion != nullptr && request.motion->meaning == Meaning::kLinear &&
                           request.motion->detail == kWithNormals;
  const bool is_control = (modal_.tool_point & ~kPlacedFrames) != 0;
  const std::string names = absl::StrCat(dialect_->vector_addresses[0], ", ", dialect_->vector_addresses[1], " and ",
                                         dialect_->vector_addresses[2]);
  std::string turned;  // a rotary axis that the block names
  for (int i = 0; i < axis_count_; ++i) {
    if (!is_linear_[i] && step.word_of_axis[i] >= 0) turned = machine_->axes[i].name;
  }
  if (has_normals && !is_control)
    return "LN (linear move with surface normals): no tool centre point control is in force";
  if (!request.HasVector()) {
    if (has_normals)
      return absl::StrCat("LN (linear move with surface normals) without ", names,
                          ": the control holds the tool upright to the surface, which is not followed");
    if (StatesVectors() && !turned.empty())
      return absl::StrCat("word ", turned, " under G43.5, where ", names, " say how the tool stands");
    return !has_normals && request.has_normal ? "NX, NY and NZ without LN" : "";
  }
  if (!is_control)
    return absl::StrCat(names, " state the tool's direction, and no tool centre point control is in force");
  if (dialect_->has_poles && !has_normals) return absl::StrCat(names, " without LN");
  if (options_->orientation)
    return absl::StrCat("with --orientation ", names,
                        " are not followed: a correction of the tool's direction would "
                        "change them");
  if (!turned.empty()) return absl::StrCat("word ", turned, " and ", names, " in one block");
  if (std::any_of(request.vector.begin(), request.vector.end(), [](const Word* word) { return word == nullptr; }))
    return absl::StrCat("not all of ", names, ": what the control takes for the others is not known");
  if (modal_.is_incremental) return absl::StrCat(names, " in G91");
  if (has_normals && radius_difference_ != Ticks{0})
    return "LN with a difference of the tool's radius (DR): the control moves the path along the normals";
  return "";
}

bool Interpreter::TurnsAlike(Step* step) {
  constexpr int kLooks = 8;
  uint16_t turning = 0;
  for (int i = 0; i < axis_count_; ++i) {
    if (is_linear_[i]) continue;
    if (!step->start.is_known(i) || !step->end.is_known(i)) return false;
    if (step->start.ticks[i] != step->end.ticks[i]) turning |= static_cast<uint16_t>(1u << i);
  }
  if (turning == 0) return true;
  const Eigen::Vector3d from = frame_of_words_.Up(step->start.ticks), to = frame_of_words_.Up(step->end.ticks);
  const double angle = std::atan2(from.cross(to).norm(), from.dot(to));
  if (!(angle > kStandsRad) || angle > 0.5 * std::numbers::pi) return false;
  for (int k = 1; k < kLooks; ++k) {
    AxisTicks at = step->start.ticks;
    for (int i = 0; i < axis_count_; ++i) {
      if (turning >> i & 1) at[i] += (step->end.ticks[i] - step->start.ticks[i]) * k / kLooks;
    }
    const double share = static_cast<double>(k) / kLooks;
    const Eigen::Vector3d shortest =
        (std::sin((1.0 - share) * angle) * from + std::sin(share * angle) * to) / std::sin(angle);
    const Eigen::Vector3d up = frame_of_words_.Up(at);
    const double apart_rad = std::atan2(up.cross(shortest).norm(), up.dot(shortest));
    if (apart_rad > kAlikeRad) return false;
    // Where the tool stands nearly along an axis, a little of its direction is much of that axis.
    for (int i = 0; i < axis_count_; ++i) {
      if ((turning >> i & 1) == 0) continue;
      AxisTicks turned = at;
      turned[i] += kTicksPerMm / 100;
      const double lever = (frame_of_words_.Up(turned) - up).norm() / (0.01 * base::kRadPerDeg);
      if (apart_rad > kStandsRad && apart_rad > kAlikeAxisRad * lever) return false;
    }
  }
  if (!has_noted_turning_ && step->note.text.empty()) {
    has_noted_turning_ = true;
    step->note = RemarkAt(line_, "turning-alike",
                          "whether the tool turns by a vector (ORIVECT) or axis by axis (ORIAXES) makes less than "
                          "50 urad here, and is not asked");
  }
  return true;
}

std::string Interpreter::TurnToVector(const Block& block, const Request& request, Step* step) {
  Eigen::Vector3d up;
  bool has_point = false, lacks_point = false;
  for (size_t k = 0; k < 3; ++k) {
    const Word& word = *request.vector[k];
    if (const std::string problem = WordProblem(word); !problem.empty()) return problem;
    if (word.distance != Distance::kModal) return "a component of the tool's direction that states its distance";
    up[static_cast<Eigen::Index>(k)] = ValueOf(Meant(word.number, kTicksPerMm));
    has_point |= word.number.has_point;
    lacks_point |= !word.number.has_point && word.number.mantissa != 0;
    step->word_of_vector[k] = static_cast<int8_t>(&word - block.words.data());
  }
  const auto is_centre = [this](const Word& word) { return RoleOf(word.letter) == Role::kCentre; };
  if (StatesVectors() && std::count_if(block.begin(), block.end(), is_centre) != 3)
    return "two words of one component of the tool's direction";
  if (options_->integer_words == IntegerWords::kLeastIncrement && has_point && lacks_point)
    return "components of the tool's direction with a point and without one: what these count is not known";
  const double length = up.norm();
  if (!(length > kLeastVector)) return "the vector of the tool's direction is zero";
  if (dialect_->has_poles && std::abs(length - 1.0) > kUnitVectorTolerance)
    return "the vector of the tool's direction has not the length 1";
  up /= length;
  int rotary_count = 0;
  bool is_known = true;
  for (int i = 0; i < axis_count_; ++i) {
    if (is_linear_[i]) continue;
    ++rotary_count;
    is_known &= step->start.is_known(i);
  }
  if (rotary_count != 2)
    return absl::StrCat("machine '", machine_->id,
                        "' has not two rotary axes: where they go for a vector is not known");
  step->has_vector = step->takes_no_rotary_words = true;
  if (!has_noted_vector_ && step->note.text.empty()) {
    has_noted_vector_ = true;
    step->note = RemarkAt(
        line_, "tool-vectors",
        absl::StrCat(
            "tool vectors: each rotary axis is taken to go to the nearer of the places that give the "
            "direction, in proportion to the move",
            dialect_->has_poles ? ", and the tool to have no differences (DL, DR, DR2) in the tool table" : ""));
  }
  if (is_known) {
    const Eigen::Vector3d now = frame_of_words_.Up(step->start.ticks);
    if (std::atan2(now.cross(up).norm(), now.dot(up)) <= kStandsRad) return "";
  }
  constexpr double kTurnRad = 2.0 * std::numbers::pi;
  std::vector<AxisTicks> found;
  for (const AxisAngles& way : ToolAlong(*machine_, frame_of_words_.InTable(Eigen::Vector3d(-up)))) {
    if (way.lever < kLeastLever)
      return absl::StrCat("the tool stands along the axis ", machine_->axes[way.outer_axis].name,
                          " (within 0.1 deg), and where the control turns that axis is not known: state rotary words "
                          "for this move");
    std::vector<AxisTicks> places = {step->end.ticks};
    for (int i = 0; i < axis_count_; ++i) {
      if (is_linear_[i]) continue;
      const machine::Axis& axis = machine_->axes[i];
      const double rad = way.position_rad[static_cast<size_t>(i)];
      const double least = axis.min_position ? *axis.min_position : -std::numeric_limits<double>::infinity();
      const double most = axis.max_position ? *axis.max_position : std::numeric_limits<double>::infinity();
      std::vector<double> turned;
      if (axis.min_position && axis.max_position) {
        for (double k = std::ceil((least - rad - kAtLimitRad) / kTurnRad); rad + k * kTurnRad <= most + kAtLimitRad;
             k += 1)
          turned.push_back(rad + k * kTurnRad);
      } else {
        // The nearest turn, and those beside it of an axis that counts on; where nobody knows where it stands, any.
        const double here = step->start.is_known(i)
                                ? static_cast<double>(step->start.ticks[i]) / kTicksPerUnit * base::kRadPerDeg
                                : 0.0;
        const double nearest = rad + kTurnRad * std::round((here - rad) / kTurnRad);
        for (const double value : {nearest, nearest - kTurnRad, nearest + kTurnRad}) {
          if (value < least - kAtLimitRad || value > most + kAtLimitRad) continue;
          const bool is_same_place = axis.roll_over != machine::RollOver::kNone && !turned.empty();
          if (!is_same_place) turned.push_back(value);
        }
      }
      const std::vector<AxisTicks> before = std::move(places);
      places.clear();
      for (const AxisTicks& place : before) {
        for (const double value : turned) {
          places.push_back(place);
          places.back()[i] = std::llround(value * base::kDegPerRad * kTicksPerUnit);
        }
      }
    }
    found.insert(found.end(), places.begin(), places.end());
  }
  if (found.size() > 1 && !is_known)
    return "where the rotary axes stand is not known, and several positions of them give the vector: program them in "
           "front of it, or state --start";
  AxisTicks at{};
  if (std::string problem = ChoosePlace(found, true, &at); !problem.empty()) return problem;
  for (int i = 0; i < axis_count_; ++i) {
    if (is_linear_[i]) continue;
    const Ticks travel = at[i] - step->start.ticks[i];
    const bool was_known = step->start.is_known(i);
    if (was_known && std::abs(2 * std::abs(travel) - kTurn) <= kTicksPerMm / 1000)
      return absl::StrCat("the vector turns ", machine_->axes[i].name, " by half a turn: which way is not known");
    step->end.ticks[i] = at[i];
    step->end.sense[i] = !was_known ? 0 : travel > 0 ? 1 : travel < 0 ? -1 : step->start.sense[i];
    step->end.known |= static_cast<uint16_t>(1u << i);
  }
  return "";
}

}  // namespace axiscal::nc
