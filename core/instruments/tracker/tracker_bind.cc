#include "core/instruments/tracker/tracker_bind.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "core/instruments/tracker/tracker_model.h"
#include "core/session/header_rules.h"
#include "core/session/text.h"

namespace axiscal::tracker {
namespace {

using session::Session;

constexpr char kTarget[] = "target ", kReference[] = "reference ";

absl::Status ParsePlaces(const Session& session, const std::string& prefix, int most, std::vector<Target>* places) {
  for (const session::HeaderEntry& entry : session.header) {
    if (!entry.key.starts_with(prefix)) continue;
    std::vector<double> numbers;
    if (!session::ParseNumbers(entry.value, &numbers) || numbers.size() != 3)
      return absl::InvalidArgumentError(absl::StrCat("header '", entry.key, ": ", entry.value,
                                                     "', expected its place x y z in mm, machine axes at home"));
    if (static_cast<int>(places->size()) == most)
      return absl::InvalidArgumentError(
          absl::StrCat("header '", entry.key, "', expected at most ", most, " lines '", prefix, "NAME'"));
    places->push_back({entry.key.substr(prefix.size()), {numbers[0], numbers[1], numbers[2]}});
  }
  return absl::OkStatus();
}

int IndexOf(const std::vector<Target>& places, const std::string& name) {
  const auto it = std::find_if(places.begin(), places.end(), [&](const Target& one) { return one.name == name; });
  return it == places.end() ? -1 : static_cast<int>(it - places.begin());
}

// Evenly some of the looks, the first and the last among them, where there are more than poses.
std::vector<double> Thinned(const std::vector<double>& looks_s) {
  if (looks_s.size() <= kMostPoses) return looks_s;
  std::vector<double> some;
  for (size_t k = 0; k < kMostPoses; ++k) some.push_back(looks_s[k * (looks_s.size() - 1) / (kMostPoses - 1)]);
  return some;
}

std::vector<double> LooksOf(const Targets& targets, const std::vector<double>& times_s) {
  std::vector<double> looks_s;
  int count = 0;  // readings of the last look
  for (size_t k = 0; k < times_s.size(); ++k) {
    if (!targets.IsReference(static_cast<int>(k))) continue;
    if (k == 0 || !targets.IsReference(static_cast<int>(k) - 1)) {
      looks_s.push_back(0.0);
      count = 0;
    }
    ++count;
    looks_s.back() += (times_s[k] - looks_s.back()) / count;
  }
  return Thinned(looks_s);
}

absl::Status CheckAllSeen(const Targets& targets) {
  const auto is_seen = [&](int of) {
    return std::find(targets.of_reading.begin(), targets.of_reading.end(), of) != targets.of_reading.end();
  };
  for (size_t i = 0; i < targets.references.size(); ++i) {
    if (!is_seen(-1 - static_cast<int>(i)))
      return absl::InvalidArgumentError(
          absl::StrCat("header 'reference ", targets.references[i].name, "' is of a target that no reading is of"));
  }
  for (size_t i = 0; i < targets.on_tool.size(); ++i) {
    if (!is_seen(static_cast<int>(i)))
      return absl::InvalidArgumentError(
          absl::StrCat("header 'target ", targets.on_tool[i].name, "' is of a target that no reading is of"));
  }
  if (!is_seen(0))
    return absl::InvalidArgumentError("all readings are of reference targets, expected some of the tool");
  return absl::OkStatus();
}

}  // namespace

absl::Status BindTargets(const Session& session, bool is_whole, instruments::MeasuringRun* run) {
  Targets targets;
  RETURN_IF_ERROR(ParsePlaces(session, kTarget, kMostTargets, &targets.on_tool));
  RETURN_IF_ERROR(ParsePlaces(session, kReference, kMostReferences, &targets.references));
  const session::Column* const names = session::FindColumn(session, "target");
  if (names == nullptr) {
    if (targets.on_tool.empty() && targets.references.empty()) return absl::OkStatus();
    return absl::InvalidArgumentError(
        "headers 'target NAME' and 'reference NAME' need the column target, which says "
        "of which of them each reading is");
  }
  constexpr size_t kMostNamed = kMostTargets + kMostReferences;  // no error is longer, whatever the column holds
  std::vector<std::string> unstated;                             // names that no header has, the first of them
  for (const std::string& name : names->texts) {
    const int reference = IndexOf(targets.references, name), on_tool = IndexOf(targets.on_tool, name);
    if (reference >= 0 && on_tool >= 0)
      return absl::InvalidArgumentError(
          absl::StrCat("target '", name, "' stands in '# target' and '# reference', expected one of them"));
    if (reference < 0 && on_tool < 0 && unstated.size() < kMostNamed &&
        std::find(unstated.begin(), unstated.end(), name) == unstated.end())
      unstated.push_back(name);
    targets.of_reading.push_back(reference >= 0 ? -1 - reference : std::max(on_tool, 0));
  }
  // One that no header names is the one at tool_tip_mm.
  if (unstated.size() > 1 || (!unstated.empty() && !targets.on_tool.empty()))
    return absl::InvalidArgumentError(absl::StrCat(
        "target ", absl::StrJoin(unstated, ", "),
        ": expected '# reference NAME: x y z' of what stands beside the "
        "machine and, where more than one target is on the tool, '# target NAME: x y z' of each, mm, machine axes at "
        "home"));
  if (is_whole) RETURN_IF_ERROR(CheckAllSeen(targets));
  if (!targets.references.empty()) {
    const session::Column* const times = session::FindColumn(session, "t_s");
    if (times == nullptr)
      return absl::InvalidArgumentError("reference targets need the column t_s: when the tracker stood where");
    if (session::FindHeader(session, "setup"))
      return absl::InvalidArgumentError(
          "setup: a session with reference targets has a set-up of its own, expected all "
          "that one tracker measured from there in one session");
    targets.looks_s = LooksOf(targets, times->values);
  }
  if (const std::optional<std::string> knocked = session::FindHeader(session, "knocked_s")) {
    if (!session::ParseNumbers(*knocked, &targets.knocked_s) || targets.knocked_s.empty() ||
        !std::is_sorted(targets.knocked_s.begin(), targets.knocked_s.end()) || targets.references.empty())
      return absl::InvalidArgumentError(absl::StrCat("header 'knocked_s: ", *knocked,
                                                     "', expected times t_s, ascending, at which the tracker was "
                                                     "knocked, in a session with reference targets"));
  }
  if (is_whole && !targets.knocked_s.empty()) {
    const std::vector<double>& times_s = session::FindColumn(session, "t_s")->values;
    const auto [first, last] = std::minmax_element(times_s.begin(), times_s.end());
    if (targets.knocked_s.front() <= *first || targets.knocked_s.back() > *last)
      return absl::InvalidArgumentError(absl::StrCat("header 'knocked_s: ", *session::FindHeader(session, "knocked_s"),
                                                     "', expected times between the first and the last reading, t_s ",
                                                     *first, " to ", *last));
  }
  run->targets = std::move(targets);
  run->setup = SetupParametersOf(run->targets);
  return absl::OkStatus();
}

}  // namespace axiscal::tracker
