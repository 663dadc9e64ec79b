// A MoveReader that reads ahead on a thread of its own, so that two programs are read while their moves are compared.
// What it gives, and its errors, are the reader's, in its order; at most kMostBatches pieces of text of a few kB
// (MoveReader::NextSome) wait.
#ifndef AXISCAL_CORE_NC_MOVES_AHEAD_H_
#define AXISCAL_CORE_NC_MOVES_AHEAD_H_

#include <cstddef>
#include <deque>
#include <thread>
#include <vector>

#include "core/base/mutex.h"
#include "core/base/status.h"
#include "core/nc/move_reader.h"

namespace axiscal::nc {

class MovesAhead {
 public:
  // `reader` is called on the other thread, and must outlive this.
  MovesAhead(const ByteReader& reader, Interpreter interpreter);
  ~MovesAhead();
  MovesAhead(const MovesAhead&) = delete;
  MovesAhead& operator=(const MovesAhead&) = delete;

  // False at the end of the program. Errors of the reader.
  absl::StatusOr<bool> Next(Event* event);

 private:
  static constexpr size_t kMostBatches = 8;
  struct Batch {
    std::vector<Event> events;
    size_t count = 0;
    absl::Status status;  // of what comes behind `events`
    bool is_last = false;
  };
  void Read();

  MoveReader moves_;
  base::Mutex mutex_;
  base::CondVar changed_;
  std::deque<Batch> full_ AXISCAL_GUARDED_BY(mutex_), used_ AXISCAL_GUARDED_BY(mutex_);  // events of `used_` are spare
  bool is_abandoned_ AXISCAL_GUARDED_BY(mutex_) = false;
  Batch now_;        // of Next alone
  size_t next_ = 0;  // likewise
  std::thread thread_;
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_MOVES_AHEAD_H_
