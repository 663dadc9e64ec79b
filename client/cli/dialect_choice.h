// Which control a program was written for, where --dialect does not say it.
#ifndef AXISCAL_CLIENT_CLI_DIALECT_CHOICE_H_
#define AXISCAL_CLIENT_CLI_DIALECT_CHOICE_H_

#include <functional>
#include <string>

#include "core/base/status.h"

namespace axiscal::cli {

struct DialectChoice {
  std::string name;
  std::string why;  // for the output: "haas, found by line 3: 'G187 P3'"
  bool is_stated = false;
};

// What a program gives in a dialect: bytes that are equal only where nothing differs, or why it is refused.
using DialectTrial = std::function<absl::StatusOr<std::string>(const std::string& dialect)>;

// `stated`: --dialect, or the machine's profile (`source` names which). Where it is empty the program's words are asked
// (nc::FindDialects, first 4 MB); where several dialects read them, each is tried, and the first is taken where all
// give the same or all refuse. INVALID_ARGUMENT with their names where they differ; other errors than refusals of
// `trial`.
absl::StatusOr<DialectChoice> ChooseDialect(const std::string& stated, const std::string& source,
                                            const std::string& program_path, const DialectTrial& trial);

// An error of the work in the chosen dialect: says which it was, where it was not stated.
absl::Status WithDialect(const DialectChoice& choice, const absl::Status& status);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_DIALECT_CHOICE_H_
