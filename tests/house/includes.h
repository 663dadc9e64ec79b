// Which file of the tree includes what, for the tests that hold the walls between its rooms. Paths are from the
// checkout's root, as includes write them: "core/base/ids.h".
#ifndef AXISCAL_TESTS_HOUSE_INCLUDES_H_
#define AXISCAL_TESTS_HOUSE_INCLUDES_H_

#include <functional>
#include <string>
#include <vector>

namespace axiscal::house {

struct Include {
  int line = 0;            // 1, 2, ...
  std::string path;        // as written: "core/base/ids.h", "vector"
  bool is_quoted = false;  // "ours" instead of <theirs>

  bool operator==(const Include&) const = default;
};

struct SourceFile {
  std::string path;
  std::vector<Include> includes;
};

// The includes of a C++ text, in order; lines that are commented out by // do not count.
std::vector<Include> IncludesOf(const std::string& text);

// All .h and .cc files below the folders ("core", "server/jobs"), in order of path. Fails the running test when a
// folder is not there or holds none: a rule about nothing would hold for ever.
std::vector<SourceFile> FilesBelow(const std::vector<std::string>& folders);

// One line for each include that breaks a rule: `server/jobs/a.cc:7: includes "server/handlers/b.h"`.
std::vector<std::string> Breaches(const std::vector<SourceFile>& files,
                                  const std::function<bool(const SourceFile& file, const Include& include)>& is_breach);

// Whether a path lies below a folder: IsBelow("core/base/ids.h", "core").
bool IsBelow(const std::string& path, const std::string& folder);

// All that a file includes, directly and through files of the checkout: one entry for each path, in the order in which
// they are met first. Generated headers and those of libraries are met and not read.
struct Reached {
  std::string path;
  bool is_quoted = false;
  std::vector<std::string> by;  // the way there: "client/client.h", "core/base/status.h"
};
std::vector<Reached> ReachedFrom(const std::string& path);

// "client/client.h > core/base/status.h > absl/status/status.h".
std::string WayTo(const Reached& reached);

}  // namespace axiscal::house

#endif  // AXISCAL_TESTS_HOUSE_INCLUDES_H_
