// What rewriting a program needs, from the store: for jobs and for calls that rewrite while the program comes.
#ifndef AXISCAL_SERVER_INPUTS_COMPENSATION_H_
#define AXISCAL_SERVER_INPUTS_COMPENSATION_H_

#include <string>
#include <vector>

#include "core/compensate/compensator.h"
#include "core/nc/options.h"
#include "core/nc/remark.h"
#include "core/nc/report.h"
#include "proto/convert/job_params.h"
#include "server/inputs/calibration_use.h"
#include "server/storage/database.h"

namespace axiscal::inputs {

struct Compensation {
  records::CalibrationRecord calibration;
  compensate::Compensator compensator;
  nc::RewriteOptions options;     // with the calibration's name for the mark
  std::vector<nc::Remark> notes;  // for the report: what the calibration cannot tell apart, what the profile said
  Doubts doubts;                  // likewise
  int64_t machine_revision = 0;   // whose profile it was

  // Adds what a report of a rewriting with this must say of the calibration and the profile.
  void AddTo(nc::RewriteReport* report) const;
};

// OK if the profile of the machine and what the params leave open go together. NOT_FOUND MACHINE_NOT_FOUND;
// FAILED_PRECONDITION PROFILE_INVALID; INVALID_ARGUMENT FIELD_INVALID of `field`, which is that of the params, where
// they do not (nc::TakeProfile), or neither states the tool point.
absl::Status CheckProfile(storage::Database& database, const records::CompensateParams& params,
                          const std::string& field);

// What the profile of the machine says of what the params leave open counts as if they had said it, but
// `without_profile`. Profile and machine are those of now. Errors of CheckProfile, CalibrationFor, CheckTables,
// MachineFor and Compensator::Create.
absl::StatusOr<Compensation> CompensationFor(storage::Database& database, const records::CompensateParams& params,
                                             const std::string& field);

}  // namespace axiscal::inputs

#endif  // AXISCAL_SERVER_INPUTS_COMPENSATION_H_
