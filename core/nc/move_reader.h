// Reads a program and gives its moves one by one, in constant memory.
#ifndef AXISCAL_CORE_NC_MOVE_READER_H_
#define AXISCAL_CORE_NC_MOVE_READER_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/nc/calls.h"
#include "core/nc/corners.h"
#include "core/nc/interpreter.h"
#include "core/nc/line_splitter.h"
#include "core/nc/preamble.h"

namespace axiscal::nc {

// Fills up to `size` bytes and returns their number; 0 at the end.
using ByteReader = std::function<absl::StatusOr<size_t>(char* buffer, size_t size)>;

// The text must outlive the reader.
ByteReader TextReader(const std::string& text);
// NOT_FOUND or UNAVAILABLE with the path.
absl::StatusOr<ByteReader> FileReader(const std::string& path);

// One move or unsupported block; or, of kind kNone, a block behind which positions are not known (M06, M30).
struct Event {
  int64_t line = 0;
  Step step;
};

class MoveReader : private CornerHost {
 public:
  // `reader` must outlive it.
  MoveReader(const ByteReader& reader, Interpreter interpreter)
      : reader_(reader), interpreter_(std::move(interpreter)) {
    interpreter_.StopAtCalls();
  }

  // False at the end of the program. Errors of the reader.
  absl::StatusOr<bool> Next(Event* event);
  // Several at once, those of a piece of the text: `events` from 0 to `count`, 0 at the end of the program. What it
  // held is overwritten. Not to be mixed with Next.
  absl::Status NextSome(std::vector<Event>* events, size_t* count);

 private:
  // Reads on until events_ has one. False at the end of the program.
  absl::StatusOr<bool> Fill();
  void Line(const char* text, size_t size, bool is_overlong);
  void ReadLine(const char* text, size_t size, bool is_overlong);
  void ReadOrExpand(const char* text, size_t size, bool is_overlong);
  void Read(const CornerLine& line) override {
    interpreter_.ReadAs(line.number);
    ReadOrExpand(line.text, line.size, false);
  }
  const Interpreter& reader() const override { return interpreter_; }
  bool IsOnContour() const override { return true; }
  bool Knows(const Step&) const override { return true; }
  bool MayStay(const Step&, const Step&, double) override { return false; }
  // The next block of those that waited, in the order of the control. False behind the last one.
  bool RunNext();

  const ByteReader& reader_;
  Interpreter interpreter_;
  LineSplitter splitter_;
  Preamble preamble_;
  Corners corners_;
  Block block_;
  Step step_;
  std::vector<char> buffer_ = std::vector<char>(1u << 13);
  // Those that were read and not taken: from next_ to count_. The others keep their memory.
  std::vector<Event> events_;
  size_t next_ = 0, count_ = 0;
  bool is_at_end_ = false;
  // From the first line on that calls a subprogram.
  bool is_waiting_ = false;
  int64_t first_waiting_ = 1;
  std::vector<std::string> waiting_;
  std::unique_ptr<Execution> execution_;
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_MOVE_READER_H_
