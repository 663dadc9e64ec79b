#include "client/cli/dialect_choice.h"

#include <fstream>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/base/files.h"
#include "core/nc/dialect_finder.h"

namespace axiscal::cli {
namespace {

constexpr size_t kMostBytes = size_t{4} << 20;

std::string Listed(const std::vector<std::string>& names, size_t first, const std::string& last) {
  std::string text;
  for (size_t i = first; i < names.size(); ++i)
    absl::StrAppend(&text, i == first ? "" : i + 1 == names.size() ? " " + last + " " : ", ", names[i]);
  return text;
}

bool IsRefusal(const absl::Status& status) {
  return absl::IsFailedPrecondition(status) || absl::IsInvalidArgument(status);
}

// The first line of a refusal.
std::string Short(const absl::Status& status) {
  const std::string text(status.message());
  return text.substr(0, text.find('\n'));
}

}  // namespace

absl::StatusOr<DialectChoice> ChooseDialect(const std::string& stated, const std::string& source,
                                            const std::string& program_path, const DialectTrial& trial) {
  if (!stated.empty()) return DialectChoice{stated, absl::StrCat(stated, ", as ", source, " says"), true};
  RETURN_IF_ERROR(base::RequireFile(program_path));  // reading a pipe would wait
  std::string begin(kMostBytes, '\0');
  std::ifstream file(program_path, std::ios::binary);
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<size_t>(file.gcount()));
  if (begin.size() == kMostBytes) begin.resize(begin.rfind('\n') + 1);
  const nc::FittingDialects fit = nc::FindDialects(begin);
  const std::string found = fit.evidence.empty() ? "" : ", found by " + fit.evidence;
  if (fit.names.size() == 1) return DialectChoice{fit.names[0], fit.names[0] + found};
  std::vector<absl::StatusOr<std::string>> given;
  size_t refused = 0;
  bool are_alike = true;
  for (const std::string& name : fit.names) {
    given.push_back(trial(name));
    if (!given.back().ok() && !IsRefusal(given.back().status())) return given.back().status();
    refused += !given.back().ok();
    are_alike = are_alike && given.back().ok() && *given.back() == *given.front();
  }
  if (are_alike) {
    const std::string others = Listed(fit.names, 1, "and");
    return DialectChoice{fit.names[0], absl::StrCat(fit.names[0], found, "; the same program as for ", others)};
  }
  if (refused == fit.names.size()) {
    return DialectChoice{fit.names[0],
                         absl::StrCat(fit.names[0], found, "; refused too as ", Listed(fit.names, 1, "and"))};
  }
  std::string results;
  for (size_t i = 0; i < fit.names.size(); ++i) {
    absl::StrAppend(&results, "\n  ", fit.names[i], ": ",
                    given[i].ok() ? "corrected" : "refused, " + Short(given[i].status()));
  }
  return absl::InvalidArgumentError(absl::StrCat("--dialect: ", program_path, " fits ", Listed(fit.names, 0, "and"),
                                                 ", which take it differently: state --dialect ",
                                                 Listed(fit.names, 0, "or"), results));
}

absl::Status WithDialect(const DialectChoice& choice, const absl::Status& status) {
  if (status.ok() || choice.is_stated) return status;
  absl::Status told(status.code(), absl::StrCat(std::string(status.message()), "\n  read as ", choice.why,
                                                "; state --dialect if it is for another control"));
  status.ForEachPayload([&told](const auto& type, const absl::Cord& payload) { told.SetPayload(type, payload); });
  return told;
}

}  // namespace axiscal::cli
