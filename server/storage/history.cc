#include "server/storage/history.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "core/base/error_detail.h"
#include "server/storage/access.h"
#include "server/storage/estimates.h"
#include "server/storage/machines.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"

namespace axiscal::storage {
namespace {

constexpr int kMaxPoints = 100'000;

// Microseconds since 1970: [from, to).
struct Span {
  int64_t from = 0;
  int64_t to = 0;
};

absl::Status Damaged(const MachineId& machine, const std::string& symbol, const std::string& what, int64_t number) {
  return base::Error(
      absl::StatusCode::kDataLoss,
      absl::StrCat("history of ", symbol, " of machine ", machine.text(), ": ", what, " ", number,
                   " is damaged: not what was stored"),
      {"HISTORY_DAMAGED", {{"machine", machine.text()}, {"symbol", symbol}, {what, std::to_string(number)}}});
}

// One symbol's series while it is being filled. Points come in time order; those of equal bucket are merged.
class SeriesBuilder {
 public:
  SeriesBuilder(Connection& connection, int64_t machine_key, const MachineId& machine, const std::string& symbol,
                const DamageTold& damaged)
      : connection_(connection), machine_key_(machine_key), machine_(machine), damaged_(damaged) {
    series_.symbol = symbol;
  }

  // Single estimates; those of one span of `bucket_us` (0: none) are merged.
  absl::Status AddEstimates(const Span& span, int64_t origin_us, int64_t bucket_us);
  // Whole weeks [first, end) of the weekly sums, in buckets of `weeks_per_bucket`.
  absl::Status AddWeeks(int64_t first, int64_t end, int64_t origin_us, int64_t bucket_us);
  absl::StatusOr<bool> HasMoreThan(const Span& span, int limit);
  DriftSeries Take() { return std::move(series_); }

 private:
  void Merge(int64_t bucket, const DriftPoint& point);

  Connection& connection_;
  const int64_t machine_key_;
  const MachineId& machine_;
  const DamageTold& damaged_;
  DriftSeries series_;
  int64_t last_bucket_ = -1;
};

void SeriesBuilder::Merge(int64_t bucket, const DriftPoint& point) {
  if (series_.points.empty() || bucket != last_bucket_) {
    series_.points.push_back(point);
    last_bucket_ = bucket;
    return;
  }
  DriftPoint& merged = series_.points.back();
  const int64_t count = merged.count + point.count;
  merged.mean += (point.mean - merged.mean) * (static_cast<double>(point.count) / static_cast<double>(count));
  merged.count = count;
  merged.min = std::min(merged.min, point.min);
  merged.max = std::max(merged.max, point.max);
  merged.last_at = point.last_at;
  merged.sigma = point.sigma;
  merged.last_calibration = point.last_calibration;
}

absl::Status SeriesBuilder::AddEstimates(const Span& span, int64_t origin_us, int64_t bucket_us) {
  if (span.from >= span.to) return absl::OkStatus();
  ASSIGN_OR_RETURN(
      Statement row,
      connection_.Ask(absl::StrCat("SELECT e.measured_at_utc_us, e.unit, e.estimated_um_urad, e.sigma_um_urad, "
                                   "e.calibration_id, ",
                                   kIsIntactEstimate, ", CASE WHEN ", kIsRejected, " THEN 1 ELSE 0 END",
                                   " FROM estimate AS e CROSS JOIN calibration AS c ON c.id = e.calibration_id "
                                   "WHERE e.machine_id = ?1 AND e.symbol = ?2 AND e.measured_at_utc_us >= ?3 AND "
                                   "e.measured_at_utc_us < ?4 ORDER BY e.measured_at_utc_us, e.calibration_id"),
                      machine_key_, series_.symbol, span.from, span.to));
  for (int64_t n = 0;; ++n) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return absl::OkStatus();
    if (!row.Bool(5)) {
      damaged_(Damaged(machine_, series_.symbol, "calibration", row.Int(4)));
      continue;
    }
    if (row.Bool(6)) continue;  // rejected
    series_.unit = row.As<EstimateUnit>(1);
    if (row.IsNull(2)) {
      ++series_.not_identifiable_count;
      continue;
    }
    const UtcTime at = row.Time(0);
    const double value = row.Real(2);
    const int64_t bucket = bucket_us > 0 ? (row.Int(0) - origin_us) / bucket_us : n;
    Merge(bucket, {at, at, 1, value, value, value, row.OptionalReal(3), CalibrationId(row.Int(4))});
  }
}

absl::Status SeriesBuilder::AddWeeks(int64_t first, int64_t end, int64_t origin_us, int64_t bucket_us) {
  if (first >= end) return absl::OkStatus();
  ASSIGN_OR_RETURN(
      Statement row,
      connection_.Ask(absl::StrCat("SELECT week, unit, estimate_count, not_identifiable_count, min_um_urad, "
                                   "max_um_urad, sum_um_urad, first_at_utc_us, last_at_utc_us, last_sigma_um_urad, "
                                   "last_calibration_id, ",
                                   kIsIntactWeek,
                                   " FROM estimate_week AS w WHERE machine_id = ?1 AND symbol = ?2 AND week >= ?3 AND "
                                   "week < ?4 ORDER BY week"),
                      machine_key_, series_.symbol, first, end));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return absl::OkStatus();
    if (!row.Bool(11)) {
      const int64_t week = row.Int(0);
      damaged_(Damaged(machine_, series_.symbol, "week", week));
      RETURN_IF_ERROR(AddEstimates({week * kWeekUs, (week + 1) * kWeekUs}, origin_us, bucket_us));
      continue;
    }
    series_.unit = row.As<EstimateUnit>(1);
    series_.not_identifiable_count += row.Int(3);
    const int64_t count = row.Int(2);
    if (count == 0) continue;
    Merge((row.Int(0) * kWeekUs - origin_us) / bucket_us,
          {row.Time(7), row.Time(8), count, row.Real(4), row.Real(5), row.Real(6) / static_cast<double>(count),
           row.OptionalReal(9), CalibrationId(row.Int(10))});
  }
}

absl::StatusOr<bool> SeriesBuilder::HasMoreThan(const Span& span, int limit) {
  {
    // Where there are no more with those that were rejected, their calibrations need not be asked.
    ASSIGN_OR_RETURN(Statement row,
                     connection_.Ask("SELECT count(*) FROM (SELECT 1 FROM estimate WHERE machine_id = ?1 AND symbol = "
                                     "?2 AND measured_at_utc_us >= ?3 AND measured_at_utc_us < ?4 LIMIT ?5) AS point",
                                     machine_key_, series_.symbol, span.from, span.to, limit + 1));
    RETURN_IF_ERROR(row.Step().status());
    if (row.Int(0) <= limit) return false;
  }
  ASSIGN_OR_RETURN(Statement row,
                   connection_.Ask(absl::StrCat("SELECT count(*) FROM (SELECT 1 FROM estimate AS e CROSS JOIN "
                                                "calibration AS c ON c.id = e.calibration_id "
                                                "WHERE e.machine_id = ?1 AND e.symbol = ?2 AND "
                                                "e.measured_at_utc_us >= ?3 AND e.measured_at_utc_us < ?4 AND ",
                                                kIsPoint, " LIMIT ?5) AS point"),
                                   machine_key_, series_.symbol, span.from, span.to, limit + 1));
  RETURN_IF_ERROR(row.Step().status());
  return row.Int(0) > limit;
}

int64_t CeilDivide(int64_t number, int64_t divisor) { return (number + divisor - 1) / divisor; }

absl::Status Fill(const Span& span, int max_points, SeriesBuilder& builder) {
  ASSIGN_OR_RETURN(const bool many, builder.HasMoreThan(span, max_points));
  if (!many) return builder.AddEstimates(span, 0, 0);
  const int64_t first_week = span.from / kWeekUs, weeks = CeilDivide(span.to, kWeekUs) - first_week;
  if (weeks <= max_points) return builder.AddEstimates(span, span.from, CeilDivide(span.to - span.from, max_points));
  // Buckets of whole weeks; the sums serve the weeks that lie wholly in the span, single estimates its two ends.
  const int64_t origin_us = first_week * kWeekUs, bucket_us = CeilDivide(weeks, max_points) * kWeekUs;
  const int64_t first_whole = CeilDivide(span.from, kWeekUs), end_whole = span.to / kWeekUs;
  RETURN_IF_ERROR(builder.AddEstimates({span.from, first_whole * kWeekUs}, origin_us, bucket_us));
  RETURN_IF_ERROR(builder.AddWeeks(first_whole, end_whole, origin_us, bucket_us));
  return builder.AddEstimates({end_whole * kWeekUs, span.to}, origin_us, bucket_us);
}

// The part of the range in which the machine has estimates of these symbols; of none: of all that it has, which are put
// there. An open range (0 .. far future) must not make one bucket of everything.
absl::StatusOr<Span> Narrow(Connection& connection, int64_t machine_key, std::vector<std::string>& symbols, Span span) {
  Span known = {span.to, span.from};
  const auto add = [&](const Statement& row) {
    if (row.IsNull(0)) return;
    known.from = std::min(known.from, row.Int(0) * kWeekUs);
    known.to = std::max(known.to, (row.Int(1) + 1) * kWeekUs);
  };
  if (symbols.empty()) {
    ASSIGN_OR_RETURN(
        Statement row,
        connection.Ask(absl::StrCat("WITH RECURSIVE ", kSymbolsOfMachine,
                                    " SELECT (SELECT min(week) FROM estimate_week WHERE machine_id = ?1 AND symbol = "
                                    "known.symbol), (SELECT max(week) FROM estimate_week WHERE machine_id = ?1 AND "
                                    "symbol = known.symbol), symbol FROM known WHERE symbol IS NOT NULL"),
                       machine_key));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      add(row);
      symbols.push_back(row.Text(2));
    }
  } else {
    for (const std::string& symbol : symbols) {
      ASSIGN_OR_RETURN(
          Statement row,
          connection.Ask("SELECT (SELECT min(week) FROM estimate_week WHERE machine_id = ?1 AND symbol = ?2), "
                         "(SELECT max(week) FROM estimate_week WHERE machine_id = ?1 AND symbol = ?2)",
                         machine_key, symbol));
      RETURN_IF_ERROR(row.Step().status());
      add(row);
    }
  }
  return Span{std::max(span.from, known.from), std::min(span.to, known.to)};
}

absl::Status CheckQuery(const DriftQuery& query) {
  const auto refuse = [](const std::string& field, const std::string& rule) {
    return base::Error(absl::StatusCode::kInvalidArgument, field + ": " + rule,
                       {"RANGE_INVALID", {{"field", field}, {"rule", rule}}});
  };
  if (query.from >= query.to) return refuse("from_utc_us", "must be before to_utc_us");
  if (query.max_points < 1 || query.max_points > kMaxPoints) {
    return refuse("max_points", absl::StrCat(query.max_points, ", must be 1 to ", kMaxPoints));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<LatestEstimate>> Latest(Connection& connection, int64_t machine_key,
                                                   const MachineId& machine, std::vector<std::string> symbols,
                                                   const DamageTold& damaged) {
  if (symbols.empty()) {
    ASSIGN_OR_RETURN(symbols, MachineSymbols(connection, machine_key));
  }
  std::vector<LatestEstimate> latest;
  // Nothing older than the oldest calibration that is not retired counts: errors that no model has had for years need
  // not be looked for in all of them.
  int64_t oldest_us;
  {
    ASSIGN_OR_RETURN(
        Statement row,
        connection.Ask("SELECT min(measured_at_utc_us) FROM calibration INDEXED BY calibration_in_use WHERE "
                       "machine_id = ?1 AND state <> 3",
                       machine_key));
    RETURN_IF_ERROR(row.Step().status());
    if (row.IsNull(0)) return latest;
    oldest_us = row.Int(0);
  }
  for (const std::string& symbol : symbols) {
    ASSIGN_OR_RETURN(
        Statement row,
        connection.Ask(
            absl::StrCat("SELECT e.unit, e.identifiable, e.estimated_um_urad, e.sigma_um_urad, e.measured_at_utc_us, "
                         "e.calibration_id, c.state, ",
                         kIsIntactEstimate,
                         " FROM estimate AS e CROSS JOIN calibration AS c "
                         "ON c.id = e.calibration_id WHERE e.machine_id = ?1 AND e.symbol = ?2 "
                         "AND e.measured_at_utc_us >= ?3 AND c.state <> 3 "
                         "ORDER BY e.measured_at_utc_us DESC, e.calibration_id DESC LIMIT 1"),
            machine_key, symbol, oldest_us));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) continue;
    if (!row.Bool(7)) {
      damaged(Damaged(machine, symbol, "calibration", row.Int(5)));
      continue;
    }
    const Estimate estimate = {symbol, row.As<EstimateUnit>(0), row.Bool(1), row.OptionalReal(2), row.OptionalReal(3)};
    latest.push_back({estimate, row.Time(4), CalibrationId(row.Int(5)), row.As<CalibrationState>(6)});
  }
  return latest;
}

}  // namespace

absl::StatusOr<std::vector<DriftSeries>> QueryDrift(Connection& connection, const DriftQuery& query,
                                                    const DamageTold& damaged) {
  RETURN_IF_ERROR(CheckQuery(query));
  ASSIGN_OR_RETURN(const int64_t machine_key, MachineKey(connection, query.machine));
  std::vector<std::string> symbols = query.symbols;
  std::sort(symbols.begin(), symbols.end());
  symbols.erase(std::unique(symbols.begin(), symbols.end()), symbols.end());
  const Span asked = {std::max<int64_t>(base::ToUtcUs(query.from), 0), base::ToUtcUs(query.to)};
  ASSIGN_OR_RETURN(const Span span, Narrow(connection, machine_key, symbols, asked));
  std::vector<DriftSeries> all;
  for (const std::string& symbol : symbols) {
    SeriesBuilder builder(connection, machine_key, query.machine, symbol, damaged);
    RETURN_IF_ERROR(Fill(span, query.max_points, builder));
    DriftSeries series = builder.Take();
    if (!series.points.empty() || series.not_identifiable_count > 0) all.push_back(std::move(series));
  }
  return all;
}

absl::StatusOr<Page<FleetRow>> LatestFleet(Connection& connection, const std::vector<std::string>& symbols,
                                           const PageRequest& request, const Visible& visible,
                                           const DamageTold& damaged) {
  std::vector<std::string> ordered = symbols;
  std::sort(ordered.begin(), ordered.end());
  ordered.erase(std::unique(ordered.begin(), ordered.end()), ordered.end());
  ASSIGN_OR_RETURN(const PageStart start, StartPage(request, "fleet|" + absl::StrJoin(ordered, ",")));
  ASSIGN_OR_RETURN(const std::vector<int64_t> machines, MachinesIn(connection, visible.scopes));
  const std::string seen = visible.everything ? "" : "AND +id IN (SELECT value FROM json_each(?3)) ";
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT id, name FROM machine WHERE name > ?1 AND deleted_at_utc_us IS NULL " + seen +
                                      "ORDER BY name LIMIT ?2",
                                  start.after.value_or(""), start.row_limit(), JsonOf(machines)));
  Page<FleetRow> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    page.rows.push_back({MachineId(row.Text(1)), {}});
    if (page.rows.size() > static_cast<size_t>(start.size)) break;  // tells only that another page follows
    ASSIGN_OR_RETURN(page.rows.back().latest,
                     Latest(connection, row.Int(0), page.rows.back().machine, ordered, damaged));
  }
  EndPage(
      start, [](const FleetRow& fleet) { return fleet.machine.text(); },
      [](const FleetRow& fleet) {
        size_t bytes = 0;
        for (const LatestEstimate& latest : fleet.latest) bytes += latest.estimate.symbol.size() + 60;
        return bytes;
      },
      page);
  return page;
}

}  // namespace axiscal::storage
