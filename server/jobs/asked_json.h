// How a calibration was asked for, as it is kept beside what came out (options_json).
#ifndef AXISCAL_SERVER_JOBS_ASKED_JSON_H_
#define AXISCAL_SERVER_JOBS_ASKED_JSON_H_

#include <string>
#include <vector>

#include "core/records/job_params.h"
#include "core/records/session.h"

namespace axiscal::jobs {

std::string AskedJson(const records::IdentifyParams& params);
// Sessions with names and checksums: what the result can be computed again from.
std::string AskedJson(const records::CloseLoopParams& params, const std::vector<records::SessionRecord>& fit,
                      const std::vector<records::SessionRecord>& check);

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_ASKED_JSON_H_
