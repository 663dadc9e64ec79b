// The pages that a browser shows: the bundle of client/web, which is part of the program, so that pages and API are
// always of one version and nothing has to be installed beside it. They hold no data and are given to anyone; what they
// show comes from the API, with its roles.
#ifndef AXISCAL_SERVER_HTTP_PAGES_H_
#define AXISCAL_SERVER_HTTP_PAGES_H_

#include <map>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "server/http/exchange.h"

namespace axiscal::http {

struct EmbeddedFile {
  std::string name;  // "app.js"
  absl::string_view bytes;
};

// Of client/web/dist (cmake/EmbedPages.cmake).
std::vector<EmbeddedFile> EmbeddedPages();

// Safe from any thread.
class Pages {
 public:
  // Ends the program at a file of unknown type. "index.html" has the path "/", others "/NAME".
  explicit Pages(const std::vector<EmbeddedFile>& files);

  bool Has(const std::string& path) const { return pages_.count(path) > 0; }
  // The answer to GET of a path that it has: 200, or 304 where `If-None-Match` names what is there; 405 to other
  // methods. Compressed where `Accept-Encoding` has gzip.
  Answer Get(const Request& request) const;

 private:
  struct Page {
    std::string type, etag;
    std::string bytes, gzipped;
  };
  std::map<std::string, Page> pages_;
};

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_PAGES_H_
