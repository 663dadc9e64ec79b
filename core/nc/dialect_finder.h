// For which control a program may have been written, from its words alone.
#ifndef AXISCAL_CORE_NC_DIALECT_FINDER_H_
#define AXISCAL_CORE_NC_DIALECT_FINDER_H_

#include <string>
#include <string_view>
#include <vector>

namespace axiscal::nc {

struct FittingDialects {
  // Names of Dialects() that read all blocks that any of them reads, in their order; never empty. Of dialects with one
  // table ("mazak" is read as "fanuc") the first stands for both.
  std::vector<std::string> names;
  // The block that tells them from the others: "line 3: 'G187 P3'"; "" where none does.
  std::string evidence;
};

// `program`: its begin, some thousand blocks or all of it. A dialect is left out where another one reads a block that
// it does not (a word or G code of a family's own), and all blocks that it does. Whether what is left would correct the
// program alike is for the caller to try: codes that all of them know can mean something else.
FittingDialects FindDialects(std::string_view program);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_DIALECT_FINDER_H_
