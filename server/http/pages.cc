#include "server/http/pages.h"

#include <zlib.h>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "core/base/demand.h"
#include "core/base/sha256.h"

namespace axiscal::http {
namespace {

// Scripts, styles and pictures come from here alone and none stands within a page, but pictures that the page's own
// script has made of what the server drew (blob:), in which nothing runs; nothing is sent elsewhere; nobody frames a
// page; and no text becomes HTML (trusted types).
constexpr char kPolicy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
    "base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'; trusted-types 'none'";

std::string TypeOf(const std::string& name) {
  static const std::map<std::string, std::string> kTypes = {{"html", "text/html; charset=utf-8"},
                                                            {"js", "text/javascript; charset=utf-8"},
                                                            {"css", "text/css; charset=utf-8"},
                                                            {"svg", "image/svg+xml"}};
  const auto found = kTypes.find(name.substr(name.rfind('.') + 1));
  DEMAND(found != kTypes.end());
  return found->second;
}

std::string Gzip(const std::string& bytes) {
  constexpr int kGzipWindow = 15 + 16;  // the largest window; 16 more asks zlib for gzip's frame
  constexpr int kMostMemory = 9;
  z_stream stream = {};
  DEMAND(deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kGzipWindow, kMostMemory, Z_DEFAULT_STRATEGY) == Z_OK);
  std::string packed(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  DEMAND(deflate(&stream, Z_FINISH) == Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

// Whether a list like "gzip, br;q=0.5" has the word, not refused by a weight of 0.
bool TakesGzip(const std::string& list) {
  for (const std::string& entry : Words(absl::AsciiStrToLower(list), ',')) {
    const std::vector<std::string> parts = Words(entry, ';');
    if (parts[0] != "gzip") continue;
    return parts.size() < 2 || parts[1].find_first_not_of("q=0.") != std::string::npos;
  }
  return false;
}

}  // namespace

Pages::Pages(const std::vector<EmbeddedFile>& files) {
  for (const EmbeddedFile& file : files) {
    Page page;
    page.type = TypeOf(file.name);
    page.bytes = std::string(file.bytes);
    page.gzipped = Gzip(page.bytes);
    page.etag = base::Sha256Hex(page.bytes);
    pages_[file.name == "index.html" ? "/" : "/" + file.name] = std::move(page);
  }
}

Answer Pages::Get(const Request& request) const {
  const Page& page = pages_.at(request.path);
  if (request.method != "GET") return {405, {{"Allow", "GET"}}, ""};
  const bool is_packed = TakesGzip(request.Field("accept-encoding"));
  // What is sent is another text when it is compressed, so it has another tag (RFC 9110, section 8.8.3.3).
  const std::string etag = absl::StrCat("\"", page.etag, is_packed ? "-gzip" : "", "\"");
  Fields fields = {{"ETag", etag},
                   {"Cache-Control", "no-cache"},
                   {"Vary", "Accept-Encoding"},
                   {"Content-Security-Policy", kPolicy},
                   {"Cross-Origin-Opener-Policy", "same-origin"},
                   {"Cross-Origin-Resource-Policy", "same-origin"},
                   {"Referrer-Policy", "no-referrer"}};
  for (const std::string& known : Words(request.Field("if-none-match"), ',')) {
    if (known == etag || known == "W/" + etag) return {304, fields, ""};
  }
  fields.emplace_back("Content-Type", page.type);
  if (is_packed) fields.emplace_back("Content-Encoding", "gzip");
  return {200, fields, is_packed ? page.gzipped : page.bytes};
}

}  // namespace axiscal::http
