// What a form sends (multipart/form-data, RFC 7578): `curl -F log=@probe.log -F template=dprnt`.
#ifndef AXISCAL_SERVER_HTTP_MULTIPART_H_
#define AXISCAL_SERVER_HTTP_MULTIPART_H_

#include <map>
#include <string>

#include "core/base/status.h"

namespace axiscal::http {

struct FormPart {
  std::string text;  // byte for byte
  std::string file;  // the name of the file that it was, without folders; empty: it was none
};

// The parts by name. INVALID_ARGUMENT MESSAGE_INVALID: another type, no boundary, a part without a name or named twice,
// more than 16 of them, or no end: a body that was cut is no form.
absl::StatusOr<std::map<std::string, FormPart>> ReadMultipart(const std::string& content_type, const std::string& body);

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_MULTIPART_H_
