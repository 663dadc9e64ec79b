// Numbers of a session's header lines, for sessions whose header was validated when they were read.
#ifndef AXISCAL_CORE_TOOLSETTER_HEADER_NUMBERS_H_
#define AXISCAL_CORE_TOOLSETTER_HEADER_NUMBERS_H_

#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/session/session.h"

namespace axiscal::toolsetter {

// `count` finite numbers under `key`; none when there is no such key. INVALID_ARGUMENT naming key, value and rule:
// "rod_sigma standard: '5', expected 5 numbers: ...".
absl::StatusOr<std::vector<double>> HeaderNumbers(const session::Session& session, const std::string& key, int count,
                                                  const std::string& expected);

// The same with any count of at least one.
absl::StatusOr<std::vector<double>> HeaderList(const session::Session& session, const std::string& key,
                                               const std::string& expected);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_HEADER_NUMBERS_H_
