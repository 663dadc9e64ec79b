// Circular moves: centres, radii, and the poles of Klartext.
#include <cmath>

#include "core/nc/request.h"

namespace axiscal::nc {
namespace {

Eigen::Vector2d InPlane(Ticks first, Ticks second) {
  return Eigen::Vector2d(static_cast<double>(first), static_cast<double>(second)) / kTicksPerUnit;
}

}  // namespace

void Interpreter::SetPole(const Block& block, const Request& request, Step* step) {
  if (request.motion != nullptr) return Unsupported("a pole and a move in one block", false, step);
  step->sets_pole = true;
  pole_ = Pole();
  if (block.problem != LexProblem::kNone || request.foreign_axis != 0 || modal_.blockers != 0) return;
  if (modal_.uncertain & kUnitGroup) return;
  Pole pole = {{}, true, true};
  for (int i = 0; i < axis_count_; ++i) {
    if (step->word_of_axis[i] >= 0 && i != PlaneAxis(0) && i != PlaneAxis(1)) return;
  }
  for (const int index : {0, 1}) {
    const int axis = PlaneAxis(index);
    if (axis < 0 || !is_linear_[axis] || (request.has_axis && step->word_of_axis[axis] < 0)) return;
    Ticks value = 0;
    bool is_incremental = true;  // CC alone: where the tool stands
    if (request.has_axis) {
      const Word& word = block.words[static_cast<size_t>(step->word_of_axis[axis])];
      if (!WordProblem(word).empty()) return;
      value = *ToTicks(Meant(word.number, ticks_per_unit(axis)), ticks_per_unit(axis));
      is_incremental = IsIncremental(word);
    }
    if (is_incremental && !positions_.is_known(axis)) return;
    pole.ticks[static_cast<size_t>(index)] = value + (is_incremental ? positions_.ticks[axis] : offset(axis));
    pole.is_absolute &= !is_incremental;
  }
  pole_ = pole;
}

absl::StatusOr<Arc> Interpreter::ArcByPole(const Request& request, const Step& step) const {
  const int first = PlaneAxis(0), second = PlaneAxis(1);
  if (request.is_rapid_block) return absl::InvalidArgumentError("a rapid one");
  for (int i = 0; i < axis_count_; ++i) {
    if (step.word_of_axis[i] >= 0 && i != first && i != second)
      return absl::InvalidArgumentError(absl::StrCat("a word of ", machine_->axes[i].name, " in it"));
  }
  const Eigen::Vector2d start_mm = InPlane(step.start.ticks[first], step.start.ticks[second]);
  const Eigen::Vector2d end_mm = InPlane(step.end.ticks[first], step.end.ticks[second]);
  if (request.motion->detail == kArcWithRadius) {
    if (request.radius == nullptr) return absl::InvalidArgumentError("it has no radius");
    const std::optional<Ticks> radius = LengthTicks(*request.radius);
    if (!radius) return absl::InvalidArgumentError(WordProblem(*request.radius));
    return ArcOfRadius(start_mm, end_mm, static_cast<double>(*radius) / kTicksPerUnit, !modal_.is_clockwise);
  }
  if (!pole_.is_known) return absl::InvalidArgumentError("its centre is not known: no CC block states it in numbers");
  return ArcAboutCentre(start_mm, end_mm, InPlane(pole_.ticks[0], pole_.ticks[1]), !modal_.is_clockwise);
}

bool Interpreter::ReadArc(const Block& block, const Request& request, Step* step) {
  const int first = PlaneAxis(0), second = PlaneAxis(1);
  const auto refuse = [&](std::string reason, bool is_consequence) {
    Unsupported("circular move: " + std::move(reason), is_consequence, step);
    return false;
  };
  if (first < 0 || second < 0 || !is_linear_[first] || !is_linear_[second])
    return refuse("the machine has no two linear axes in this plane", false);
  for (const int axis : {first, second}) {
    if (!step->start.is_known(axis)) {
      return refuse(absl::StrCat("it starts at an unknown position of ", machine_->axes[axis].name),
                    is_unknown_reported(axis));
    }
  }
  const Eigen::Vector2d start_mm = InPlane(step->start.ticks[first], step->start.ticks[second]);
  const Eigen::Vector2d end_mm = InPlane(step->end.ticks[first], step->end.ticks[second]);
  absl::StatusOr<Arc> arc = absl::InvalidArgumentError("it has no centre and no radius");
  if (dialect_->has_poles) {
    arc = ArcByPole(request, *step);
  } else if (request.radius != nullptr) {
    const std::optional<Ticks> radius = LengthTicks(*request.radius);
    if (request.has_centre) return refuse("it has a centre and a radius", false);
    if (request.radius->distance != Distance::kModal) return refuse("its radius is a position", false);
    if (!radius) return refuse(WordProblem(*request.radius), false);
    arc = ArcOfRadius(start_mm, end_mm, static_cast<double>(*radius) / kTicksPerUnit, !modal_.is_clockwise);
  } else if (request.has_centre) {
    // I belongs to X, J to Y, K to Z.
    static constexpr char kCentres[3][3] = {"JK", "KI", "IJ"};
    Eigen::Vector2d centre_mm = modal_.are_centres_absolute ? Eigen::Vector2d::Zero().eval() : start_mm;
    int found = 0;
    for (const Word& word : block) {
      if (RoleOf(word.letter) != Role::kCentre) continue;
      const char* const letters = kCentres[modal_.plane_normal];
      if (word.letter != letters[0] && word.letter != letters[1])
        return refuse(absl::StrCat("word ", std::string(1, word.letter), " is not of its plane"), false);
      const int index = word.letter == letters[0] ? 0 : 1, axis = index == 0 ? first : second;
      const std::optional<Ticks> value = LengthTicks(word);
      if (std::string problem = WordProblem(word); !problem.empty() || !value) return refuse(problem, false);
      const bool is_absolute =
          word.distance == Distance::kModal ? modal_.are_centres_absolute : word.distance == Distance::kAbsolute;
      const Eigen::Vector2d base_mm = is_absolute ? Eigen::Vector2d::Zero().eval() : start_mm;
      centre_mm[index] =
          base_mm[index] + static_cast<double>(*value + (is_absolute ? offset(axis) : 0)) / kTicksPerUnit;
      found |= found & (1 << index) ? 4 : 1 << index;
    }
    if (found > 3) return refuse("two centre words of one letter", false);
    if (modal_.are_centres_absolute && found != 3) return refuse("an absolute centre needs both words", false);
    arc = ArcAboutCentre(start_mm, end_mm, centre_mm, !modal_.is_clockwise);
  }
  if (!arc.ok()) return refuse(std::string(arc.status().message()), false);
  step->is_arc = true;
  step->arc = *arc;
  step->arc.first = first;
  step->arc.second = second;
  // The senses of motion in which the axes reach the end.
  const double end_rad = arc->start_rad + arc->sweep_rad;
  const double along[2] = {-std::sin(end_rad) * arc->sweep_rad, std::cos(end_rad) * arc->sweep_rad};
  // An axis that turns back exactly at the end reaches it moving outwards.
  const double outwards[2] = {std::cos(end_rad), std::sin(end_rad)};
  for (const int index : {0, 1}) {
    const double last = std::abs(along[index]) > 1e-9 ? along[index] : outwards[index];
    step->end.sense[index == 0 ? first : second] = last > 0 ? 1 : -1;
  }
  return true;
}

}  // namespace axiscal::nc
