// DEMAND(condition) stops the program at our own bug; bad input is never a bug and returns absl::Status instead.
#ifndef AXISCAL_CORE_BASE_DEMAND_H_
#define AXISCAL_CORE_BASE_DEMAND_H_

namespace axiscal::base {

[[noreturn]] void DemandFailed(const char* condition, const char* file, int line);

}  // namespace axiscal::base

#define DEMAND(condition)                                                          \
  do {                                                                             \
    if (!(condition)) ::axiscal::base::DemandFailed(#condition, __FILE__, __LINE__); \
  } while (false)

#endif  // AXISCAL_CORE_BASE_DEMAND_H_
