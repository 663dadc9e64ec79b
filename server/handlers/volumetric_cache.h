// Volumetric errors that were computed already.
#ifndef AXISCAL_SERVER_HANDLERS_VOLUMETRIC_CACHE_H_
#define AXISCAL_SERVER_HANDLERS_VOLUMETRIC_CACHE_H_

#include <deque>
#include <map>
#include <optional>
#include <string>

#include "axiscal/v1/volumetric.pb.h"
#include "core/base/mutex.h"

namespace axiscal::handlers {

// By what was asked: a calibration's content never changes, and whoever shows a history
// asks for the same again. Safe from any thread.
class VolumetricCache {
 public:
  std::optional<v1::VolumetricError> Find(const std::string& key);
  void Keep(const std::string& key, const v1::VolumetricError& error);

 private:
  base::Mutex mutex_;
  std::map<std::string, v1::VolumetricError> kept_ AXISCAL_GUARDED_BY(mutex_);
  std::deque<std::string> order_ AXISCAL_GUARDED_BY(mutex_);  // the oldest first
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_VOLUMETRIC_CACHE_H_
