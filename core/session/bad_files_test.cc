// Files that must be refused, each with the place and the rule in its message.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/session/line_reader.h"
#include "core/session/read_session.h"
#include "core/session/testing/example.h"

namespace axiscal::session {
namespace {

using ::testing::HasSubstr;
using testing::kBallbar;
using testing::kTouch;
using testing::Replaced;
using ::testing::StartsWith;

std::string Problem(const std::string& text) {
  const auto session = ReadSessionText(text, "fit/a.csv");
  EXPECT_EQ(session.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(session.status().message());
}

struct BadFile {
  const char* from;
  const char* to;
  const char* message;  // behind "fit/a.csv: "
};

class BadBallbar : public ::testing::TestWithParam<BadFile> {};
class BadTouch : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadBallbar, IsRefusedWithPlaceAndRule) {
  EXPECT_THAT(Problem(Replaced(kBallbar, GetParam().from, GetParam().to)),
              StartsWith(std::string("fit/a.csv: ") + GetParam().message));
}

TEST_P(BadTouch, IsRefusedWithPlaceAndRule) {
  EXPECT_THAT(Problem(Replaced(kTouch, GetParam().from, GetParam().to)),
              StartsWith(std::string("fit/a.csv: ") + GetParam().message));
}

// Each row changes one thing of kBallbar: its header is lines 1 to 8, the names line 9, the readings lines 10 to 12.
INSTANTIATE_TEST_SUITE_P(
    Header, BadBallbar,
    ::testing::Values(
        BadFile{"# machine: mt\n", "", "line 8: header key machine is missing, every session needs '# machine: ...'"},
        BadFile{"# machine: mt\n", "# machine:\n", "line 1: machine: '', expected a text of 1 to 100 bytes"},
        BadFile{"# session: BX\n", "", "line 8: header key session is missing"},
        BadFile{"# instrument: ballbar\n", "", "line 8: header key instrument is missing"},
        BadFile{"instrument: ballbar", "instrument: ballbars",
                "line 3: instrument: 'ballbars', expected one of ballbar, tracker, rtest, touch, centres"},
        BadFile{"# sigma_um: 0.3\n", "", "line 8: header key sigma_um is missing"},
        BadFile{"sigma_um: 0.3", "sigma_um: 0",
                "line 4: sigma_um: '0', expected one number in um from 1e-06 to 100000"},
        BadFile{"# sigma_um: 0.3\n", "# sigma_um: 0.3\n# datum: X Z\n",
                "line 5: datum: 'X Z', expected 'free' and the linear axes whose work offset was set anew: free X Z"},
        BadFile{"# sigma_um: 0.3\n", "# sigma_um: 0.3\n# datum: free\n", "line 5: datum: 'free', expected 'free' and"},
        BadFile{"# sigma_um: 0.3\n", "# sigma_um: 0.3\n# datum: free X,Z\n",
                "line 5: datum: 'free X,Z', expected 'free' and"},
        BadFile{"# sigma_um: 0.3\n", "# sigma_um: 0.3\n# datum: free X X\n",
                "line 5: datum: 'free X X': axis X is there twice, expected once"},
        BadFile{"sigma_um: 0.3", "sigma_um: -1", "line 4: sigma_um: '-1', expected one number in um"},
        BadFile{"sigma_um: 0.3", "sigma_um: 0,3", "line 4: sigma_um: '0,3', expected one number in um"},
        BadFile{"sigma_um: 0.3", "sigma_um: nan", "line 4: sigma_um: 'nan', expected one number in um"},
        BadFile{"tool_tip_mm: 0 0 -356.4", "tool_tip_mm: 0 -356.4",
                "line 5: tool_tip_mm: '0 -356.4', expected three numbers in mm"},
        BadFile{"tool_tip_mm: 0 0 -356.4", "tool_tip_mm: 0 0 -356400",
                "line 5: tool_tip_mm: '0 0 -356400', expected three numbers in mm"},
        BadFile{"# table_ball_mm: 0 0 65.5\n", "",
                "line 8: header key table_ball_mm is missing, instrument ballbar needs"},
        BadFile{"bar_length_mm: 100", "bar_length_mm: 0.1",
                "line 7: bar_length_mm: '0.1', expected a length in mm from 10 to 5000"},
        BadFile{"# operator: night shift", "# sigma_um: 0.4",
                "line 8: sigma_um: stands in line 4 already, expected once"},
        BadFile{"# operator: night shift", "# operator", "line 8: '# operator', expected '# key: value'"},
        BadFile{"# operator: night shift", "# : night shift", "line 8: '# : night shift', expected '# key: value'"},
        BadFile{"# operator: night shift", "# operator: caf\xE9",
                "line 8: '# operator: caf\\xE9', expected '# key: value' in UTF-8"},
        BadFile{"# operator: night shift", "# started: yesterday",
                "line 8: started: 'yesterday', expected a date and time of ISO 8601"},
        BadFile{"# operator: night shift", "# started: 2026-13-45T99:00:00",
                "line 8: started: '2026-13-45T99:00:00', expected a date and time of ISO 8601"},
        BadFile{"# operator: night shift", "# started: 2026-02-31T14:03:00Z",
                "line 8: started: '2026-02-31T14:03:00Z', expected a date and time"},
        BadFile{"# operator: night shift", "# payload_kg: -1",
                "line 8: payload_kg: '-1', expected one mass in kg from 0"},
        BadFile{"# operator: night shift", "# payload_kg: 10 kg",
                "line 8: payload_kg: '10 kg', expected one mass in kg"},
        BadFile{"# operator: night shift", "# gravity: 0 0 -9.81",
                "line 8: gravity: '0 0 -9.81', expected the direction"},
        BadFile{"# operator: night shift", "# gravity: 0 -1 -1", "line 8: gravity: '0 -1 -1', expected the direction"},
        BadFile{"# operator: night shift", "", "line 8, column 1 (no name): unknown column for instrument ballbar"}));

INSTANTIATE_TEST_SUITE_P(
    Columns, BadBallbar,
    ::testing::Values(
        BadFile{"t_s,", "", "line 10, column 8: the line has 8 cells, expected 7"},
        BadFile{"temp_C", "T_2nd_C", "line 9, column 7 (T_2nd_C): unknown column"},
        BadFile{"temp_C", "T_spindle_K", "line 9, column 7 (T_spindle_K): unknown column"},
        BadFile{"temp_C", "Z_enc_deg,Z_enc_mm", "line 9, column 8 (Z_enc_mm): the same encoder as column 7"},
        BadFile{"temp_C", "Z_sense,Z_sense", "line 9, column 8 (Z_sense): the same sense as column 7"},
        BadFile{"temp_C", "Z_sense", "line 10, column 7 (Z_sense): '20.000', expected 1 or -1, or 0"},
        BadFile{",dL_mm", "", "line 9: column dL_mm is missing, instrument ballbar needs it"},
        BadFile{"Y_mm", "Y_cm",
                "line 9, column 3 (Y_cm): unknown column for instrument ballbar, expected t_s, axis columns"},
        BadFile{"Y_mm", "y_mm", "line 9, column 3 (y_mm): unknown column"},
        BadFile{"Y_mm", " Y_mm", "line 9, column 3 ( Y_mm): unknown column"},
        BadFile{"Y_mm", "X_mm", "line 9, column 3 (X_mm): the same axis as column 2, expected once"},
        BadFile{"Y_mm", "X_deg", "line 9, column 3 (X_deg): the same axis as column 2, expected once"},
        BadFile{"temp_C", "t_s", "line 9, column 7 (t_s): the same name as column 1, expected once"},
        BadFile{"temp_C,dL_mm", "temp_C,dL_mm,dL_mm", "line 9, column 9 (dL_mm): the same name as column 8"},
        BadFile{"t_s,X_mm,Y_mm,Z_mm,B_deg,C_deg,temp_C,dL_mm", "t_s;X_mm;dL_mm",
                "line 9, column 1 (t_s;X_mm;dL_mm): unknown column for instrument ballbar, expected names separated by "
                "commas"},
        BadFile{"t_s,X_mm,Y_mm,Z_mm,B_deg,C_deg,temp_C,dL_mm\n", "", "line 9, column 1 (0.000): unknown column"}));

INSTANTIATE_TEST_SUITE_P(
    Cells, BadBallbar,
    ::testing::Values(
        BadFile{"103.1101", "103,1101",
                "line 11, column 9: the line has 9 cells, expected 8 (is there a decimal comma?)"},
        BadFile{"103.1101,", "", "line 11, column 8 (dL_mm): the line has 7 cells, expected 8"},
        BadFile{"103.1101", "", "line 11, column 2 (X_mm): is empty, expected mm from -100000 to 100000"},
        BadFile{"103.1101", "nan", "line 11, column 2 (X_mm): 'nan', expected mm from"},
        BadFile{"103.1101", "inf", "line 11, column 2 (X_mm): 'inf', expected mm from"},
        BadFile{"103.1101", "1e400", "line 11, column 2 (X_mm): '1e400' is no number"},
        BadFile{"103.1101", "103.11.01", "line 11, column 2 (X_mm): '103.11.01' is no number, expected mm from"},
        BadFile{"103.1101", " 103.1101", "line 11, column 2 (X_mm): ' 103.1101' is no number"},
        BadFile{"103.1101", "0x67", "line 11, column 2 (X_mm): '0x67' is no number"},
        BadFile{"103.1101", "\"103.1\"", "line 11, column 2 (X_mm): '\"103.1\"' is no number"},
        BadFile{"103.1101", "103110.1", "line 11, column 2 (X_mm): '103110.1', expected mm from -100000 to 100000"},
        BadFile{"0.0182", "18.2", "line 11, column 8 (dL_mm): '18.2', expected mm within +-10 (are these um?)"},
        BadFile{"20.000,0.0182", "293.15,0.0182",
                "line 11, column 7 (temp_C): '293.15', expected deg C from -80 to 200"},
        BadFile{"0.500,", "0.249,",
                "line 12, column 1 (t_s): '0.249', expected at least 0.25, the time of the line before"},
        BadFile{"0.250,103", "\n0.250,103", "line 11, column 2 (X_mm): the line has 1 (empty) cell, expected 8"},
        BadFile{"0.250,103", "# note: late\n0.250,103", "line 11, column 2 (X_mm): the line has 1 cells, expected 8"},
        BadFile{"-0.0181\n", "-0.0181\n\n", "line 13, column 2 (X_mm): the line has 1 (empty) cell, expected 8"},
        BadFile{"-0.0181\n", "-0.0181",
                "line 12: '0.500,106.2200,0.0000,421.8457,1.0000,0....' is the last line and has no line end"},
        BadFile{",0.0000,20.000,-0.0181\n", "",
                "line 12: '0.500,106.2200,0.0000,421.8457,1.0000' is the last line and has no line end"},
        BadFile{"0.0182", "0.0182,", "line 11, column 9: the line has 9 cells, expected 8"}));

INSTANTIATE_TEST_SUITE_P(
    Features, BadTouch,
    ::testing::Values(
        BadFile{"# stylus_radius_mm: 3\n", "",
                "line 8: header key stylus_radius_mm is missing, instrument touch needs"},
        BadFile{"0 0 50 12.7", "0 0 50", "line 7: sphere ball: '0 0 50', expected x y z radius in mm"},
        BadFile{"# plane top", "# sphere ball", "line 8: sphere ball: stands in line 7 already"},
        BadFile{"0,0,-1,top", "0,0,-1,side",
                "line 10, column 7 (feature): 'side', expected a name that the header describes, such as 'ball'"},
        BadFile{"0,0,-1,top", "0,0,-1,", "line 10, column 7 (feature): '', expected a name of 1 to 100 bytes"},
        BadFile{"0,0,-1,top", "0,0,-1.5,top",
                "line 10, column 6 (nz): '-1.5', expected a component of a unit vector within +-1"}));

TEST(BadFiles, WithoutReadings) {
  const std::string text = kBallbar;
  EXPECT_EQ(Problem(""), "fit/a.csv: the file is empty, expected header lines '# key: value'");
  EXPECT_EQ(Problem("\xEF\xBB\xBF"), "fit/a.csv: the file is empty, expected header lines '# key: value'");
  EXPECT_EQ(Problem(text.substr(0, text.find("t_s"))),
            "fit/a.csv: line 9: the file ends after its header lines, expected a line of column names");
  EXPECT_EQ(Problem(text.substr(0, text.find("0.000,"))),
            "fit/a.csv: line 9: no readings follow the column names, expected at least one");
  EXPECT_THAT(Problem(text.substr(text.find("t_s"))), StartsWith("fit/a.csv: line 1: 't_s,X_mm"));
}

TEST(BadFiles, EveryCutOfAFileIsRefused) {
  const std::string text = kBallbar;
  const size_t first_reading_end = text.find('\n', text.find("0.000,")) + 1;
  for (size_t length = 0; length < text.size(); ++length) {
    // A file that ends behind a whole reading cannot be told from a short run.
    const bool whole_lines = length >= first_reading_end && text[length - 1] == '\n';
    EXPECT_EQ(ReadSessionText(text.substr(0, length), "a").ok(), whole_lines) << length;
  }
}

TEST(BadFiles, OtherLineEndsAndEncodings) {
  std::string old_mac = kBallbar;
  for (char& c : old_mac) c = c == '\n' ? '\r' : c;
  EXPECT_THAT(Problem(old_mac + "\n"), StartsWith("fit/a.csv: line 1: '# machine: mt\\x0D# session"));
  std::string utf16 = "\xFF\xFE";
  for (const char c : std::string(kBallbar)) utf16 += std::string({c, '\0'});
  EXPECT_THAT(Problem(utf16), HasSubstr("a NUL byte at byte 3: this is no text file"));
  EXPECT_THAT(Problem(Replaced(kBallbar, "mt", std::string("m\0t", 3))), HasSubstr("a NUL byte at byte 12"));
  EXPECT_THAT(Problem("PK\x03\x04 not a session\n"),
              StartsWith("fit/a.csv: line 1: 'PK\\x03\\x04 not a session', expected header lines"));
}

// A stream that never ends: memory must not grow with it.
class Endless : public std::streambuf {
 public:
  explicit Endless(std::string start, std::string repeated) : start_(std::move(start)), repeated_(std::move(repeated)) {
    setg(start_.data(), start_.data(), start_.data() + start_.size());
  }
  int_type underflow() override {
    setg(repeated_.data(), repeated_.data(), repeated_.data() + repeated_.size());
    return traits_type::to_int_type(repeated_[0]);
  }

 private:
  std::string start_, repeated_;
};

TEST(BadFiles, AnEndlessLineIsRefused) {
  Endless buffer("# note: ", std::string(4096, 'x'));
  std::istream in(&buffer);
  EXPECT_EQ(std::string(ReadSession(in, "a").status().message()),
            "a: line 1: longer than 65536 bytes, this is no session file");
}

TEST(BadFiles, AnEndlessStreamIsRefusedAtTheSizeLimit) {
  Endless buffer(kBallbar, std::string(1000, '\n'));
  std::istream in(&buffer);
  EXPECT_THAT(std::string(ReadSession(in, "a").status().message()), StartsWith("a: line 13, column 2"));
  Endless headers("# machine: mt\n", "# note: one more\n");
  std::istream header_in(&headers);
  EXPECT_EQ(std::string(ReadSession(header_in, "a").status().message()), "a: line 1001: more than 1000 header lines");
  Endless lines("", std::string(1000, '\n') + std::string(60000, 'x') + '\n');
  std::istream lines_in(&lines);
  LineReader reader(lines_in);
  Line line;
  absl::StatusOr<bool> more = true;
  while (more.ok() && *more) more = reader.Next(&line);
  EXPECT_THAT(std::string(more.status().message()), StartsWith("more than 268435456 bytes (256 MB)"));
}

}  // namespace
}  // namespace axiscal::session
