// Programs through the rewriter, as text, for tests.
#ifndef AXISCAL_CORE_NC_TESTING_REWRITTEN_H_
#define AXISCAL_CORE_NC_TESTING_REWRITTEN_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "core/base/crc32c.h"
#include "core/nc/dialect.h"
#include "core/nc/rewrite.h"
#include "core/nc/testing/yao.h"

namespace axiscal::nc::testing {

struct Outcome {
  absl::Status status;
  std::string text;  // without the mark's line
  RewriteReport report;
};

inline std::string MarkLine(const std::string& program, const std::string& line_end = "\n") {
  return absl::StrFormat("(AXISCAL COMPENSATED BY unnamed SOURCE CRC32C %08X)%s",
                         base::Crc32c(0, program.data(), program.size()), line_end);
}

inline Outcome Rewritten(const std::string& program, const RewriteOptions& options = InMm(),
                         const compensate::Compensator& compensator = LeaningHead()) {
  Outcome outcome;
  auto text = RewriteText(program, compensator, options, &outcome.report);
  outcome.status = text.status();
  if (!text.ok()) return outcome;
  outcome.text = *text;
  const std::string line_end = program.find("\r\n") != std::string::npos ? "\r\n" : "\n";
  std::string mark = MarkLine(program, line_end);
  if (!FindDialect(options.dialect)->has_parenthesis_comments) {
    mark[0] = ';';
    mark.erase(mark.find(')'), 1);
  }
  const size_t at = outcome.text.find(mark);
  EXPECT_NE(at, std::string::npos) << outcome.text;
  if (at != std::string::npos) outcome.text.erase(at, mark.size());
  return outcome;
}

// Moves are not split, so that one line gives one line.
inline RewriteOptions From(const std::vector<AxisValue>& position) {
  RewriteOptions options = InMm();
  options.tolerance_mm = std::numeric_limits<double>::infinity();
  options.initial_position = position;
  return options;
}
inline const RewriteOptions kAtZero = From({{"X", 0}, {"Y", 0}, {"Z", 0}, {"B", 0}, {"C", 0}});

}  // namespace axiscal::nc::testing

#define EXPECT_REWRITTEN(options, program, expected)                                                       \
  do {                                                                                                     \
    const ::axiscal::nc::testing::Outcome rewritten = ::axiscal::nc::testing::Rewritten(program, options); \
    EXPECT_TRUE(rewritten.status.ok()) << rewritten.status;                                                \
    EXPECT_EQ(rewritten.text, expected);                                                                   \
  } while (false)

#define EXPECT_REFUSED_BY(compensator, options, program, wanted)                                                      \
  do {                                                                                                                \
    const ::axiscal::nc::testing::Outcome refused = ::axiscal::nc::testing::Rewritten(program, options, compensator); \
    EXPECT_EQ(refused.status.code(), absl::StatusCode::kFailedPrecondition) << refused.text;                          \
    EXPECT_THAT(std::string(refused.status.message()), ::testing::HasSubstr(wanted));                                 \
  } while (false)

#define EXPECT_REFUSED(options, program, wanted) \
  EXPECT_REFUSED_BY(::axiscal::nc::testing::LeaningHead(), options, program, wanted)

#endif  // AXISCAL_CORE_NC_TESTING_REWRITTEN_H_
