// What rewriting a program needs, from the store: for jobs and for calls that rewrite while the program comes.
#ifndef AXISCAL_SERVER_INPUTS_COMPENSATION_H_
#define AXISCAL_SERVER_INPUTS_COMPENSATION_H_

#include <string>
#include <vector>

#include "core/compensate/compensator.h"
#include "core/nc/options.h"
#include "proto/convert/job_params.h"
#include "server/storage/database.h"

namespace axiscal::inputs {

struct Compensation {
  records::CalibrationRecord calibration;
  compensate::Compensator compensator;
  nc::RewriteOptions options;      // with the calibration's name for the mark
  std::vector<std::string> notes;  // for the report: what the calibration cannot tell apart, what the profile said
};

// The params with what the profile of their machine says of what they leave open, and `of_profile` saying what that
// was; as they are where they are `without_profile`. Profile and machine are those of now. NOT_FOUND MACHINE_NOT_FOUND;
// FAILED_PRECONDITION PROFILE_INVALID; INVALID_ARGUMENT FIELD_INVALID of `field` where profile and params do not go
// together (nc::TakeProfile), or neither states the tool point.
absl::StatusOr<records::CompensateParams> WithProfile(storage::Database& database, records::CompensateParams params,
                                                      const std::string& field);

// Errors of CalibrationFor, CheckTables, MachineFor and Compensator::Create.
absl::StatusOr<Compensation> CompensationFor(storage::Database& database, const records::CompensateParams& params,
                                             const std::string& calibration_field);

}  // namespace axiscal::inputs

#endif  // AXISCAL_SERVER_INPUTS_COMPENSATION_H_
