// What a session file of each instrument holds (docs/formats.md, "Measuring session"), as data: one row per instrument.
// Readers, writers, uploads and checks all follow this table; the file of a new instrument is one more row.
#ifndef AXISCAL_CORE_SESSION_INSTRUMENT_FORMAT_H_
#define AXISCAL_CORE_SESSION_INSTRUMENT_FORMAT_H_

#include <limits>
#include <string>
#include <vector>

namespace axiscal::session {

// `count` numbers, each from `min` to `max`; 0 numbers: any text that is not empty.
struct HeaderRule {
  std::string key;
  int count = 0;
  double min = 0, max = 0;
  std::string expected;  // for messages: "three numbers in mm within +-100000"
};

// Keys of the form `PREFIX NAME`. Of all such keys of an instrument a session must have at least one.
struct FeatureRule {
  std::string prefix;
  int count = 0;
  std::string expected;
};

// What holds the cells of a column before the session is whole, where a session is made of a plan and a log
// (core/logs/reduce.h):
//   kPlan         known before anything is measured: the plan, or the log where it says it too
//   kReading      what the instrument measured: the log alone; empty or missing in a plan
//   kFromTouches  the log, or computed from the touches that it holds; empty or missing in a plan
enum class ColumnSource { kPlan, kReading, kFromTouches };

// A reading column: a number from `min` to `max`, or (is_name) the name of a feature or run.
struct ReadingColumn {
  std::string name;
  double min = 0, max = 0;
  std::string expected;
  bool is_name = false;
  bool may_be_empty = false;
  bool is_optional = false;  // the whole column
  ColumnSource source = ColumnSource::kReading;
};

// Which axes of the machine have a column: all of them, the rotary ones only, or those that the instrument's own
// columns name.
enum class AxisColumns { kAll, kRotaryOnly, kNone };

struct InstrumentFormat {
  std::string name;
  std::vector<HeaderRule> header;  // beyond the common keys
  std::vector<FeatureRule> features;
  std::vector<ReadingColumn> columns;
  AxisColumns axes = AxisColumns::kAll;
  bool has_time = true;  // readings are taken one after the other: t_s, where somebody recorded it
};

// Limits on what is read; beyond them lies another unit or another kind of file.
inline constexpr double kMaxLengthMm = 1e5;  // axis positions and points: 100 m
inline constexpr double kMaxAngleDeg = 1e6;  // a rotary axis may wind up
inline constexpr double kMaxTimeS = 1e11;
inline constexpr double kMaxDeviationMm = 10;  // a ball bar or R-test reads at most this: more is um in place of mm
inline constexpr double kMinBarLengthMm = 10;  // less is metres in place of mm
inline constexpr double kMaxBarLengthMm = 5000;
inline constexpr double kMaxPayloadKg = 1e5;  // a hundred tonnes on the table
inline constexpr double kMinTemperatureC = -80, kMaxTemperatureC = 200;

// Every known instrument.
const std::vector<InstrumentFormat>& InstrumentFormats();
// The row of `name`, or nullptr.
const InstrumentFormat* FindInstrumentFormat(const std::string& name);
// "ballbar, rtest, ...".
std::string InstrumentNames();
// Required of every session, in the order in which they are written.
const std::vector<HeaderRule>& CommonHeader();

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_INSTRUMENT_FORMAT_H_
