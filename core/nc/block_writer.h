// Writes moves: the block's own bytes with its axis words replaced, or a piece of a split move.
//
// Keeps what the controller has been told ("commanded", exact), apart from what the program means ("nominal"), so that
// G91 words are differences of commanded positions and rounding never adds up.
#ifndef AXISCAL_CORE_NC_BLOCK_WRITER_H_
#define AXISCAL_CORE_NC_BLOCK_WRITER_H_

#include <array>
#include <string>
#include <vector>

#include "core/nc/block.h"
#include "core/nc/interpreter.h"

namespace axiscal::nc {

struct Commanded {
  AxisTicks ticks{};
  std::array<bool, machine::kMaxAxes> is_known{};
};

class BlockWriter {
 public:
  BlockWriter(const machine::Machine& machine, const RewriteOptions& options, const Interpreter& interpreter);

  const Commanded& commanded() const { return commanded_; }
  // The block stays as it is: a move to `step.end`, or one that nobody followed.
  void Pass(const Step& step);
  void ForgetAll() { commanded_.is_known.fill(false); }
  // After a block that may be skipped: what it changed is unknown.
  void ForgetChanges(const Commanded& before);

  // In G91 a word is a difference: the axis' commanded position must be known. Index of the first axis of which it is
  // not, or -1.
  int FirstUnknown(const Step& step) const;

  // Appends `text` (line end included) so that every axis goes to `targets`, rounded to the word's grain.
  // `feed_fraction` < 1: the block is a piece of its move and G93 scales its F word.
  void WriteBlock(const char* text, size_t size, const Block& block, const Step& step, const AxisTicks& targets,
                  double feed_fraction, std::string* out);
  // Appends a piece of the same move: axis words, the F word in G93, line end; no N, no other words.
  void WritePiece(const Block& block, const Step& step, const AxisTicks& targets, double feed_fraction, bool is_packed,
                  const std::string& line_end, std::string* out);

  // Decimals of what is written for an axis in this block.
  int DecimalsOf(const Block& block, const Step& step, int axis) const;
  static bool IsPacked(const char* text, const Block& block);

 private:
  struct Rounded {
    int64_t mantissa;
    int decimals;
    Ticks grain;
  };
  Rounded Round(int axis, Ticks target, int decimals) const;
  void SetCommanded(int axis, const Rounded& rounded);
  bool NeedsWord(int axis, Ticks target, Ticks grain) const;
  void AppendFeed(const Word& word, double fraction, std::string* out) const;
  void InsertWords(const char* text, const Block& block, const Step& step, const AxisTicks& targets, bool is_lower,
                   std::string* out);

  const machine::Machine* machine_;
  const RewriteOptions* options_;
  const Interpreter* interpreter_;
  std::vector<int> order_;  // axes in the order in which inserted words are written
  Commanded commanded_;
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_BLOCK_WRITER_H_
