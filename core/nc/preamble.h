// Text in front of the first '%': a listing that no control reads (tools, set-up). Whether it is one shows only at that
// '%', so the lines are held back until then, or until the first line that a control would read.
#ifndef AXISCAL_CORE_NC_PREAMBLE_H_
#define AXISCAL_CORE_NC_PREAMBLE_H_

#include <string>
#include <vector>

#include "core/nc/dialect.h"

namespace axiscal::nc {

class Preamble {
 public:
  // The next line, its end included. `read` takes it as part of the program, `skip` as part of a listing; both are
  // called with lines that were held back first, in order.
  template <typename Read, typename Skip>
  void Take(const Dialect& dialect, const char* text, size_t size, bool is_overlong, Read&& read, Skip&& skip) {
    if (is_over_) [[likely]]
      return read(text, size, is_overlong);
    const Kind kind = is_overlong ? Kind::kProgram : KindOf(dialect, text, size);
    held_bytes_ += size;
    if (kind == Kind::kText || (kind == Kind::kNothing && !held_.empty())) {
      held_.emplace_back(text, size);
      if (held_bytes_ > kMaxHeldBytes) Finish(read);
      return;
    }
    if (kind == Kind::kPercent) {
      is_over_ = true;
      for (const std::string& line : held_) skip(line.data(), line.size());
      held_.clear();
    } else if (kind == Kind::kProgram) {
      Finish(read);
    }
    read(text, size, is_overlong);
  }

  // The text ends: what is held back belongs to the program.
  template <typename Read>
  void Finish(Read&& read) {
    is_over_ = true;
    for (const std::string& line : held_) read(line.data(), line.size(), false);
    held_.clear();
  }

 private:
  enum class Kind { kNothing, kText, kPercent, kProgram };
  // A listing of more is not read as one.
  static constexpr size_t kMaxHeldBytes = 1u << 16;

  static Kind KindOf(const Dialect& dialect, const char* text, size_t size);

  bool is_over_ = false;
  size_t held_bytes_ = 0;
  std::vector<std::string> held_;
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_PREAMBLE_H_
