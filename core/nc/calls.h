// Subprograms: which blocks call them, where they stand, and in which order the control runs the blocks of a program
// that calls some. Fanuc B-64484EN, "Subprogram (M98, M99)" and "Macro call (G65)"; Haas 96-8200, M97 to M99; LinuxCNC
// 2.9, "O codes"; TNC 640, "Subprograms and program section repeats"; 840D sl, "Subprogram technique".
#ifndef AXISCAL_CORE_NC_CALLS_H_
#define AXISCAL_CORE_NC_CALLS_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/nc/dialect.h"
#include "core/nc/options.h"

namespace axiscal::nc {

// What a line does to the order of blocks. Offsets count bytes of the line.
struct FlowLine {
  enum class Kind : uint8_t {
    kPlain,
    kCall,
    kReturn,      // of a subprogram: M99, M17, RET, ENDSUB, LBL 0
    kHead,        // a subprogram begins: O1000, O100 SUB, LBL 5, %_N_A_SPF
    kProgramEnd,  // M30
  };
  Kind kind = Kind::kPlain;
  std::string target;  // of kCall and kHead: "O1000", "N500", "LBL 5", "PGM A"; of kHead and kReturn "" where none
  int64_t repeats = 1;
  bool is_alone = false;    // nothing but the call or return stands in the block, but for codes in front of a call
  bool has_codes = false;   // G codes that state modes, which act before the call: G90 G54 M98 P1000
  bool is_packed = false;   // P51002: O1002 five times
  bool is_section = false;  // CALL LBL 1 REP 2: the part above, twice more
  size_t target_at = 0, target_end = 0;    // number or name
  size_t repeats_at = 0, repeats_end = 0;  // "L3"; equal: the block has none
  size_t code_at = 0, code_end = 0;        // what calls, without the block's number and comments
};

FlowLine ReadFlow(const std::string& line, const Dialect& dialect);

// A subprogram: its lines are those from `head` on (the first one where its name stands), up to and without `end`.
struct Body {
  int text = 0;
  size_t head = 0, begin = 0, end = 0;  // `begin`: the first block that runs
  std::string name;
  bool must_be_called = false;                // the control reads over it (O100 SUB)
  bool is_section = false;                    // of CALL LBL REP: its first run is that of the text around it
  bool states_unit = false, is_inch = false;  // BEGIN PGM A INCH
  std::string problem;                        // why no call of it is followed
};

// The blocks of a text in the order in which the control runs them.
class Execution {
 public:
  // `lines`: of the program from its line `first_line` on, their ends included; `subprograms`: texts of other files.
  Execution(const Dialect& dialect, const RewriteOptions& options, std::vector<std::string> lines, int64_t first_line);

  struct Event {
    enum class Kind : uint8_t {
      kLine,   // a block to be read
      kApart,  // moves and changes nothing: a call or return that is followed, a head, what no call runs
      kEnter,  // `body` runs: its blocks follow
      kLeave,  // its end, which `line` is
    };
    Kind kind = Kind::kLine;
    int text = 0;                     // 0: the program; others in the order of options.subprograms
    size_t line = 0;                  // index into the text's lines
    int body = -1;                    // that runs; -1: the program
    bool is_call = false;             // of kApart, and of kLine whose block states modes first: what it calls runs next
    bool is_packed = false;           // of a call: its number holds the repeats
    bool is_followed_return = false;  // of kLine: its block returns, and may move
    std::string call_problem;         // of kLine: why the call in it is not followed
    std::string problem;              // what must not be
  };
  // False behind the last block.
  bool Next(Event* event);

  const std::vector<std::string>& lines(int text) const { return texts_[static_cast<size_t>(text)].lines; }
  // In the text's own count, from 1.
  int64_t line_number(int text, size_t line) const {
    return texts_[static_cast<size_t>(text)].first_line + static_cast<int64_t>(line);
  }
  const std::string& text_name(int text) const { return texts_[static_cast<size_t>(text)].name; }
  int text_count() const { return static_cast<int>(texts_.size()); }
  const FlowLine& flow(int text, size_t line) const { return texts_[static_cast<size_t>(text)].flow[line]; }
  const std::vector<Body>& bodies() const { return bodies_; }
  // A name that neither text nor call uses: O1001 for O1000.
  std::string FreeName(const std::string& name);

 private:
  struct Text {
    std::string name;
    std::vector<std::string> lines;
    std::vector<FlowLine> flow;
    int64_t first_line = 1;
    std::map<std::string, int> bodies;
  };
  struct Frame {
    int text = 0;
    size_t line = 0, end = 0;
    int body = -1;          // -1: the program itself
    int64_t runs_left = 0;  // behind this one
    bool is_entered = false, has_returned = false, is_section = false;
  };

  void AddText(std::string name, std::vector<std::string> lines, int64_t first_line);
  void FindBodies(int text);
  void AddBody(int text, const std::string& name, size_t head, size_t begin, size_t end, bool must_be_called);
  bool IsKnown(const std::string& name) const;
  // The part of a text that CALL LBL REP runs again; -1 and why not.
  int SectionOf(int text, size_t call, const FlowLine& flow, std::string* problem);
  // Index of the body that a call names, or -1 and why it is not followed.
  int Resolve(int text, const FlowLine& flow, std::string* problem) const;

  const Dialect& dialect_;
  const RewriteOptions& options_;
  std::vector<Text> texts_;
  std::vector<Body> bodies_;
  std::vector<bool> is_apart_;  // by line of the program: it stands in a body that is called
  std::vector<Frame> frames_;
  std::map<std::string, bool> used_;
  int64_t lines_run_ = 0;
  bool has_ended_ = false;
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_CALLS_H_
