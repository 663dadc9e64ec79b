// Ends what goes on for callers who have lost the right to it while it goes on, and writes who was denied something.
#ifndef AXISCAL_SERVER_RIGHTS_WATCH_H_
#define AXISCAL_SERVER_RIGHTS_WATCH_H_

#include <chrono>

#include "server/denials.h"
#include "server/handlers/core.h"
#include "server/rounds.h"

namespace axiscal::server {

class RightsWatch {
 public:
  // Open calls and jobs are asked again `again` after the last time. What is referred to outlives this.
  RightsWatch(handlers::Core& core, Denials& denials, std::chrono::milliseconds again)
      : core_(core), denials_(denials), again_(again) {}

  void Start();
  void Stop() { rounds_.Stop(); }
  // What has been denied so far into the audit; with `all` also what is gathered to be written later.
  void WriteDenials(bool all);

 private:
  void AskAgain();
  // Jobs whose creators may no longer create them.
  void CancelRefusedJobs();
  void CancelIfRefused(const records::JobRecord& job);

  handlers::Core& core_;
  Denials& denials_;
  const std::chrono::milliseconds again_;
  Rounds rounds_;
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_RIGHTS_WATCH_H_
