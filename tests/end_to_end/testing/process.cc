#include "tests/end_to_end/testing/process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>

namespace axiscal::testing {
namespace {

// Starts a program with its output on a pipe; returns the pipe's end to read.
int Spawn(const std::vector<std::string>& arguments, const std::string& error_path, pid_t* pid,
          int max_descriptors = 0) {
  int ends[2];
  if (pipe(ends) != 0) return -1;
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  *pid = fork();
  if (*pid == 0) {
    dup2(ends[1], STDOUT_FILENO);
    if (!error_path.empty()) {
      const int error = open(error_path.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
      dup2(error, STDERR_FILENO);
    }
    close(ends[0]);
    const rlimit limit = {static_cast<rlim_t>(max_descriptors), static_cast<rlim_t>(max_descriptors)};
    if (max_descriptors > 0 && setrlimit(RLIMIT_NOFILE, &limit) != 0) _exit(126);
    execv(argv[0], argv.data());
    _exit(127);
  }
  close(ends[1]);
  return ends[0];
}

std::string ReadUntil(int fd, char last) {
  std::string text;
  for (char c; read(fd, &c, 1) == 1;) {
    if (c == last) return text;
    text += c;
  }
  return text;
}

int ExitStatus(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

}  // namespace

absl::StatusOr<ServerProcess> ServerProcess::Start(const std::string& database_path, const std::string& listen,
                                                   const std::string& log_path, const std::vector<std::string>& more,
                                                   int max_descriptors) {
  std::vector<std::string> arguments = {AXISCALD_PATH, "--db", database_path, "--listen", listen};
  arguments.insert(arguments.end(), more.begin(), more.end());
  ServerProcess process;
  const int out = Spawn(arguments, log_path, &process.pid_, max_descriptors);
  const std::string line = ReadUntil(out, '\n');
  close(out);
  const std::string start = "axiscald listens on ";
  if (line.rfind(start, 0) != 0) return absl::InternalError("axiscald said '" + line + "', see " + log_path);
  process.address_ = line.substr(start.size());
  return process;
}

ServerProcess::ServerProcess(ServerProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, 0)), address_(std::move(other.address_)) {}

ServerProcess::~ServerProcess() {
  if (pid_ == 0) return;
  Signal(SIGKILL);
  Wait();
}

int64_t ServerProcess::Status(const std::string& name) const {
  std::ifstream status(absl::StrCat("/proc/", pid_, "/status"));
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(name + ":", 0) == 0) return std::stoll(line.substr(name.size() + 1));
  }
  return -1;
}

int64_t ServerProcess::PeakMemoryBytes() const { return Status("VmHWM") * 1024; }
int64_t ServerProcess::MemoryBytes() const { return Status("VmRSS") * 1024; }
int64_t ServerProcess::ThreadCount() const { return Status("Threads"); }

int64_t ServerProcess::DescriptorCount() const {
  const std::filesystem::directory_iterator all(absl::StrCat("/proc/", pid_, "/fd"));
  return std::distance(begin(all), end(all));
}

double ServerProcess::CpuSeconds() const {
  std::ifstream file(absl::StrCat("/proc/", pid_, "/stat"));
  std::string stat;
  std::getline(file, stat);
  // Behind the name, which may hold blanks, and ten more numbers: utime and stime in ticks.
  std::istringstream words(stat.substr(stat.rfind(')') + 1));
  std::string skipped;
  for (int i = 0; i < 11; ++i) words >> skipped;
  int64_t user = 0, system = 0;
  words >> user >> system;
  return static_cast<double>(user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

void ServerProcess::Signal(int signal) { kill(pid_, signal); }

int ServerProcess::Wait() {
  int status = 0;
  waitpid(std::exchange(pid_, 0), &status, 0);
  return ExitStatus(status);
}

Child::Child(const std::vector<std::string>& arguments, const std::string& error_path)
    : out_(Spawn(arguments, error_path, &pid_)) {}

Child::~Child() {
  Kill();
  close(out_);
}

std::optional<std::string> Child::ReadLine() {
  while (true) {
    const size_t end = read_.find('\n');
    if (end != std::string::npos) {
      std::string line = read_.substr(0, end);
      read_.erase(0, end + 1);
      return line;
    }
    char bytes[4096];
    const ssize_t count = read(out_, bytes, sizeof(bytes));
    if (count <= 0) return std::nullopt;
    read_.append(bytes, static_cast<size_t>(count));
  }
}

void Child::Kill() {
  if (pid_ == 0) return;
  kill(pid_, SIGKILL);
  waitpid(std::exchange(pid_, 0), nullptr, 0);
}

int RunProgram(const std::vector<std::string>& arguments, std::string* output) {
  pid_t pid = 0;
  const int out = Spawn(arguments, "", &pid);
  *output = ReadUntil(out, '\0');
  close(out);
  int status = 0;
  waitpid(pid, &status, 0);
  return ExitStatus(status);
}

}  // namespace axiscal::testing
