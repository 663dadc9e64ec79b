// Locks: std::mutex and std::condition_variable under names that clang's thread safety analysis knows. A member says
// which mutex guards it, a private function which its caller holds; clang refuses other code (tests/run, part "locks").
// https://clang.llvm.org/docs/ThreadSafetyAnalysis.html
//
//   Mutex mutex_;
//   CondVar changed_;
//   int waiting_ AXISCAL_GUARDED_BY(mutex_) = 0;
//   ...
//   const MutexLock lock(mutex_);
//   while (waiting_ > 0) changed_.Wait(mutex_);
//
// A condition is a loop in the function that holds the lock: the analysis does not look into a function object.
#ifndef AXISCAL_CORE_BASE_MUTEX_H_
#define AXISCAL_CORE_BASE_MUTEX_H_

#include <chrono>
#include <condition_variable>
#include <mutex>

#if defined(__clang__)
#define AXISCAL_LOCK_ATTRIBUTE(...) __attribute__((__VA_ARGS__))
#else
#define AXISCAL_LOCK_ATTRIBUTE(...)
#endif

// Of a member: read and written only while `mutex` is held.
#define AXISCAL_GUARDED_BY(mutex) AXISCAL_LOCK_ATTRIBUTE(guarded_by(mutex))
// Of a function: called only while the mutex is held, or only while it is not.
#define AXISCAL_REQUIRES(...) AXISCAL_LOCK_ATTRIBUTE(requires_capability(__VA_ARGS__))
#define AXISCAL_EXCLUDES(...) AXISCAL_LOCK_ATTRIBUTE(locks_excluded(__VA_ARGS__))

namespace axiscal::base {

class AXISCAL_LOCK_ATTRIBUTE(capability("mutex")) Mutex {
 public:
  Mutex() = default;
  Mutex(const Mutex&) = delete;
  Mutex& operator=(const Mutex&) = delete;

  void Lock() AXISCAL_LOCK_ATTRIBUTE(acquire_capability()) { mutex_.lock(); }
  void Unlock() AXISCAL_LOCK_ATTRIBUTE(release_capability()) { mutex_.unlock(); }

 private:
  friend class CondVar;
  std::mutex mutex_;
};

// Holds the mutex as long as it lives.
class AXISCAL_LOCK_ATTRIBUTE(scoped_lockable) MutexLock {
 public:
  explicit MutexLock(Mutex& mutex) AXISCAL_LOCK_ATTRIBUTE(acquire_capability(mutex)) : mutex_(mutex) { mutex_.Lock(); }
  ~MutexLock() AXISCAL_LOCK_ATTRIBUTE(release_capability()) { mutex_.Unlock(); }
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

 private:
  Mutex& mutex_;
};

// All waits return with the mutex held again, and may return early: the caller loops on its own condition.
class CondVar {
 public:
  CondVar() = default;
  CondVar(const CondVar&) = delete;
  CondVar& operator=(const CondVar&) = delete;

  void Wait(Mutex& mutex) AXISCAL_REQUIRES(mutex) {
    std::unique_lock<std::mutex> lock(mutex.mutex_, std::adopt_lock);
    changed_.wait(lock);
    lock.release();
  }
  // Until notified or `deadline` of any clock of <chrono>.
  template <typename Clock, typename Duration>
  void WaitUntil(Mutex& mutex, std::chrono::time_point<Clock, Duration> deadline) AXISCAL_REQUIRES(mutex) {
    std::unique_lock<std::mutex> lock(mutex.mutex_, std::adopt_lock);
    changed_.wait_until(lock, deadline);
    lock.release();
  }
  void NotifyAll() { changed_.notify_all(); }

 private:
  std::condition_variable changed_;
};

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_MUTEX_H_
