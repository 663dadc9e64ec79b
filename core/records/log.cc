#include "core/records/log.h"

#include "core/base/sha256.h"
#include "core/base/status.h"

namespace axiscal::records {

std::string LogId(const std::string& machine, const std::string& name, const LogForm& form, const std::string& sha256) {
  base::Sha256 sha;
  // Every text with its length before it, so that no two logs give the same bytes.
  const std::string start = form.start_s ? absl::StrFormat("%.17g", *form.start_s) : "";
  for (const std::string& text : {std::string("log"), machine, name, form.template_text, form.template_name,
                                  form.plan_text, form.plan_name, form.session, start, sha256})
    sha.Add(absl::StrCat(text.size(), ":", text));
  return sha.HexDigest();
}

}  // namespace axiscal::records
