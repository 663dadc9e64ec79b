#include "server/http/pages.h"

#include <gmock/gmock.h>
#include <zlib.h>

#include <algorithm>

namespace axiscal::http {
namespace {

using ::testing::HasSubstr;

Request GetOf(const std::string& path, std::map<std::string, std::string> fields = {}) {
  Request request;
  request.method = "GET";
  request.path = path;
  request.fields = std::move(fields);
  return request;
}

std::string FieldOf(const Answer& answer, const std::string& name) {
  const auto found =
      std::find_if(answer.fields.begin(), answer.fields.end(), [&](const auto& field) { return field.first == name; });
  return found == answer.fields.end() ? "" : found->second;
}

std::string Unpacked(const std::string& gzipped, size_t size) {
  std::string bytes(size, '\0');
  z_stream stream = {};
  EXPECT_EQ(inflateInit2(&stream, 15 + 16), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(gzipped.data()));
  stream.avail_in = static_cast<uInt>(gzipped.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  inflateEnd(&stream);
  return bytes;
}

TEST(PagesTest, TheBundleIsThereAndSaysWhatMayRun) {
  const Pages pages(EmbeddedPages());
  for (const EmbeddedFile& file : EmbeddedPages()) {
    const std::string path = file.name == "index.html" ? "/" : "/" + file.name;
    ASSERT_TRUE(pages.Has(path)) << path;
    const Answer answer = pages.Get(GetOf(path));
    EXPECT_EQ(answer.status, 200);
    EXPECT_THAT(FieldOf(answer, "Content-Security-Policy"), HasSubstr("script-src 'self';")) << path;
    EXPECT_FALSE(answer.body.empty());
  }
  EXPECT_THAT(pages.Get(GetOf("/")).body, HasSubstr("<script type=\"module\" src=\"app.js\">"));
  // What the page names is there, under the names that this version's scripts have.
  const std::string page = pages.Get(GetOf("/")).body;
  int named = 0;
  for (const std::string before : {"href=\"", "src=\""}) {
    for (size_t at = page.find(before); at != std::string::npos; at = page.find(before, at + 1)) {
      const size_t begin = at + before.size();
      const std::string name = page.substr(begin, page.find('"', begin) - begin);
      if (name == "#/") continue;
      EXPECT_TRUE(pages.Has("/" + name)) << name;
      ++named;
    }
  }
  EXPECT_EQ(named, 5);  // the style, the icon, three scripts
  EXPECT_FALSE(pages.Has("/index.html"));
  EXPECT_FALSE(pages.Has("/../gateway.cc"));
}

TEST(PagesTest, GzipWhereItIsTakenWithATagOfItsOwn) {
  const std::string text(5000, 'a');
  const Pages pages(std::vector<EmbeddedFile>{{"app.js", text}});
  const Answer plain = pages.Get(GetOf("/app.js", {{"accept-encoding", "br, gzip;q=0"}}));
  const Answer packed = pages.Get(GetOf("/app.js", {{"accept-encoding", "deflate, GZIP;q=0.5"}}));
  EXPECT_EQ(plain.body, text);
  EXPECT_EQ(FieldOf(plain, "Content-Encoding"), "");
  EXPECT_EQ(FieldOf(packed, "Content-Encoding"), "gzip");
  EXPECT_EQ(Unpacked(packed.body, text.size()), text);
  EXPECT_NE(FieldOf(plain, "ETag"), FieldOf(packed, "ETag"));
}

TEST(PagesTest, WhatTheBrowserHasIsNotSentAgain) {
  const Pages pages(std::vector<EmbeddedFile>{{"index.html", "<p>old</p>"}});
  const std::string etag = FieldOf(pages.Get(GetOf("/")), "ETag");
  const Answer same = pages.Get(GetOf("/", {{"if-none-match", "\"x\", " + etag}}));
  EXPECT_EQ(same.status, 304);
  EXPECT_EQ(same.body, "");
  EXPECT_EQ(FieldOf(same, "ETag"), etag);
  const Pages others(std::vector<EmbeddedFile>{{"index.html", "<p>new</p>"}});
  EXPECT_EQ(others.Get(GetOf("/", {{"if-none-match", etag}})).status, 200);
}

TEST(PagesTest, PagesAreOnlyRead) {
  Request post = GetOf("/");
  post.method = "POST";
  const Answer answer = Pages(std::vector<EmbeddedFile>{{"index.html", "x"}}).Get(post);
  EXPECT_EQ(answer.status, 405);
  EXPECT_EQ(FieldOf(answer, "Allow"), "GET");
}

}  // namespace
}  // namespace axiscal::http
