// Where a program begins and ends within its file: byte-order mark, '%' lines, 0x1A, text behind the end.
#ifndef AXISCAL_CORE_NC_PROGRAM_FRAME_H_
#define AXISCAL_CORE_NC_PROGRAM_FRAME_H_

#include <cstddef>
#include <cstdint>

namespace axiscal::nc {

class ProgramFrame {
 public:
  enum class Kind {
    kBlock,
    kNotABlock,      // blank, '%', or further text behind the end
    kTail,           // the first text behind the end: controllers do not read it
    kSecondProgram,  // '%' behind the closing '%'
    kBehindCut,      // text behind 0x1A without a closing '%': controllers may read on
    kHead,           // "%_N_NAME_MPF" of Sinumerik archives: a program begins, also behind another one
  };

  // The next line, without its end. Of a block, takes a byte-order mark off its begin and 0x1A off its end.
  Kind Read(int64_t line, const char** text, size_t* size) {
    const char* const at = *text;
    // Nearly every line begins with a letter: only the others can be part of the frame.
    if (has_begun_ && !has_ended_ && *size > 0 && at[0] >= 'A' && at[0] <= 'Z' && at[*size - 1] != kSubstitute &&
        at[*size - 1] != '%')
      return Kind::kBlock;
    return ReadSlowly(line, text, size);
  }

  bool has_ended() const { return has_ended_; }

 private:
  static constexpr char kSubstitute = 0x1A;  // end of file of old systems

  // "N194 %".
  static bool IsNumberedPercent(const char* at, const char* end);
  Kind ReadSlowly(int64_t line, const char** text, size_t* size);

  bool has_begun_ = false;  // a '%' or a block was read
  bool has_ended_ = false;  // the closing '%' or 0x1A was read
  bool is_cut_ = false;     // by 0x1A
  bool has_tail_ = false;
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_PROGRAM_FRAME_H_
