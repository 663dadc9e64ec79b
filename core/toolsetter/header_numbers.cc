#include "core/toolsetter/header_numbers.h"

#include "core/session/text.h"

namespace axiscal::toolsetter {

absl::StatusOr<std::vector<double>> HeaderList(const session::Session& session, const std::string& key,
                                               const std::string& expected) {
  const std::optional<std::string> text = session::FindHeader(session, key);
  std::vector<double> numbers;
  if (!text || (session::ParseNumbers(*text, &numbers) && !numbers.empty())) return numbers;
  return absl::InvalidArgumentError(absl::StrCat(key, ": ", session::Quoted(*text), ", expected ", expected));
}

absl::StatusOr<std::vector<double>> HeaderNumbers(const session::Session& session, const std::string& key, int count,
                                                  const std::string& expected) {
  ASSIGN_OR_RETURN(std::vector<double> numbers, HeaderList(session, key, expected));
  if (numbers.empty() || static_cast<int>(numbers.size()) == count) return numbers;
  return absl::InvalidArgumentError(
      absl::StrCat(key, ": ", session::Quoted(*session::FindHeader(session, key)), ", expected ", expected));
}

}  // namespace axiscal::toolsetter
