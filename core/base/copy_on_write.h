// A value that copies share until one of them is changed: what is large and hardly ever changed is held once.
#ifndef AXISCAL_CORE_BASE_COPY_ON_WRITE_H_
#define AXISCAL_CORE_BASE_COPY_ON_WRITE_H_

#include <atomic>
#include <memory>
#include <utility>

namespace axiscal::base {

// Copies may be read and changed by different threads, one object by one at a time, as with a plain value.
template <typename T>
class CopyOnWrite {
 public:
  CopyOnWrite() = default;
  CopyOnWrite(T value) : value_(std::make_shared<T>(std::move(value))) {}

  const T& operator*() const { return value_ != nullptr ? *value_ : kEmpty; }
  const T* operator->() const { return &**this; }

  // To be changed: a copy of its own, where others share it. References from before may go on showing the old value.
  T& Own() {
    if (value_ == nullptr) {
      value_ = std::make_shared<T>();
    } else if (value_.use_count() > 1) {
      value_ = std::make_shared<T>(*value_);
    } else {
      std::atomic_thread_fence(std::memory_order_acquire);  // after the reads of who held it last
    }
    return *value_;
  }

 private:
  static inline const T kEmpty = {};
  std::shared_ptr<T> value_;
};

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_COPY_ON_WRITE_H_
