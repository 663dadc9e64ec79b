#include "core/nc/moves_ahead.h"

#include <utility>

namespace axiscal::nc {

MovesAhead::MovesAhead(const ByteReader& reader, Interpreter interpreter)
    : moves_(reader, std::move(interpreter)), thread_([this] { Read(); }) {}

MovesAhead::~MovesAhead() {
  {
    const base::MutexLock lock(mutex_);
    is_abandoned_ = true;
  }
  changed_.NotifyAll();
  thread_.join();
}

void MovesAhead::Read() {
  Batch batch;
  while (!batch.is_last) {
    batch.status = moves_.NextSome(&batch.events, &batch.count);
    batch.is_last = !batch.status.ok() || batch.count == 0;
    if (batch.is_last) batch.count = 0;
    const bool is_last = batch.is_last;
    bool was_empty = false;
    {
      const base::MutexLock lock(mutex_);
      while (full_.size() >= kMostBatches && !is_abandoned_) changed_.Wait(mutex_);
      if (is_abandoned_) return;
      was_empty = full_.empty();
      full_.push_back(std::move(batch));
      batch = {};
      if (!used_.empty()) {
        batch = std::move(used_.front());
        used_.pop_front();
      }
    }
    if (was_empty) changed_.NotifyAll();
    if (is_last) return;
  }
}

absl::StatusOr<bool> MovesAhead::Next(Event* event) {
  while (next_ == now_.count) {
    if (now_.is_last) {
      RETURN_IF_ERROR(now_.status);
      return false;
    }
    bool has_room = false;  // so much that the other thread is worth waking
    {
      const base::MutexLock lock(mutex_);
      if (!now_.events.empty()) used_.push_back(std::move(now_));
      while (full_.empty()) changed_.Wait(mutex_);
      now_ = std::move(full_.front());
      full_.pop_front();
      has_room = full_.size() <= kMostBatches / 2;
    }
    if (has_room) changed_.NotifyAll();
    next_ = 0;
  }
  *event = std::move(now_.events[next_++]);
  return true;
}

}  // namespace axiscal::nc
