#include "server/http/multipart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"

namespace axiscal::http {
namespace {

constexpr char kType[] = "multipart/form-data; boundary=----x7";

std::string Part(const std::string& head, const std::string& text) {
  return "------x7\r\nContent-Disposition: form-data; " + head + "\r\n\r\n" + text + "\r\n";
}

TEST(ReadMultipart, GivesPartsByteForByte) {
  const std::string bytes("a\r\n--\r\n-----x7\0b\r\n", 18);
  const auto form = ReadMultipart(
      kType, Part("name=\"log\"; filename=\"C:\\\\logs\\\\a \\\"b\\\".log\"\r\nContent-Type: text/plain", bytes) +
                 Part("name=template", "dprnt") + Part("name=\"plan\"; filename=\"p;q.csv\"", "") + "------x7--\r\n");
  ASSERT_TRUE(form.ok()) << form.status();
  ASSERT_EQ(form->size(), 3u);
  EXPECT_EQ(form->at("log").text, bytes);
  EXPECT_EQ(form->at("log").file, "a \"b\".log");
  EXPECT_EQ(form->at("template").text, "dprnt");
  EXPECT_EQ(form->at("template").file, "");
  EXPECT_EQ(form->at("plan").text, "");
  EXPECT_EQ(form->at("plan").file, "p;q.csv");
}

TEST(ReadMultipart, RefusesWhatIsNoForm) {
  const std::string log = Part("name=log", "X1"), end = "------x7--\r\n";
  const auto refused = [](const std::string& type, const std::string& body) {
    const auto form = ReadMultipart(type, body);
    EXPECT_EQ(base::ErrorReason(form.status()), "MESSAGE_INVALID") << body;
    return std::string(form.status().message());
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(refused("text/plain", log + end), HasSubstr("Content-Type is 'text/plain'"));
  EXPECT_THAT(refused("", log + end), HasSubstr("Content-Type"));
  EXPECT_THAT(refused("multipart/form-data", log + end), HasSubstr("no boundary"));
  EXPECT_THAT(refused(kType, ""), HasSubstr("does not begin"));
  EXPECT_THAT(refused(kType, log), HasSubstr("no end"));
  const std::string whole = log + end;
  for (size_t cut = 1; cut < whole.size() - 3; ++cut) refused(kType, whole.substr(0, cut));
  EXPECT_THAT(refused(kType, log + log + end), HasSubstr("'log' twice"));
  EXPECT_THAT(refused(kType, Part("nme=log", "X1") + end), HasSubstr("without a name"));
  std::string many;
  for (int i = 0; i < 17; ++i) many += Part("name=p" + std::to_string(i), "");
  EXPECT_THAT(refused(kType, many + end), HasSubstr("more than 16"));
}

}  // namespace
}  // namespace axiscal::http
