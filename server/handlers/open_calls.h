// The calls that are open now. Whoever is revoked, or loses the role that a call needs, is cut off in its midst.
#ifndef AXISCAL_SERVER_HANDLERS_OPEN_CALLS_H_
#define AXISCAL_SERVER_HANDLERS_OPEN_CALLS_H_

#include <functional>
#include <memory>
#include <set>

#include "core/base/mutex.h"
#include "core/base/status.h"

namespace axiscal::handlers {

class OpenCalls {
 public:
  // What is asked again, and how the call is ended from another thread. `check` may be asked after the call has ended,
  // `cut_off` not.
  struct Entry {
    std::function<absl::Status()> check;
    std::function<void()> cut_off;
  };
  // While it lives, the call is open.
  class Place {
   public:
    Place(OpenCalls& calls, Entry entry);
    ~Place();
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

   private:
    OpenCalls& calls_;
    const std::shared_ptr<const Entry> entry_;
  };

  // Asks all again and cuts off those that are refused now (NOT_FOUND, PERMISSION_DENIED, UNAUTHENTICATED); how many.
  int CutOffRefused();

 private:
  base::Mutex mutex_;
  std::set<std::shared_ptr<const Entry>> entries_ AXISCAL_GUARDED_BY(mutex_);
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_OPEN_CALLS_H_
