#include "proto/convert/field.h"

#include <cmath>

#include "absl/strings/escaping.h"
#include "core/base/error_detail.h"
#include "core/base/utf8.h"
#include "core/records/access.h"

namespace axiscal::convert {

absl::Status FieldError(const std::string& field, const std::string& rule) {
  return base::Error(absl::StatusCode::kInvalidArgument, absl::StrCat(field, ": ", rule),
                     {"FIELD_INVALID", {{"field", field}, {"rule", rule}}});
}

absl::Status RequireFinite(const std::string& field, double value) {
  if (std::isfinite(value)) return absl::OkStatus();
  return FieldError(field, absl::StrCat(value, ", must be finite"));
}

absl::Status RequirePositive(const std::string& field, int64_t value) {
  if (value > 0) return absl::OkStatus();
  return FieldError(field, absl::StrCat(value, ", must be > 0"));
}

absl::Status RequireNotNegative(const std::string& field, int64_t value) {
  if (value >= 0) return absl::OkStatus();
  return FieldError(field, absl::StrCat(value, ", must be >= 0"));
}

absl::Status RequireText(const std::string& field, const std::string& text, size_t min, size_t max) {
  if (text.size() < min || text.size() > max) {
    return FieldError(field, absl::StrCat(text.size(), " bytes, must have ", min, " to ", max));
  }
  if (!base::IsUtf8(text)) return FieldError(field, "must be UTF-8");
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return FieldError(field, "must not hold control characters");
  }
  return absl::OkStatus();
}

absl::Status RequireSha256(const std::string& field, const std::string& text) {
  if (text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos) return absl::OkStatus();
  return FieldError(field, "must be 64 lower-case hexadecimal digits");
}

absl::Status RequireAccessName(const std::string& field, const std::string& name) {
  if (records::IsAccessName(name)) return absl::OkStatus();
  constexpr size_t kShown = 80;  // more than such a name may have
  const std::string shown = absl::Utf8SafeCEscape(name.substr(0, kShown)) + (name.size() > kShown ? "..." : "");
  return FieldError(field, absl::StrCat("'", shown,
                                        "', must be 1 to 64 letters, digits, '.', '_', '@', '-', with a letter or "
                                        "digit at both ends"));
}

absl::Status RequireAtMost(const std::string& field, int count, int max) {
  if (count <= max) return absl::OkStatus();
  return FieldError(field, absl::StrCat(count, " entries, must be at most ", max));
}

absl::Status RequireMessage(const std::string& field, bool present) {
  return present ? absl::OkStatus() : FieldError(field, "is missing");
}

absl::Status InField(const std::string& parent, const absl::Status& status) {
  std::optional<base::ErrorDetail> detail = base::GetErrorDetail(status);
  if (!detail || !detail->facts.count("field")) return status;
  const std::string field = absl::StrCat(parent, ".", detail->facts["field"]);
  return FieldError(field, detail->facts["rule"]);
}

}  // namespace axiscal::convert
