#include "core/loop/pictures.h"

#include <gtest/gtest.h>

#include <cctype>
#include <map>
#include <set>

#include "core/decide/close_loop.h"
#include "core/identify/testing/scenario.h"

namespace axiscal::loop {
namespace {

// Tags balance, attributes are quoted, entities are XML's own: what a browser needs to show it. Empty, or what is
// wrong.
std::string XmlError(const std::string& xml) {
  std::vector<std::string> open;
  for (size_t at = 0; at < xml.size();) {
    if (xml[at] == '&') {
      const size_t end = xml.find(';', at);
      const std::string entity = end == std::string::npos ? "" : xml.substr(at, end - at + 1);
      if (!std::set<std::string>{"&lt;", "&gt;", "&amp;", "&quot;"}.count(entity)) return "entity " + xml.substr(at, 8);
    }
    if (xml[at] != '<') {
      ++at;
      continue;
    }
    const size_t end = xml.find('>', at);
    if (end == std::string::npos) return "a tag without end";
    const std::string tag = xml.substr(at + 1, end - at - 1);
    at = end + 1;
    if (tag[0] == '?') continue;
    if (std::count(tag.begin(), tag.end(), '"') % 2 != 0) return "a quote is open in " + tag;
    const std::string name = tag.substr(tag[0] == '/', tag.find_first_of(" /", 1) - (tag[0] == '/'));
    if (tag[0] == '/') {
      if (open.empty() || open.back() != tag.substr(1)) return "</" + tag.substr(1) + "> closes nothing";
      open.pop_back();
    } else if (tag.back() != '/') {
      open.push_back(name);
    }
  }
  return open.empty() ? "" : open.back() + " is open";
}

TEST(Pictures, ShowEveryVariableTheTracesAndTheRanking) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const machine::ErrorModel truth = identify::testing::Errors(
      machine, R"({"EZ0T": 30, "terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": 6}]})");
  ballbar::PatternOptions options;
  options.step_deg = 3.0;
  const auto sessions = identify::testing::Measure(
      machine, truth, {}, {{"BX", ballbar::Pattern::kBX, 356.4}, {"C/R <1>", ballbar::Pattern::kCR, 356.4}}, options);
  const auto check_sessions =
      identify::testing::Measure(machine, truth, {.seed = 5, .setup_seed = {}, .stated_seed = {}},
                                 {{"BX", ballbar::Pattern::kBX, 356.4}}, options);
  const auto fit = *identify::BindSessions(machine, sessions);
  const auto check = *identify::BindSessions(machine, check_sessions);
  const Report report = decide::CloseLoop(machine, fit, check).value();

  ASSERT_EQ(report.residuals.size(), 3u);
  EXPECT_TRUE(report.residuals[2].is_check);
  double squares = 0.0, count = 0.0;
  for (size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(report.residuals[i].after_mm.cols(), fit[i].reading_count());
    squares += report.residuals[i].before_mm.squaredNorm();
    count += static_cast<double>(report.residuals[i].before_mm.size());
  }
  EXPECT_NEAR(std::sqrt(squares / count), report.fit_before.rms_mm, 1e-12);
  EXPECT_LT(report.residuals[0].after_mm.norm(), 0.5 * report.residuals[0].before_mm.norm());

  const std::vector<Picture> pictures = Pictures(machine, fit, check, report);
  std::set<std::string> files;
  for (const Picture& picture : pictures) {
    EXPECT_EQ(XmlError(picture.svg), "") << picture.file;
    EXPECT_LT(picture.svg.size(), 200000u) << picture.file;
    EXPECT_TRUE(files.insert(picture.file).second) << picture.file;
    // What is shown is at hand as numbers, but for the ranking.
    EXPECT_EQ(picture.panels.empty(), picture.file == "ranking.svg") << picture.file;
    for (const plot::Panel& panel : picture.panels) EXPECT_FALSE(panel.series.empty()) << picture.file;
  }
  for (const char* file : {"residual-X.svg", "residual-B.svg", "residual-time.svg", "spectrum-C.svg", "trace-BX.svg",
                           "trace-C-R--1-.svg", "trace-check-BX.svg", "ranking.svg"}) {
    EXPECT_TRUE(files.count(file)) << file;
  }
  EXPECT_FALSE(files.count("residual-temperature.svg"));  // nothing varies
  const std::vector<Picture> again = Pictures(machine, fit, check, report);
  ASSERT_EQ(again.size(), pictures.size());
  for (size_t i = 0; i < again.size(); ++i) EXPECT_EQ(again[i].svg, pictures[i].svg);
  // In German the same files, without a word of English.
  const std::vector<Picture> german = Pictures(machine, fit, check, report, base::Language::kGerman);
  ASSERT_EQ(german.size(), pictures.size());
  for (size_t i = 0; i < german.size(); ++i) {
    EXPECT_EQ(german[i].file, pictures[i].file);
    if (german[i].panels.empty()) continue;
    for (const char* word : {"before", "after", "measured", "predicted", "rms", " over ", "order", "time,", "deg"})
      EXPECT_EQ(german[i].svg.find(word), std::string::npos) << german[i].file << " holds '" << word << "'";
  }
}

// What was found stands in a curve and its spectrum; backlash lies between the two senses of motion.
TEST(Pictures, ShowWhatWasFoundAlongAnAxis) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const machine::ErrorModel found = identify::testing::Errors(machine, R"({"EZ0T": 30, "terms": [
      {"symbol": "EXX", "shape": "backlash", "amplitude": 6},
      {"symbol": "EBC", "shape": "harmonic", "order": 3, "amplitude": 20, "phase_deg": 40}]})");
  const auto sessions = identify::testing::Measure(machine, found, {}, {{"CR", ballbar::Pattern::kCR, 356.4}});
  const auto runs = *identify::BindSessions(machine, sessions);
  Report report;
  report.fitted.model = found;
  for (const instruments::MeasuringRun& run : runs) {
    const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(run.row_count, run.reading_count());
    report.residuals.push_back({run.session, false, zero, zero});
  }
  std::map<std::string, Picture> pictures;
  for (const Picture& picture : Pictures(machine, runs, {}, report)) {
    EXPECT_EQ(XmlError(picture.svg), "") << picture.file;
    pictures[picture.file] = picture;
  }
  // X goes there and back.
  ASSERT_TRUE(pictures.count("residual-X.svg"));
  const std::vector<plot::Series>& readings = pictures["residual-X.svg"].panels[0].series;
  ASSERT_EQ(readings.size(), 2u);
  EXPECT_EQ(readings[0].name, "CR +");
  EXPECT_EQ(readings[1].name, "CR -");
  EXPECT_EQ(readings[0].points.size() + readings[1].points.size(), static_cast<size_t>(runs[0].reading_count()));

  ASSERT_TRUE(pictures.count("found-EXX-X.svg"));
  EXPECT_EQ(pictures["found-EXX-X.svg"].y_label, "EXX, um");
  const std::vector<plot::Series>& backlash = pictures["found-EXX-X.svg"].panels[0].series;
  ASSERT_EQ(backlash.size(), 2u);
  EXPECT_NEAR(std::abs(backlash[0].points[10].y - backlash[1].points[10].y), 6.0, 1e-9);

  ASSERT_TRUE(pictures.count("found-EBC-C.svg"));
  EXPECT_EQ(pictures["found-EBC-C.svg"].y_label, "EBC, urad");
  ASSERT_EQ(pictures["found-EBC-C.svg"].panels[0].series.size(), 1u);
  ASSERT_TRUE(pictures.count("orders-EBC-C.svg"));
  for (const plot::Point& order : pictures["orders-EBC-C.svg"].panels[0].series[0].points)
    EXPECT_NEAR(order.y, order.x == 3.0 ? 20.0 : 0.0, 1e-6) << order.x;
}

TEST(Pictures, SessionsWhoseNamesDifferByOneSignHaveTheirOwn) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const auto sessions =
      identify::testing::Measure(machine, identify::testing::Errors(machine, R"({"EZ0T": 30})"), {},
                                 {{"B/1", ballbar::Pattern::kBX, 356.4}, {"B-1", ballbar::Pattern::kBY, 356.4}});
  const auto fit = *identify::BindSessions(machine, sessions);
  std::set<std::string> files;
  for (const Picture& picture : Pictures(machine, fit, {}, decide::CloseLoop(machine, fit, {}).value()))
    EXPECT_TRUE(files.insert(picture.file).second) << picture.file;
  EXPECT_TRUE(files.count("trace-B-1.svg") && files.count("trace-B-1-2.svg"));
}

TEST(Pictures, TheXmlCheckRefusesWhatIsNoXml) {
  EXPECT_EQ(XmlError("<a><b/></a>"), "");
  EXPECT_NE(XmlError("<a><b></a>"), "");
  EXPECT_NE(XmlError("<a x=\"1></a>"), "");
  EXPECT_NE(XmlError("<a>&nbsp;</a>"), "");
}

}  // namespace
}  // namespace axiscal::loop
