// How estimates went over time. What each function returns: database.h.
#ifndef AXISCAL_SERVER_STORAGE_HISTORY_H_
#define AXISCAL_SERVER_STORAGE_HISTORY_H_

#include <functional>
#include <string>
#include <vector>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// Up to max_points estimates are given one by one. More are merged: into equal spans of time, or, where a span is a
// week or more, into whole numbers of weeks read from the weekly sums (13 symbols, ten years of daily calibrations:
// some 7,000 rows instead of 47,000).
//
// An estimate that is not what was stored is left out, a week's sums that are not are replaced by its single estimates;
// `damaged` is told of each (DATA_LOSS HISTORY_DAMAGED, facts machine, symbol, and calibration or week).
using DamageTold = std::function<void(const absl::Status&)>;
absl::StatusOr<std::vector<DriftSeries>> QueryDrift(Connection& connection, const DriftQuery& query,
                                                    const DamageTold& damaged);

// Where the newest estimate is damaged, `damaged` is told and the error is left out.
absl::StatusOr<Page<FleetRow>> LatestFleet(Connection& connection, const std::vector<std::string>& symbols,
                                           const PageRequest& request, const Visible& visible,
                                           const DamageTold& damaged);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_HISTORY_H_
