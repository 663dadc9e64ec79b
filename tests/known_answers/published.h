// A published number and ours, compared and recorded in one place: what docs/validation.md is made of.
#ifndef AXISCAL_TESTS_KNOWN_ANSWERS_PUBLISHED_H_
#define AXISCAL_TESTS_KNOWN_ANSWERS_PUBLISHED_H_

#include <absl/strings/str_format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace axiscal::known_answers {

// `quantity` is "SOURCE: WHAT, UNIT", once per test; all numbers are in that unit. They become a property of the test
// in GoogleTest's report (--gtest_output=json), from which tests/validation/run takes them.
inline void RecordPublished(double ours, double published, const std::string& quantity, const std::string& rule) {
  testing::Test::RecordProperty("published " + quantity, absl::StrFormat("%.10g|%.10g|%s", published, ours, rule));
}

inline void ExpectPublished(double ours, double published, double tolerance, const std::string& quantity) {
  EXPECT_NEAR(ours, published, tolerance) << quantity;
  RecordPublished(ours, published, quantity, absl::StrFormat("within %.3g", tolerance));
}

// What is to be no larger: a mean error.
inline void ExpectAtMost(double ours, double published, const std::string& quantity) {
  EXPECT_LE(ours, published) << quantity;
  RecordPublished(ours, published, quantity, "at most");
}

// The same of many numbers of one table, as a row: how many, and the one that is farthest off.
class PublishedTable {
 public:
  PublishedTable(const std::string& quantity, double tolerance) : quantity_(quantity), tolerance_(tolerance) {}
  ~PublishedTable() {
    ExpectPublished(ours_, published_, tolerance_, absl::StrFormat("%s (worst of %d)", quantity_, count_));
  }
  PublishedTable(const PublishedTable&) = delete;
  PublishedTable& operator=(const PublishedTable&) = delete;

  void Add(double ours, double published) {
    if (count_++ > 0 && std::abs(ours - published) <= std::abs(ours_ - published_)) return;
    ours_ = ours;
    published_ = published;
  }

 private:
  const std::string quantity_;
  const double tolerance_;
  double ours_ = 0.0, published_ = 0.0;
  int count_ = 0;
};

}  // namespace axiscal::known_answers

#endif  // AXISCAL_TESTS_KNOWN_ANSWERS_PUBLISHED_H_
