#include "client/cli/output_paths.h"

#include <filesystem>

namespace axiscal::cli {
namespace {

namespace fs = std::filesystem;

bool IsSameFile(const std::string& a, const std::string& b) {
  std::error_code error;
  if (fs::equivalent(a, b, error)) return true;  // hard links too
  const fs::path whole_a = fs::weakly_canonical(fs::absolute(a, error), error);
  return !whole_a.empty() && whole_a == fs::weakly_canonical(fs::absolute(b, error), error);
}

}  // namespace

absl::Status CheckOutputs(const std::vector<NamedPath>& inputs, const std::vector<NamedPath>& outputs) {
  std::vector<NamedPath> taken = inputs;
  for (const NamedPath& output : outputs) {
    if (output.second.empty()) continue;
    for (const auto& [name, path] : taken) {
      if (path.empty() || !IsSameFile(path, output.second)) continue;
      return absl::InvalidArgumentError(
          absl::StrCat(output.second, ": is ", name, " too, expected another file for ", output.first));
    }
    taken.push_back(output);
  }
  return absl::OkStatus();
}

}  // namespace axiscal::cli
