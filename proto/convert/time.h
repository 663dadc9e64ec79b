// Times on the wire are microseconds since 1970-01-01 UTC. Optional ones are unset, never 0.
#ifndef AXISCAL_PROTO_CONVERT_TIME_H_
#define AXISCAL_PROTO_CONVERT_TIME_H_

#include <optional>

#include "core/base/clock.h"

namespace axiscal::convert {

// SET_OPTIONAL_UTC(message, closed_utc_us, record.closed_at) and its way back.
#define SET_OPTIONAL_UTC(message, field, time)                          \
  do {                                                                  \
    if (time) (message).set_##field(::axiscal::base::ToUtcUs(*(time))); \
  } while (false)
#define OPTIONAL_UTC(message, field) \
  ((message).has_##field() ? std::optional(::axiscal::base::FromUtcUs((message).field())) : std::nullopt)

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_TIME_H_
