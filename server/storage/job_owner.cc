#include "server/storage/job_owner.h"

#include <unistd.h>

#include <array>
#include <fstream>
#include <random>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "core/base/sha256.h"

namespace axiscal::storage {
namespace {

std::string FirstWord(const char* path) {
  std::ifstream file(path);
  std::string word;
  file >> word;
  return word;
}

// machine-id(5) is nothing to hand around: what others see is made of it. A container may have none, but a name.
std::string Machine() {
  std::string id = FirstWord("/etc/machine-id");
  if (id.empty()) {
    std::array<char, 256> name{};
    if (gethostname(name.data(), name.size() - 1) != 0) return "";
    id = name.data();
  }
  constexpr int kDigits = 16;
  return base::Sha256Hex("axiscal " + id).substr(0, kDigits);
}

}  // namespace

std::string NewOwnerId() {
  std::random_device random;
  const std::string id = absl::StrFormat("%08x%08x%08x", random(), random(), random());
  const std::string machine = Machine();
  // Without the hyphens that are in it.
  const std::string boot = absl::StrJoin(absl::StrSplit(FirstWord("/proc/sys/kernel/random/boot_id"), '-'), "");
  return machine.empty() || boot.empty() ? id : absl::StrCat(id, "-", machine, "-", boot);
}

bool IsOfEarlierBoot(const std::string& owner, const std::string& self) {
  const std::vector<std::string> was = absl::StrSplit(owner, '-'), is = absl::StrSplit(self, '-');
  return was.size() == 3 && is.size() == 3 && was[1] == is[1] && was[2] != is[2];
}

}  // namespace axiscal::storage
