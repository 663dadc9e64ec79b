// A value that copies share until one of them is changed: what is large and hardly ever changed is held once.
#ifndef AXISCAL_CORE_BASE_COPY_ON_WRITE_H_
#define AXISCAL_CORE_BASE_COPY_ON_WRITE_H_

#include <atomic>
#include <cstdint>
#include <utility>

namespace axiscal::base {

// Copies may be read and changed by different threads, one object by one at a time, as with a plain value.
template <typename T>
class CopyOnWrite {
 public:
  CopyOnWrite() = default;
  CopyOnWrite(T value) : shared_(new Shared{std::move(value)}) {}
  CopyOnWrite(const CopyOnWrite& other) : shared_(other.shared_) {
    if (shared_ != nullptr) shared_->owners.fetch_add(1, std::memory_order_relaxed);
  }
  CopyOnWrite(CopyOnWrite&& other) noexcept : shared_(std::exchange(other.shared_, nullptr)) {}
  CopyOnWrite& operator=(CopyOnWrite other) noexcept {
    std::swap(shared_, other.shared_);
    return *this;
  }
  ~CopyOnWrite() {
    if (shared_ != nullptr && shared_->owners.fetch_sub(1, std::memory_order_acq_rel) == 1) delete shared_;
  }

  const T& operator*() const { return shared_ != nullptr ? shared_->value : kEmpty; }
  const T* operator->() const { return &**this; }

  // To be changed: a copy of its own, where others share it. References from before may go on showing the old value.
  T& Own() {
    if (shared_ == nullptr) {
      shared_ = new Shared{T()};
    } else if (shared_->owners.load(std::memory_order_acquire) > 1) {  // else after all reads of who held it last
      *this = CopyOnWrite(T(shared_->value));
    }
    return shared_->value;
  }

 private:
  // Not a std::shared_ptr: its use_count() does not say that the others' reads are over.
  struct Shared {
    T value;
    std::atomic<int64_t> owners = 1;
  };
  static inline const T kEmpty = {};
  Shared* shared_ = nullptr;
};

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_COPY_ON_WRITE_H_
