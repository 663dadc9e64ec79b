#include "server/inputs/machine_history.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <set>

#include "core/base/error_detail.h"
#include "core/drift/detector.h"
#include "core/machine/error_covariance.h"
#include "server/inputs/calibration_use.h"

namespace axiscal::inputs {
namespace {

using records::CalibrationRecord;

constexpr int kPageSize = 1000;

absl::Status CallerGone() {
  return base::Error(absl::StatusCode::kCancelled, "the caller has left", {"CALLER_GONE", {}});
}

// All rows of a list. `list` asks for one page.
template <typename Row, typename List>
absl::StatusOr<std::vector<Row>> AllOf(const List& list, const std::function<bool()>& is_cancelled) {
  std::vector<Row> all;
  records::PageRequest request{kPageSize, ""};
  do {
    if (is_cancelled()) return CallerGone();
    ASSIGN_OR_RETURN(records::Page<Row> page, list(request));
    for (Row& row : page.rows) all.push_back(std::move(row));
    request.token = page.next_token;
  } while (!request.token.empty());
  return all;
}

// What it determined: values with a sigma, and how they vary together as far as its model says so.
absl::StatusOr<drift::Calibration> PointOf(storage::Database& database, const CalibrationRecord& listed) {
  ASSIGN_OR_RETURN(const CalibrationRecord record, database.GetCalibration(listed.id));
  ASSIGN_OR_RETURN(const machine::Machine machine, MachineFor(database, record));
  ASSIGN_OR_RETURN(const machine::KnownErrors known, machine::ReadKnownErrors(record.content.model_json, machine));
  drift::Calibration point;
  point.at = record.content.measured_at;
  std::vector<double> sigmas;
  for (const records::Estimate& estimate : record.content.estimates) {
    if (!estimate.identifiable || !estimate.value || !estimate.sigma) continue;
    const bool is_um = estimate.unit == records::EstimateUnit::kUm;
    point.values.push_back({estimate.symbol, is_um ? drift::Unit::kUm : drift::Unit::kUrad, *estimate.value});
    sigmas.push_back(*estimate.sigma);
  }
  point.covariance = drift::Uncorrelated(sigmas);
  const machine::ErrorCovariance& stated = known.covariance;
  const Eigen::MatrixXd covariance = stated.root * stated.root.transpose();
  std::map<std::string, int> row_of;
  for (size_t i = 0; i < stated.of.size(); ++i) {
    const machine::ErrorCovariance::Number& number = stated.of[i];
    row_of[machine::NameNumber(machine, known.model, number.term, number.basis, number.is_nonlinear).name] =
        static_cast<int>(i);
  }
  for (size_t i = 0; i < sigmas.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const auto a = row_of.find(point.values[i].symbol), b = row_of.find(point.values[j].symbol);
      if (a == row_of.end() || b == row_of.end()) continue;
      const double scale = std::sqrt(covariance(a->second, a->second) * covariance(b->second, b->second));
      const double shared = scale > 0 ? covariance(a->second, b->second) / scale * sigmas[i] * sigmas[j] : 0.0;
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(j);
      point.covariance(row, column) = point.covariance(column, row) = shared;
    }
  }
  return point;
}

// What the machine's routines have made.
absl::StatusOr<std::set<CalibrationId>> MadeByRoutines(storage::Database& database, const MachineId& machine,
                                                       const std::function<bool()>& is_cancelled) {
  records::RunFilter filter;
  filter.machine = machine;
  ASSIGN_OR_RETURN(
      const std::vector<records::RoutineRun> runs,
      AllOf<records::RoutineRun>([&](const auto& page) { return database.ListRuns(filter, page, {}); }, is_cancelled));
  std::set<CalibrationId> made;
  for (const records::RoutineRun& run : runs) {
    if (run.calibration) made.insert(*run.calibration);
  }
  return made;
}

// Those that count, the oldest first; `all` in any order.
template <typename CountsCandidate>
std::vector<CalibrationRecord> CountedCalibrations(const std::vector<CalibrationRecord>& all,
                                                   const CountsCandidate& counts_candidate) {
  // Whether `a` stands for its set rather than `b`.
  const auto is_better = [](const CalibrationRecord& a, const CalibrationRecord& b) {
    if (a.approved_at != b.approved_at) return a.approved_at > b.approved_at;  // never comes first
    return a.version > b.version;
  };
  std::map<std::vector<SessionId>, const CalibrationRecord*> of_set;
  for (const CalibrationRecord& record : all) {
    if (!record.rejected_sessions.empty()) continue;
    const bool is_candidate = record.state == records::CalibrationState::kCandidate;
    if (!record.approved_at && !(is_candidate && counts_candidate(record))) continue;
    std::vector<SessionId> set = record.content.sessions;
    std::sort(set.begin(), set.end());
    const CalibrationRecord*& chosen = of_set[set];
    if (chosen == nullptr || is_better(record, *chosen)) chosen = &record;
  }
  std::map<base::UtcTime, const CalibrationRecord*> at;
  for (const auto& [set, record] : of_set) {
    const CalibrationRecord*& chosen = at[record->content.measured_at];
    if (chosen == nullptr || record->version > chosen->version) chosen = record;
  }
  std::vector<CalibrationRecord> counted;
  for (const auto& [time, record] : at) counted.push_back(*record);
  return counted;
}

// Those that count, the oldest first.
absl::StatusOr<std::vector<records::Mark>> MarksOf(storage::Database& database, const MachineId& machine,
                                                   const std::function<bool()>& is_cancelled) {
  ASSIGN_OR_RETURN(
      std::vector<records::Mark> marks,
      AllOf<records::Mark>([&](const auto& page) { return database.ListMarks(machine, page); }, is_cancelled));
  std::erase_if(marks, [](const records::Mark& mark) { return mark.withdrawn_at.has_value(); });
  std::sort(marks.begin(), marks.end(), [](const records::Mark& a, const records::Mark& b) {
    return std::pair(a.content.at, a.id) < std::pair(b.content.at, b.id);
  });
  return marks;
}

drift::Mark ToDrift(const records::Mark& mark) {
  drift::MarkKind kind = drift::MarkKind::kCollision;
  if (mark.content.kind == records::MarkKind::kService) kind = drift::MarkKind::kService;
  if (mark.content.kind == records::MarkKind::kRefixturing) kind = drift::MarkKind::kRefixturing;
  return {mark.content.at, kind, mark.content.symbols};
}

}  // namespace

std::string DayText(base::UtcTime at) {
  const std::chrono::year_month_day day(std::chrono::floor<std::chrono::days>(at));
  return absl::StrFormat("%d-%02d-%02d", static_cast<int>(day.year()), static_cast<unsigned>(day.month()),
                         static_cast<unsigned>(day.day()));
}

absl::StatusOr<MachineHistory> FollowHistory(storage::Database& database, const MachineId& machine,
                                             bool counts_candidates, const std::function<bool()>& is_cancelled) {
  records::CalibrationFilter filter;
  filter.machine = machine;
  ASSIGN_OR_RETURN(const std::vector<CalibrationRecord> all,
                   AllOf<CalibrationRecord>([&](const auto& page) { return database.ListCalibrations(filter, page); },
                                            is_cancelled));
  std::set<CalibrationId> by_routines;
  if (!counts_candidates) {
    ASSIGN_OR_RETURN(by_routines, MadeByRoutines(database, machine, is_cancelled));
  }
  const auto counts = [&](const CalibrationRecord& candidate) {
    return counts_candidates || by_routines.count(candidate.id) > 0;
  };
  MachineHistory history;
  ASSIGN_OR_RETURN(history.marks, MarksOf(database, machine, is_cancelled));
  history.calibrations = static_cast<int64_t>(all.size());
  for (const CalibrationRecord& record : all) {
    const bool is_retired = record.state == records::CalibrationState::kRetired;
    if (!is_retired && (!history.newest || *history.newest < record.id)) history.newest = record.id;
  }
  size_t next_mark = 0;
  // A mark stands behind what was measured until then.
  const auto put_marks_before = [&](base::UtcTime at) -> absl::Status {
    for (; next_mark < history.marks.size() && history.marks[next_mark].content.at < at; ++next_mark)
      RETURN_IF_ERROR(drift::Put(ToDrift(history.marks[next_mark]), &history.state));
    return absl::OkStatus();
  };
  for (const CalibrationRecord& record : CountedCalibrations(all, counts)) {
    if (is_cancelled()) return CallerGone();
    RETURN_IF_ERROR(put_marks_before(record.content.measured_at));
    const absl::StatusOr<drift::Calibration> point = PointOf(database, record);
    const absl::StatusOr<std::vector<drift::Finding>> findings =
        point.ok() ? drift::Advance(*point, &history.state) : point.status();
    if (!findings.ok()) {
      // One that cannot be followed hides none of the others; that it is left out is said.
      history.left_out.push_back(
          {record.id, absl::StrCat("calibration ", record.id.number(), " of ", DayText(record.content.measured_at),
                                   " does not count: ", std::string(findings.status().message()))});
      continue;
    }
    history.counted.push_back(record);
    for (const drift::Finding& finding : *findings) history.findings.push_back(finding);
  }
  RETURN_IF_ERROR(put_marks_before(base::UtcTime::max()));
  return history;
}

}  // namespace axiscal::inputs
