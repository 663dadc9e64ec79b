#include "core/base/testing/source_path.h"

namespace axiscal::base {

std::string SourcePath(std::string_view name) { return AXISCAL_SOURCE_DIR + std::string(name); }

}  // namespace axiscal::base
