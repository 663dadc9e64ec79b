// Corners that the control rounds or chamfers between two moves: RND=, RNDM=, CHF= and CHR= of Sinumerik, with the feed
// FRC= or FRCM=. They are read as what the control makes of them: the move up to the corner, an arc that touches both
// moves or a straight chamfer, and the rest of the move behind it, each a line of its own.
//
// The control makes a corner only between moves that stand in the working plane as a whole (assumed: docs/nc.md), and a
// correction moves other axes too: written as moves, corners stay.
#ifndef AXISCAL_CORE_NC_CORNERS_H_
#define AXISCAL_CORE_NC_CORNERS_H_

#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "core/nc/corner_geometry.h"
#include "core/nc/interpreter.h"

namespace axiscal::nc {

// A line as it is read in place of the program's.
struct CornerLine {
  const char* text = nullptr;
  size_t size = 0;           // with its end
  int64_t number = 0;        // of the program's line that it comes from
  bool is_changed = false;   // it has other bytes than that
  bool is_inserted = false;  // it stands behind that
  // Why the corner at its end stays the control's, "": it does not, or there is none. `is_refused`: nobody knows what
  // the control makes of it.
  std::string problem;
  bool is_refused = false;
};

// Who reads the lines.
class CornerHost {
 public:
  virtual ~CornerHost() = default;
  // Reads the line.
  virtual void Read(const CornerLine& line) = 0;
  // Stands behind the line that was read last.
  virtual const Interpreter& reader() const = 0;
  // Whether cutter compensation is in force and its first move is done.
  virtual bool IsOnContour() const = 0;
  // Whether all axes that a correction depends on are known where the move begins: else it stays as the program has it.
  virtual bool Knows(const Step& move) const = 0;
  // Whether the control may make the corner between the two moves, corrected, itself: `reach_mm` is by how much it
  // changes for each rad that the moves turn to each other, at most.
  virtual bool MayStay(const Step& from, const Step& to, double reach_mm) = 0;
};

inline constexpr char kNoMoveBehind[] = "no move stands behind it";

class Corners {
 public:
  // Whether the line is for Take: it may hold a word of corners, or one of an earlier line may act on it. Every line of
  // the program must be asked for.
  bool Wants(const Dialect& dialect, const char* text, size_t size) {
    if (!dialect.has_equals) return false;
    if (std::memchr(text, 'F', size) != nullptr || std::memchr(text, 'f', size) != nullptr) NoteFeed(text, size);
    return is_holding_ || all_.size || (std::memchr(text, '=', size) != nullptr && HoldsCorner(text, size));
  }
  // The next line, with its end, and its number.
  void Take(int64_t number, const char* text, size_t size, CornerHost* host);
  // No line comes behind the one that is held.
  void Release(const std::string& problem, CornerHost* host);
  bool is_holding() const { return is_holding_; }
  // Of the program's, that are taken and not read.
  int64_t held_lines() const { return is_holding_ ? 1 + static_cast<int64_t>(between_.size()) : 0; }

 private:
  enum class Kind : uint8_t { kRounding, kChamfer, kLegs };
  struct Edit {
    size_t at, end;
    std::string by;
  };
  // A line with a move, at whose end or begin the corner stands, and in which state its words stand.
  struct Side {
    std::string text;
    int64_t number = 0;
    bool is_changed = false;
    Block block;
    Step step;
    Modal modal;
    AxisTicks offsets{};
    std::vector<Edit> edits;
  };

  // What RNDM= and FRCM= state.
  struct All {
    std::optional<Ticks> size;
    std::string text, feed;
  };

  static bool HoldsCorner(const char* text, size_t size);
  void NoteFeed(const char* text, size_t size);
  void ReadSide(int64_t number, const char* text, size_t size, bool is_changed, Side* side);
  void Begin(int64_t number, const char* text, size_t size, bool is_changed, CornerHost* host);
  // The words of corners in the block that is held. Why they cannot be read, or "".
  std::string ReadWords();
  // A word of RNDM or FRCM states `all`. False: it is none.
  bool TakeAll(const Side& side, const Word& word, All* all) const;
  // Whether the block is nothing else; it is kept between the moves then.
  bool IsOfAllAlone();
  static Edit Erased(const Side& side, const Word& word);
  // The move behind the corner is read.
  void Decide(CornerHost* host);
  // Why the corner is not resolved, or "". `has_none`: the control makes none.
  std::string WhyNot(bool* has_none) const;
  // Likewise of one of both moves; `is_in_plane`: it has a part there.
  std::string WhyNotInPlane(const Side& side, bool* is_in_plane) const;
  CornerMove MoveOf(const Step& step) const;
  std::string CornerBlock(const CornerPath& path) const;
  // The line ends, or begins, where the corner begins or ends.
  void EndAt(const Eigen::Vector2d& at_mm);
  void StartAt(const Eigen::Vector2d& at_mm);
  int PlaneAxis(int index) const { return index == 0 ? first_ : second_; }
  // The axis word says `number` (ticks).
  void Say(const Word& word, Ticks number, Side* side) const;
  std::string NumberOf(Ticks number, int decimals) const;
  // Where words may be inserted: behind the last word of an axis or a centre.
  static size_t EndOfWords(const Interpreter& reader, const Side& side);
  static std::string Edited(const Side& side, const std::vector<Edit>& more);
  void ReadHeld(const std::string& text, const std::string& problem, bool is_refused, CornerHost* host);

  bool is_holding_ = false;
  std::optional<Interpreter> ahead_;  // behind the last line that was taken
  Side from_, to_;
  bool is_own_ = false;  // the corner is of the block's words, not of RNDM
  bool is_on_contour_ = false;
  std::vector<Edit> corner_words_;  // of the block in front: without them the control makes no corner
  Kind kind_ = Kind::kRounding;
  std::string name_;  // "RND=2"
  Ticks size_ = 0;
  std::string corner_feed_;       // of FRC= or FRCM=, "": that of the moves
  int first_ = -1, second_ = -1;  // axes of the plane
  Ticks unit_ = kTicksPerMm;
  std::vector<std::string> between_;  // comments, and what is left of blocks of RNDM and FRCM alone
  bool changes_all_ = false;          // one of them has such words, and what they state
  All all_, next_all_;                // in force, and behind the held move
  int64_t programs_begun_ = 0;
  std::string feed_;  // of the last F word, "": not known
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_CORNERS_H_
