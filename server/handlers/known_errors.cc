#include "server/handlers/known_errors.h"

#include "core/machine/machine_json.h"
#include "proto/convert/field.h"

namespace axiscal::handlers {

absl::StatusOr<KnownErrors> KnownErrors::Of(storage::Database& database, const MachineId& machine) {
  KnownErrors known;
  known.machine_ = machine;
  const records::DriftQuery all{machine, {}, base::UtcTime::min(), base::UtcTime::max(), 1};
  ASSIGN_OR_RETURN(const std::vector<records::DriftSeries> series, database.QueryDrift(all));
  for (const records::DriftSeries& one : series) known.symbols_.insert(one.symbol);
  if (!known.symbols_.empty()) return known;
  ASSIGN_OR_RETURN(const records::MachineRecord record, database.GetMachine(machine));
  ASSIGN_OR_RETURN(known.described_, machine::MachineFromJson(record.description_json));
  return known;
}

absl::Status KnownErrors::Require(const std::string& field, const std::string& symbol) const {
  if (symbols_.contains(symbol)) return absl::OkStatus();
  if (!symbols_.empty())
    return convert::FieldError(field,
                               absl::StrCat("no calibration of machine ", machine_.text(), " has an error ", symbol));
  // "EX0C", or "EXX:linear" of which the shape is not known before a calibration has it.
  const std::string written = symbol.substr(0, symbol.find(':'));
  const auto parsed = machine::ParseErrorSymbol(written);
  if (!parsed.ok()) return convert::FieldError(field, std::string(parsed.status().message()));
  if (machine::ToString(*parsed) != written)  // another way to write it would meet no calibration's
    return convert::FieldError(field, absl::StrCat(symbol, ": expected ", machine::ToString(*parsed)));
  if (machine::FindJoint(described_, parsed->axis) < 0)
    return convert::FieldError(field,
                               absl::StrCat(symbol, ": machine ", machine_.text(), " has no axis ", parsed->axis));
  return absl::OkStatus();
}

}  // namespace axiscal::handlers
