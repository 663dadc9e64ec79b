// Names of files in comments and documents: what a reader will want to open must be there.
#ifndef AXISCAL_TESTS_HOUSE_CITATIONS_H_
#define AXISCAL_TESTS_HOUSE_CITATIONS_H_

#include <functional>
#include <string>
#include <vector>

namespace axiscal::house {

struct Citation {
  int line = 0;      // 1, 2, ...
  std::string name;  // as written: "docs/formats.md", "dialect_*.cc", "server.{h,cc}"

  bool operator==(const Citation&) const = default;
};

// The text with all that is no comment blanked out, line for line. C++ and .proto: what follows //, outside of strings.
std::string CommentsOf(const std::string& source);
// The same of build files: what follows #.
std::string HashCommentsOf(const std::string& source);

// The names of files and folders of the checkout that `text` mentions: words that end in .md, .h, .cc, .proto, .sql or
// .cmake, paths that begin with a folder of the checkout's root ("core/plan", "tests/bench/run"), and targets of links.
std::vector<Citation> CitationsIn(const std::string& text);

// Whether a name written in the file `from` is there: as seen from the folder of `from` or from one of those above it.
// {a,b} stands for a and b, which must both be there. `exists` is asked for paths from the root, in which * stands for
// any characters but /.
bool IsThere(const std::string& name, const std::string& from,
             const std::function<bool(const std::string& pattern)>& exists);

// Whether `path` fits `pattern`, in which * stands for any characters but /.
bool Fits(const std::string& path, const std::string& pattern);

}  // namespace axiscal::house

#endif  // AXISCAL_TESTS_HOUSE_CITATIONS_H_
