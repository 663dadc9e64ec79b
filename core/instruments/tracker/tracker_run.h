// What the readings of one tracker session are of: plain data of a `tracker` run (docs/formats.md, "Tracker").
#ifndef AXISCAL_CORE_INSTRUMENTS_TRACKER_TRACKER_RUN_H_
#define AXISCAL_CORE_INSTRUMENTS_TRACKER_TRACKER_RUN_H_

#include <Eigen/Core>
#include <string>
#include <vector>

namespace axiscal::tracker {

inline constexpr int kMostTargets = 4;     // on the tool
inline constexpr int kMostReferences = 6;  // beside the machine; three that are on no line show every motion
inline constexpr int kMostPoses = 12;      // of the tracker, in one session
// Setup offsets: the frame's pose, three for each target and reference, the pose at each look beside the first one's.
inline constexpr int kMostOffsets = 6 + 3 * kMostTargets + 3 * kMostReferences + 6 * (kMostPoses - 1);

// A place and what the session calls it.
struct Target {
  std::string name;
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  // nominal, machine frame at home
};

// A look is a series of readings of reference targets without one of the tool in between. Between two looks the tracker
// moves steadily, or all at once where the session states when it was knocked; before the first and after the last look
// it stands.
struct Targets {
  std::vector<Target> on_tool;     // empty: one, at the run's tip_mm
  std::vector<Target> references;  // they stand beside the machine and do not move
  // By reading: its place in `on_tool`, or in `references` counted from -1 downwards. Empty: all are of the tool.
  std::vector<int> of_reading;
  std::vector<double> looks_s;    // ascending: the mean time of each look, or of as many as there are poses for
  std::vector<double> knocked_s;  // ascending

  bool IsReference(int reading) const { return !of_reading.empty() && of_reading[static_cast<size_t>(reading)] < 0; }
  const Target& ReferenceOf(int reading) const {
    return references[static_cast<size_t>(-1 - of_reading[static_cast<size_t>(reading)])];
  }
  // Poses beside the first look's.
  int Moves() const { return looks_s.empty() ? 0 : static_cast<int>(looks_s.size()) - 1; }
};

}  // namespace axiscal::tracker

#endif  // AXISCAL_CORE_INSTRUMENTS_TRACKER_TRACKER_RUN_H_
