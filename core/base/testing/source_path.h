// Where the checkout stands, for tests that read data from it. Tests whose data is not there skip.
#ifndef AXISCAL_CORE_BASE_TESTING_SOURCE_PATH_H_
#define AXISCAL_CORE_BASE_TESTING_SOURCE_PATH_H_

#include <string>
#include <string_view>

namespace axiscal::base {

// The path of `name` ("/tests/data/nc") in the checkout. Only source_path.cc is compiled with the checkout's own path,
// so that a compiler cache serves every other test of a second checkout.
std::string SourcePath(std::string_view name);

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_TESTING_SOURCE_PATH_H_
