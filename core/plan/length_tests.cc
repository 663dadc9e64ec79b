// Tests of one axis that moves alone, by lengths and directions, and of the work space by distances from anchors and by
// places in a tracker's frame.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/instruments/length/length_model.h"
#include "core/plan/overrun.h"
#include "core/plan/session_builder.h"
#include "core/plan/tests_internal.h"

namespace axiscal::plan {
namespace {

using machine::AxisKind;
using machine::Machine;

constexpr double kSecondsPerReading = 10.0;  // to the target, at rest, read
constexpr int kTargets = 11, kCycles = 5;    // there and back: what positioning tests usually ask for

bool IsOnTable(const Machine& machine, int axis) {
  return std::find(machine.work_branch.begin(), machine.work_branch.end(), axis) != machine.work_branch.end();
}

// Where a test goes: nine tenths of the stated travel, less where the overrun at the ends needs more room; what was
// measured so far; or 100 mm to either side of home. Nothing where a travel is too short for any of it.
Range WayOf(const Situation& situation, int axis) {
  const machine::Axis& a = situation.machine->axes[axis];
  constexpr double kEnds = 0.05, kAroundHomeMm = 100.0;
  if (a.min_position && a.max_position) {
    constexpr double kRoom = 1.1;  // beside the overrun
    const double travel = *a.max_position - *a.min_position;
    const double end = std::max(kEnds * travel, kRoom * OverrunOf(a));
    return 2.0 * end < travel ? Range{*a.min_position + end, *a.max_position - end} : Range{};
  }
  if (situation.Turns(axis)) return situation.ranges[axis];
  return a.kind == AxisKind::kLinear ? Range{-kAroundHomeMm, kAroundHomeMm} : Range{};
}

// Home, or the middle of the travel of an axis that does not reach it.
std::vector<double> RestOf(const Situation& situation) {
  std::vector<double> rest;
  for (const machine::Axis& axis : situation.machine->axes) {
    const bool is_beyond =
        (axis.min_position && *axis.min_position > 0.0) || (axis.max_position && *axis.max_position < 0.0);
    rest.push_back(is_beyond && axis.min_position && axis.max_position ? 0.5 * (*axis.min_position + *axis.max_position)
                                                                       : 0.0);
  }
  return rest;
}

std::string UnitText(const Eigen::Vector3d& direction) {
  return absl::StrFormat("%.10g %.10g %.10g", direction.x() + 0.0, direction.y() + 0.0, direction.z() + 0.0);
}

// A session of length or direction without rows.
session::Session SessionOf(const Situation& situation, const std::string& name, const std::string& instrument,
                           double sigma_um, const std::vector<session::HeaderEntry>& keys) {
  session::Session session;
  const Eigen::Vector3d& tip_mm = situation.tips_mm.front();
  session.header = HeaderOf(*situation.machine, name, tip_mm, tip_mm, 0.0, sigma_um * base::kMmPerUm);
  session.header[2].value = instrument;
  session.header.pop_back();  // no table ball
  session.header.insert(session.header.end(), keys.begin(), keys.end());
  session.columns = ColumnsOf(situation);
  return session;
}

void AddRow(const Situation& situation, const std::vector<double>& positions, session::Session* session) {
  const Machine& machine = *situation.machine;
  const double count = static_cast<double>(session->columns[0].values.size());
  session->columns[0].values.push_back(Rounded(situation.start_s + count * kSecondsPerReading));
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const double unit = machine.axes[axis].kind == AxisKind::kRotary ? base::kDegPerRad : 1.0;
    session->columns[1 + axis].values.push_back(Rounded(positions[axis] * unit));
  }
  if (situation.has_temperature) session->columns.back().values.push_back(Rounded(situation.temperature_celsius));
}

// All targets of an axis there and back, as often as positioning tests ask for; the axis goes on beyond the last target
// and comes back, which no row shows and the column of its sense says.
session::Session ThereAndBack(const Situation& situation, int axis, session::Session session) {
  const Range way = WayOf(situation, axis);
  session::Column senses = {situation.machine->axes[axis].name + "_sense", {}, {}};
  std::vector<double> positions = RestOf(situation);
  for (int pass = 0; pass < 2 * kCycles; ++pass) {
    for (int i = 0; i < kTargets; ++i) {
      const int at = pass % 2 == 0 ? i : kTargets - 1 - i;
      positions[axis] = way.lowest + (way.highest - way.lowest) * at / (kTargets - 1);
      AddRow(situation, positions, &session);
      senses.values.push_back(pass % 2 == 0 ? 1.0 : -1.0);
    }
  }
  session.columns.push_back(std::move(senses));
  return session;
}

std::string WayText(const Situation& situation, int axis) {
  const Range way = WayOf(situation, axis);
  const machine::Axis& a = situation.machine->axes[axis];
  const bool is_rotary = a.kind == AxisKind::kRotary;
  const double unit = is_rotary ? base::kDegPerRad : 1.0;
  return absl::StrFormat("%s from %g to %g %s, %d targets, %d times there and back, %g %s beyond at the ends", a.name,
                         Rounded(unit * way.lowest), Rounded(unit * way.highest), is_rotary ? "deg" : "mm", kTargets,
                         kCycles, is_rotary ? kOverrunDeg : kOverrunMm, is_rotary ? "deg" : "mm");
}

// Along the way that the tool takes against the table when the axis rises, table frame at home.
Eigen::Vector3d AlongOf(const Machine& machine, int axis) {
  return (IsOnTable(machine, axis) ? -1.0 : 1.0) * machine.axes[axis].direction;
}

// Of linear axes that have room to move.
template <typename Add>
void ForLinear(const Situation& situation, const Add& add) {
  for (int axis = 0; axis < situation.machine->axis_count(); ++axis) {
    if (situation.machine->axes[axis].kind != AxisKind::kLinear) continue;
    const Range way = WayOf(situation, axis);
    if (way.lowest < way.highest) add(axis, situation.machine->axes[axis].name);
  }
}

// Lowest, middle and highest of every linear axis; none where the machine has fewer than three.
std::vector<std::vector<double>> LinearGrid(const Situation& situation) {
  std::vector<int> linear;
  ForLinear(situation, [&](int axis, const std::string&) { linear.push_back(axis); });
  if (linear.size() < 3) return {};
  std::vector<std::vector<double>> poses = {RestOf(situation)};
  for (const int axis : linear) {
    const Range way = WayOf(situation, axis);
    constexpr int kSteps = 3;
    std::vector<std::vector<double>> finer;
    for (const std::vector<double>& pose : poses) {
      for (int k = 0; k < kSteps; ++k) {
        finer.push_back(pose);
        finer.back()[axis] = way.lowest + (way.highest - way.lowest) * k / (kSteps - 1);
      }
    }
    poses = std::move(finer);
  }
  return poses;
}

}  // namespace

std::vector<PlannedSession> LengthLines(const Situation& situation) {
  std::vector<PlannedSession> planned;
  ForLinear(situation, [&](int axis, const std::string& name) {
    const std::vector<session::HeaderEntry> keys = {{"beam", UnitText(AlongOf(*situation.machine, axis))}};
    planned.push_back(
        {ThereAndBack(situation, axis, SessionOf(situation, "line-" + name, "length", 0.3, keys)),
         absl::StrCat("interferometer along ", WayText(situation, axis), "; optics between table and tool")});
  });
  return planned;
}

std::vector<PlannedSession> StraightnessLines(const Situation& situation) {
  std::vector<PlannedSession> planned;
  ForLinear(situation, [&](int axis, const std::string& name) {
    const Eigen::Matrix<double, 3, 2> across = length::AcrossOf(AlongOf(*situation.machine, axis));
    for (int side = 0; side < 2; ++side) {
      const std::string session = absl::StrFormat("straight-%s-%d", name, side + 1);
      planned.push_back(
          {ThereAndBack(situation, axis,
                        SessionOf(situation, session, "length", 0.5, {{"beam", UnitText(across.col(side))}})),
           absl::StrCat("straightness optics or a straight edge across, ", WayText(situation, axis))});
    }
  });
  return planned;
}

std::vector<PlannedSession> DirectionLines(const Situation& situation) {
  std::vector<PlannedSession> planned;
  ForLinear(situation, [&](int axis, const std::string& name) {
    for (int about = 0; about < 3; ++about) {
      const std::string session = absl::StrFormat("turn-%c-%s", "ABC"[about], name);
      planned.push_back(
          {ThereAndBack(
               situation, axis,
               SessionOf(situation, session, "direction", 1.0, {{"about", UnitText(Eigen::Vector3d::Unit(about))}})),
           absl::StrFormat("autocollimator or level, turns about %c, %s", "XYZ"[about], WayText(situation, axis))});
    }
  });
  return planned;
}

std::vector<PlannedSession> DirectionTurns(const Situation& situation) {
  std::vector<PlannedSession> planned;
  const Machine& machine = *situation.machine;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    if (machine.axes[axis].kind != AxisKind::kRotary) continue;
    const Range way = WayOf(situation, axis);
    if (!(way.highest - way.lowest > 1e-3)) continue;
    const std::string& name = machine.axes[axis].name;
    planned.push_back({ThereAndBack(situation, axis,
                                    SessionOf(situation, "indexing-" + name, "direction", 1.0,
                                              {{"about", UnitText(machine.axes[axis].direction)}})),
                       absl::StrCat("indexing table or polygon with autocollimator on ", WayText(situation, axis))});
  }
  return planned;
}

namespace {

// An arm moves its tool by rotary axes alone.
bool IsArm(const Machine& machine) {
  constexpr size_t kFewestJoints = 3;
  const auto is_rotary = [&](const machine::Axis& axis) { return axis.kind == AxisKind::kRotary; };
  return machine.work_branch.empty() && machine.tool_branch.size() >= kFewestJoints &&
         std::all_of(machine.axes.begin(), machine.axes.end(), is_rotary);
}

struct Segment {
  Eigen::Vector3d from_mm, to_mm;
};

// The least distance between two segments (Ericson, Real-Time Collision Detection, 5.1.9).
double DistanceOf(const Segment& a, const Segment& b) {
  constexpr double kPointMm2 = 1e-12;
  const Eigen::Vector3d along_a = a.to_mm - a.from_mm, along_b = b.to_mm - b.from_mm, between = a.from_mm - b.from_mm;
  const double aa = along_a.squaredNorm(), bb = along_b.squaredNorm(), ab = along_a.dot(along_b);
  const double ca = along_a.dot(between), cb = along_b.dot(between);
  const double determinant = aa * bb - ab * ab;
  double s = determinant > kPointMm2 * aa * bb ? std::clamp((ab * cb - ca * bb) / determinant, 0.0, 1.0) : 0.0;
  const double t = bb > kPointMm2 ? std::clamp((ab * s + cb) / bb, 0.0, 1.0) : 0.0;
  s = aa > kPointMm2 ? std::clamp((ab * t - ca) / aa, 0.0, 1.0) : 0.0;
  return (between + s * along_a - t * along_b).norm();
}

// What the nominal chain tells of an arm's body, its axes at home: from each axis to the next by the shortest way
// between the two, and along each axis from where one way ends to where the next begins.
class Skeleton {
 public:
  Skeleton(const Machine& machine, const Eigen::Vector3d& tip_mm) : machine_(machine) {
    const std::vector<int>& joints = machine.tool_branch;
    AddVertex(0, machine.axes[joints[0]].point_mm);
    for (size_t k = 0; k + 1 < joints.size(); ++k) {
      const machine::Axis &one = machine.axes[joints[k]], &next = machine.axes[joints[k + 1]];
      const Eigen::Vector3d between = next.point_mm - one.point_mm;
      const double cosine = one.direction.dot(next.direction), sine2 = 1.0 - cosine * cosine;
      constexpr double kParallel = 1e-9;
      const double along_one = one.direction.dot(between), along_next = next.direction.dot(between);
      // Axes side by side: from where the arm got to on this one.
      const Eigen::Vector3d foot_mm = sine2 < kParallel
                                          ? vertices_.back().home_mm
                                          : one.point_mm + (along_one - cosine * along_next) / sine2 * one.direction;
      AddVertex(k, foot_mm);
      AddVertex(k + 1, next.point_mm + next.direction.dot(foot_mm - next.point_mm) * next.direction);
    }
    AddVertex(joints.size(), tip_mm);
  }

  // At a pose, from the base to the tool point.
  std::vector<Segment> At(const std::vector<double>& pose) const {
    std::vector<Segment> segments;
    Eigen::Vector3d last_mm = Place(vertices_[0], pose);
    for (size_t k = 1; k < vertices_.size(); ++k) {
      const Eigen::Vector3d place_mm = Place(vertices_[k], pose);
      constexpr double kNothingMm = 1e-6;
      if ((place_mm - last_mm).norm() > kNothingMm) segments.push_back({last_mm, place_mm});
      last_mm = place_mm;
    }
    return segments;
  }

 private:
  struct Vertex {
    size_t joint;  // of the tool branch: moved by the joints before it
    Eigen::Vector3d home_mm;
  };

  void AddVertex(size_t joint, const Eigen::Vector3d& home_mm) { vertices_.push_back({joint, home_mm}); }

  Eigen::Vector3d Place(const Vertex& vertex, std::vector<double> pose) const {
    for (size_t k = vertex.joint; k < machine_.tool_branch.size(); ++k) pose[machine_.tool_branch[k]] = 0.0;
    const auto chain = machine::EvaluateChain<double>(machine_, pose.data(), machine::JointErrors<double>());
    return chain.bed_from_tool * vertex.home_mm;
  }

  const Machine& machine_;
  std::vector<Vertex> vertices_;
};

// A wire from the anchor to the tool point leaves the body of the arm by a hand's breadth and the last piece of it, on
// which it is hooked, by an angle.
bool IsFree(const std::vector<Segment>& arm, const Eigen::Vector3d& anchor_mm) {
  constexpr double kFreeMm = 100.0, kShortestMm = 200.0, kSteepest = 0.7;  // cosine, 45 degrees
  const Eigen::Vector3d tip_mm = arm.back().to_mm, way_mm = anchor_mm - tip_mm;
  if (way_mm.norm() < kShortestMm) return false;
  if (way_mm.normalized().dot((arm.back().from_mm - tip_mm).normalized()) > kSteepest) return false;
  for (size_t k = 0; k + 1 < arm.size(); ++k) {
    if (DistanceOf(arm[k], {anchor_mm, tip_mm}) < kFreeMm) return false;
  }
  return true;
}

struct Box {
  Eigen::Vector3d low_mm = Eigen::Vector3d::Constant(INFINITY), high_mm = Eigen::Vector3d::Constant(-INFINITY);

  void Add(const Eigen::Vector3d& point_mm) {
    low_mm = low_mm.cwiseMin(point_mm);
    high_mm = high_mm.cwiseMax(point_mm);
  }
  Eigen::Vector3d At(const Eigen::Vector3d& corner) const {
    return 0.5 * (low_mm + high_mm) + (high_mm - low_mm).cwiseProduct(corner);
  }
};

// All joints at once, spread evenly over what each may do: multiples of the powers of the root of x^(n + 1) = x + 1,
// modulo 1 (the golden section in n dimensions).
std::vector<double> SpreadPose(const Situation& situation, int number) {
  const Machine& machine = *situation.machine;
  double root = 2.0;
  constexpr int kIterations = 30;
  for (int i = 0; i < kIterations; ++i) root = std::pow(1.0 + root, 1.0 / (machine.axis_count() + 1));
  std::vector<double> pose = RestOf(situation);
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const Range way = WayOf(situation, axis);
    const double multiple = 0.5 + (number + 1) * std::pow(root, -(axis + 1));
    pose[axis] = way.lowest + (way.highest - way.lowest) * (multiple - std::floor(multiple));
  }
  return pose;
}

// Three anchors beside the arm's work space and poses at which each sees the tool freely.
std::vector<PlannedSession> ArmDistances(const Situation& situation) {
  const Machine& machine = *situation.machine;
  constexpr int kTried = 2000;
  constexpr size_t kPoses = 60, kFewestPoses = 30;
  const Eigen::Vector3d& tip_mm = situation.tips_mm.front();
  const auto turns = [&](int axis) { return situation.Turns(axis); };
  if (std::none_of(machine.tool_branch.begin(), machine.tool_branch.end(), turns)) return {};
  const Skeleton skeleton(machine, tip_mm);
  Box box;
  std::vector<std::vector<double>> tried;
  std::vector<std::vector<Segment>> arms;
  for (int k = 0; k < kTried; ++k) {
    tried.push_back(SpreadPose(situation, k));
    arms.push_back(skeleton.At(tried.back()));
    box.Add(arms.back().back().to_mm);
  }
  // Just outside of the space: farther away all lengths change alike.
  const Eigen::Vector3d anchors_mm[] = {box.At({-0.6, -0.5, -0.4}), box.At({0.6, -0.55, -0.25}),
                                        box.At({0.1, 0.6, -0.4})};
  std::vector<std::vector<double>> poses;
  std::vector<Eigen::Vector3d> tips_mm;
  for (int k = 0; k < kTried && poses.size() < kPoses; ++k) {
    const auto is_free = [&](const Eigen::Vector3d& anchor_mm) { return IsFree(arms[k], anchor_mm); };
    if (!std::all_of(std::begin(anchors_mm), std::end(anchors_mm), is_free)) continue;
    poses.push_back(tried[k]);
    tips_mm.push_back(arms[k].back().to_mm);
  }
  if (poses.size() < kFewestPoses) return {};
  constexpr double kSigmaUm = 20.0;  // of a draw wire
  std::vector<PlannedSession> planned;
  for (const Eigen::Vector3d& anchor_mm : anchors_mm) {
    double shortest_mm = INFINITY, longest_mm = 0.0;
    for (const Eigen::Vector3d& place_mm : tips_mm) {
      shortest_mm = std::min(shortest_mm, (place_mm - anchor_mm).norm());
      longest_mm = std::max(longest_mm, (place_mm - anchor_mm).norm());
    }
    const std::string number = absl::StrCat(planned.size() + 1);
    session::Session session =
        SessionOf(situation, "wire-" + number, "length", kSigmaUm,
                  {{"anchor_mm", absl::StrFormat("%.1f %.1f %.1f", anchor_mm.x(), anchor_mm.y(), anchor_mm.z())},
                   {"anchor_on", "bed"},
                   {"scale_sigma_um", "100"}});
    for (const std::vector<double>& pose : poses) AddRow(situation, pose, &session);
    planned.push_back({std::move(session),
                       absl::StrFormat("draw wire from anchor %s to the tool at %u poses of the arm, lengths of %.0f "
                                       "to %.0f mm",
                                       number, poses.size(), shortest_mm, longest_mm)});
  }
  return planned;
}

}  // namespace

std::vector<PlannedSession> DistanceGrids(const Situation& situation) {
  const Machine& machine = *situation.machine;
  if (IsArm(machine)) return ArmDistances(situation);
  const std::vector<std::vector<double>> poses = LinearGrid(situation);
  if (poses.empty()) return {};
  Eigen::Vector3d low_mm = Eigen::Vector3d::Constant(INFINITY), high_mm = -low_mm;
  for (const std::vector<double>& pose : poses) {
    const auto chain = machine::EvaluateChain<double>(machine, pose.data(), machine::JointErrors<double>());
    const Eigen::Vector3d tip_mm = machine::TipInTable(chain, situation.tips_mm.front());
    low_mm = low_mm.cwiseMin(tip_mm);
    high_mm = high_mm.cwiseMax(tip_mm);
  }
  // On the table, beside three corners of the space, half of its size away.
  const Eigen::Vector3d middle_mm = 0.5 * (low_mm + high_mm), size_mm = high_mm - low_mm;
  const Eigen::Vector3d corners[] = {{-1, -0.8, -0.6}, {1, -0.9, -0.4}, {0.1, 1, -0.7}};
  std::vector<PlannedSession> planned;
  for (const Eigen::Vector3d& corner : corners) {
    const Eigen::Vector3d anchor_mm = middle_mm + size_mm.cwiseProduct(corner);
    const std::string number = absl::StrCat(planned.size() + 1);
    session::Session session =
        SessionOf(situation, "distances-" + number, "length", 5.0,
                  {{"anchor_mm", absl::StrFormat("%.1f %.1f %.1f", anchor_mm.x(), anchor_mm.y(), anchor_mm.z())},
                   {"scale_sigma_um", "20"}});
    for (const std::vector<double>& pose : poses) AddRow(situation, pose, &session);
    planned.push_back({std::move(session),
                       absl::StrFormat("draw wire or tracker distance from anchor %s to %u points of the work space",
                                       number, poses.size())});
  }
  return planned;
}

namespace {

// Poses of the linear axes, then those of the head's axes one after the other. What turns with the table is not seen.
std::vector<std::vector<double>> TrackerPoses(const Situation& situation) {
  const Machine& machine = *situation.machine;
  std::vector<std::vector<double>> poses = LinearGrid(situation);
  if (poses.empty()) return {};
  constexpr int kHeadSteps = 6;
  for (const int axis : machine.tool_branch) {
    if (machine.axes[axis].kind != AxisKind::kRotary || !situation.Turns(axis)) continue;
    const Range way = WayOf(situation, axis);
    for (int k = 0; k <= kHeadSteps; ++k) {
      poses.push_back(RestOf(situation));
      poses.back()[axis] = way.lowest + (way.highest - way.lowest) * k / kHeadSteps;
    }
  }
  return poses;
}

constexpr double kTrackerSigmaUm = 5.0;

}  // namespace

std::vector<PlannedSession> TrackerGrids(const Situation& situation) {
  const std::vector<std::vector<double>> poses = TrackerPoses(situation);
  if (poses.empty()) return {};
  session::Session session = SessionOf(situation, "tracker", "tracker", kTrackerSigmaUm, {});
  for (const std::vector<double>& pose : poses) AddRow(situation, pose, &session);
  return {{std::move(session), absl::StrFormat("a tracker's target on the tool at %u points of the work space and "
                                               "positions of the head",
                                               poses.size())}};
}

// A look at the reference targets before the first pose, after every few and after the last one: in between a tracker
// moves by hardly more than it is straight.
std::vector<PlannedSession> TrackerReferences(const Situation& situation) {
  const Machine& machine = *situation.machine;
  const std::vector<std::vector<double>> poses = TrackerPoses(situation);
  if (poses.empty()) return {};
  Eigen::Vector3d low_mm = Eigen::Vector3d::Constant(INFINITY), high_mm = -low_mm;
  for (const std::vector<double>& pose : poses) {
    const auto chain = machine::EvaluateChain<double>(machine, pose.data(), machine::JointErrors<double>());
    const Eigen::Vector3d tip_mm = chain.bed_from_tool * situation.tips_mm.front();
    low_mm = low_mm.cwiseMin(tip_mm);
    high_mm = high_mm.cwiseMax(tip_mm);
  }
  // On the bed, around the work space: nearer they would be in its way, farther they would show turns no better than
  // the air lets the tracker read.
  const Eigen::Vector3d middle_mm = 0.5 * (low_mm + high_mm);
  // Along an axis of the table the tool stands still to the bed, and the targets would stand under it.
  const Eigen::Vector3d moved_mm = high_mm - low_mm;
  const Eigen::Vector3d size_mm = moved_mm.cwiseMax(0.5 * moved_mm.maxCoeff());
  const Eigen::Vector3d corners[] = {{-1, -0.8, -0.6}, {1, -0.9, -0.4}, {0.1, 1, 0.7}};
  std::vector<session::HeaderEntry> keys;
  for (size_t i = 0; i < std::size(corners); ++i) {
    const Eigen::Vector3d place_mm = middle_mm + size_mm.cwiseProduct(corners[i]);
    keys.push_back({absl::StrCat("reference R", i + 1),
                    absl::StrFormat("%.0f %.0f %.0f", place_mm.x() + 0.0, place_mm.y() + 0.0, place_mm.z() + 0.0)});
  }
  session::Session session = SessionOf(situation, "tracker-references", "tracker", kTrackerSigmaUm, keys);
  session::Column target = {"target", {}, {}};
  const auto look = [&](const std::vector<double>& pose) {
    for (size_t i = 0; i < std::size(corners); ++i) {
      AddRow(situation, pose, &session);
      target.texts.push_back(absl::StrCat("R", i + 1));
    }
  };
  constexpr size_t kPosesBetween = 9;
  int looks = 0;
  for (size_t k = 0; k < poses.size(); ++k) {
    if (k % kPosesBetween == 0) {
      look(poses[k == 0 ? 0 : k - 1]);
      ++looks;
    }
    AddRow(situation, poses[k], &session);
    target.texts.push_back("tool");
  }
  look(poses.back());
  session.columns.push_back(std::move(target));
  return {{std::move(session),
           absl::StrFormat("a tracker's target on the tool at %u points of the work space and positions of the head, "
                           "and %u reference targets beside the machine before, after and in between, %d times in all",
                           poses.size(), std::size(corners), looks + 1)}};
}

}  // namespace axiscal::plan
