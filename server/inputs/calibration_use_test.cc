#include "server/inputs/calibration_use.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/reports/calibration.h"
#include "core/reports/identification.h"

namespace axiscal::inputs {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

records::CalibrationRecord Measured(const std::vector<reports::AxisRange>& ranges) {
  reports::Identification report;
  report.fitted.measured = ranges;
  records::CalibrationRecord calibration;
  calibration.id = CalibrationId(16);
  calibration.content.report_json = reports::ToJson(report);
  return calibration;
}

std::string NoteOf(const std::vector<reports::AxisRange>& measured, const std::vector<reports::AxisRange>& gone) {
  const std::optional<nc::Remark> note = NoteOnUnmeasured(Measured(measured), gone);
  EXPECT_TRUE(!note || note->kind == "not-measured-there");
  return note ? note->text : "";
}

TEST(NoteOnUnmeasured, NamesEachAxisWithBothRanges) {
  const std::vector<reports::AxisRange> measured = {{"X", -50.0, 450.0, "mm"}, {"Z", 65.0, 515.0, "mm"}};
  EXPECT_EQ(NoteOf(measured, {{"X", 0.0, 400.0, "mm"}, {"Z", 70.0, 515.0, "mm"}}), "");
  EXPECT_EQ(
      NoteOf(measured, {{"X", -390.0, -300.0, "mm"}, {"Z", 70.0, 515.0, "mm"}}),
      "the program goes where calibration 16 was not measured: X from -390 to -300 mm (measured: -50 to 450). How "
      "right the correction is there is not known");
  EXPECT_THAT(NoteOf(measured, {{"X", 0.0, 501.0, "mm"}, {"Z", 19.0, 20.0, "mm"}}),
              AllOf(HasSubstr("X from 0 to 501"), HasSubstr("Z from 19 to 20")));
  // A tenth of the span beside it is as good as measured.
  EXPECT_EQ(NoteOf(measured, {{"X", -99.0, 499.0, "mm"}}), "");
  // An axis that stood still was measured where it stood.
  EXPECT_EQ(NoteOf({{"Y", 0.0, 0.0, "mm"}}, {{"Y", -1.0, 0.9, "mm"}}), "");
  EXPECT_THAT(NoteOf({{"Y", 0.0, 0.0, "mm"}}, {{"Y", -1.0, 1.1, "mm"}}), HasSubstr("Y from -1 to 1.1 mm"));
}

TEST(NoteOnUnmeasured, ARotaryAxisIsThereOnEveryTurn) {
  EXPECT_EQ(NoteOf({{"C", 0.0, 360.0, "deg"}}, {{"C", -90.0, 3600.0, "deg"}}), "");
  EXPECT_EQ(NoteOf({{"C", 0.0, 90.0, "deg"}}, {{"C", 370.0, 440.0, "deg"}}), "");
  EXPECT_THAT(NoteOf({{"C", 0.0, 90.0, "deg"}}, {{"C", 370.0, 480.0, "deg"}}), HasSubstr("C from 370 to 480 deg"));
  EXPECT_THAT(NoteOf({{"B", 0.0, 90.0, "deg"}}, {{"B", -30.0, 0.0, "deg"}}), HasSubstr("B from -30 to 0 deg"));
}

TEST(NoteOnUnmeasured, OfAReportThatDoesNotSayItNothingIsSaid) {
  EXPECT_EQ(NoteOf({}, {{"X", -390.0, -300.0, "mm"}}), "");
  records::CalibrationRecord unread = Measured({});
  unread.content.report_json = "no report";
  EXPECT_FALSE(NoteOnUnmeasured(unread, {{"X", -390.0, -300.0, "mm"}}).has_value());
}

}  // namespace
}  // namespace axiscal::inputs
