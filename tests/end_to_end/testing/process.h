// The server as a process of its own, to be stopped and killed.
#ifndef AXISCAL_TESTS_END_TO_END_TESTING_PROCESS_H_
#define AXISCAL_TESTS_END_TO_END_TESTING_PROCESS_H_

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"

namespace axiscal::testing {

// axiscald on a free port of 127.0.0.1. Killed when the test forgets it.
class ServerProcess {
 public:
  // Returns when it listens. `more` are further flags; its log goes to `log_path`. `max_descriptors`, unless 0, is the
  // limit of its open files and connections, soft and hard.
  static absl::StatusOr<ServerProcess> Start(const std::string& database_path, const std::string& listen,
                                             const std::string& log_path, const std::vector<std::string>& more = {},
                                             int max_descriptors = 0);
  ServerProcess(ServerProcess&& other) noexcept;
  ServerProcess& operator=(ServerProcess&&) = delete;
  ~ServerProcess();

  const std::string& address() const { return address_; }
  void Signal(int signal);
  // The most that it ever had in memory, and what it has now.
  int64_t PeakMemoryBytes() const;
  int64_t MemoryBytes() const;
  int64_t ThreadCount() const;
  int64_t DescriptorCount() const;
  // What all its threads have computed until now.
  double CpuSeconds() const;
  // Waits for its end: the exit status, or 128 + the signal that ended it.
  int Wait();

 private:
  ServerProcess() = default;
  int64_t Status(const std::string& name) const;  // of /proc/PID/status
  pid_t pid_ = 0;
  std::string address_;
};

// A program whose lines are read while it runs. Killed when the test forgets it.
class Child {
 public:
  // What it says to standard error goes to `error_path`.
  Child(const std::vector<std::string>& arguments, const std::string& error_path);
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  // The next line without its end, waited for; nothing when it has ended. A line that it did not end is none.
  std::optional<std::string> ReadLine();
  // kill -9. What it has written before can still be read.
  void Kill();

 private:
  pid_t pid_ = 0;
  int out_ = -1;
  std::string read_;
};

// Runs a program to its end; its exit status, and what it printed.
int RunProgram(const std::vector<std::string>& arguments, std::string* output);

}  // namespace axiscal::testing

#endif  // AXISCAL_TESTS_END_TO_END_TESTING_PROCESS_H_
