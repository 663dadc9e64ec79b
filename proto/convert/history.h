// Drift history on the wire.
#ifndef AXISCAL_PROTO_CONVERT_HISTORY_H_
#define AXISCAL_PROTO_CONVERT_HISTORY_H_

#include "axiscal/v1/history_service.pb.h"
#include "core/base/status.h"
#include "core/records/care.h"
#include "core/records/drift.h"
#include "core/records/history.h"
#include "core/records/mark.h"

namespace axiscal::convert {

inline constexpr int kDefaultDriftPoints = 500;
inline constexpr int kMaxDriftPoints = 100'000;
// Names in one question, each looked up for each machine: far more than a machine has errors.
inline constexpr int kMaxSymbols = 1000;

v1::QueryDriftRequest ToProto(const records::DriftQuery& query);
// Unset ends are the beginning and the end of time. FIELD_INVALID: no machine, from after to, max_points outside 0 to
// kMaxDriftPoints, more than kMaxSymbols symbols.
absl::StatusOr<records::DriftQuery> FromProto(const v1::QueryDriftRequest& message);

v1::DriftSeries ToProto(const records::DriftSeries& series);
absl::StatusOr<records::DriftSeries> FromProto(const v1::DriftSeries& message);

v1::MachineLatest ToProto(const records::FleetRow& row);
absl::StatusOr<records::FleetRow> FromProto(const v1::MachineLatest& message);

v1::Mark ToProto(const records::Mark& mark);
// FIELD_INVALID: no known kind.
absl::StatusOr<records::Mark> FromProto(const v1::Mark& message);

v1::PutMarkRequest ToProto(const records::NewMark& mark, const std::string& request_id);
// FIELD_INVALID: no machine, no known kind, more than 64 symbols, one that is empty or there twice, a note that is too
// long.
absl::StatusOr<records::NewMark> FromProto(const v1::PutMarkRequest& message);

v1::FindDriftRequest ToProto(const records::DriftSearch& search);
// FIELD_INVALID: a finding of no known kind, a number that is none.
absl::StatusOr<records::DriftReport> FromProto(const v1::FindDriftResponse& message);

v1::MachineCare ToProto(const records::MachineCare& care);
// FIELD_INVALID: no machine, no known care, a finding of no known kind, a number that is none.
absl::StatusOr<records::MachineCare> FromProto(const v1::MachineCare& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_HISTORY_H_
