// What a disk must not change unseen: a calibration moves a machine.
#ifndef AXISCAL_SERVER_STORAGE_CALIBRATION_CHECKSUM_H_
#define AXISCAL_SERVER_STORAGE_CALIBRATION_CHECKSUM_H_

#include <string>

#include "server/storage/records.h"

namespace axiscal::storage {

// SHA-256, 64 hexadecimal digits, of all that the record says (model, estimates, options, report, sessions, quality,
// state, who and when) and of `description_json`, the machine's description that was fitted. Bytes: each field in order
// with its length before it, numbers as decimal text, doubles as their 64 bits, absent ones as such.
std::string CalibrationChecksum(const CalibrationRecord& record, const std::string& description_json);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_CALIBRATION_CHECKSUM_H_
