// What a plant does in the tests of faults, each step once however often it runs, and what is looked at afterwards.
#ifndef AXISCAL_TESTS_FAULTS_TESTING_WORK_H_
#define AXISCAL_TESTS_FAULTS_TESTING_WORK_H_

#include <sys/types.h>

#include <functional>
#include <memory>
#include <set>
#include <string>

#include "server/storage/sqlite_database.h"

namespace axiscal::storage {

// AXISCAL_FAULTS=long: every operation, a thousand kills (tests/long); else some of them.
bool IsLong();

// What was answered with OK, by name.
using Told = std::set<std::string>;
using Tell = std::function<void(const std::string&)>;

// Nothing where it does not open.
std::unique_ptr<Database> OpenAt(const std::string& path, base::Clock& clock = base::SystemClock());

inline const Caller kAnn = {"ann", ""};

// Opens the file and does everything that a plant does: a machine, principals, one of whom is revoked, a mark,
// sessions, a program, jobs, a calibration, its approval and its table, removal by age, a backup in PATH.copy. Goes on
// after what fails, as callers do who do not know of each other.
void Work(const std::string& path, const Tell& tell, base::Clock& clock = base::SystemClock());

// A dump of a file of the first schema, in use: its migration may be cut in half.
std::string OldDump();
// The file as it was before: none, or what `dump` makes; without what stands beside it.
void Clear(const std::string& path, const std::string& dump);

// Of all runs of one kind.
struct Sum {
  int64_t moments = 0, faults = 0, lost = 0, damaged = 0;
  int64_t last = 0;  // the first moment that no operation reached
};
// A line of the table that tests/long keeps.
void PrintRow(const std::string& fault, const std::string& name, const std::string& moments, const Sum& sum);

// Everything that happens after one fault: the file opens and has what was told, once; the work can be done to its end;
// the file is whole. `what` begins what a failure says.
void LookAfter(const std::string& path, const Told& told, const std::string& what, Sum& sum);

// The work in a process of its own, to which `harm` is done; `prepare` runs in it before. Whether it was killed.
Told WorkApart(const std::string& path, const std::function<void()>& prepare, const std::function<void(pid_t)>& harm,
               bool* was_killed);

}  // namespace axiscal::storage

#endif  // AXISCAL_TESTS_FAULTS_TESTING_WORK_H_
