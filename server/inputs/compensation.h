// What rewriting a program needs, from the store: for jobs and for calls that rewrite while the program comes.
#ifndef AXISCAL_SERVER_INPUTS_COMPENSATION_H_
#define AXISCAL_SERVER_INPUTS_COMPENSATION_H_

#include "core/compensate/compensator.h"
#include "core/nc/options.h"
#include "proto/convert/job_params.h"
#include "server/storage/database.h"

namespace axiscal::inputs {

struct Compensation {
  records::CalibrationRecord calibration;
  compensate::Compensator compensator;
  nc::RewriteOptions options;  // with the calibration's name for the mark
};

// Errors of CalibrationFor, CheckTables, MachineFor and Compensator::Create.
absl::StatusOr<Compensation> CompensationFor(storage::Database& database, const records::CompensateParams& params,
                                             const std::string& calibration_field);

}  // namespace axiscal::inputs

#endif  // AXISCAL_SERVER_INPUTS_COMPENSATION_H_
