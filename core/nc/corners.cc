#include "core/nc/corners.h"

#include <algorithm>
#include <cmath>

#include "core/nc/char_class.h"
#include "core/nc/line_splitter.h"

namespace axiscal::nc {
namespace {

constexpr size_t kMostBetween = 3;  // lines without words between the moves
// Of a corner that stays the control's: it must fit between corrected moves, too.
constexpr double kRoomMm = 0.1;
// What must be left of an arc: its ends would be one point, and the arc a full circle.
constexpr double kLeastArcMm = 0.01;
constexpr double kSquareFrame = 1e-9;

bool IsOfName(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_'; }

// Whether `name` (capitals) stands at `at`.
bool NameStandsAt(const char* at, const char* end, const char* name) {
  for (; *name != 0; ++name, ++at) {
    if (at == end || Capital(*at) != *name) return false;
  }
  return true;
}

char LetterOf(int plane_normal, int index) {
  static constexpr char kLetters[3][3] = {"YZ", "ZX", "XY"};
  return kLetters[plane_normal][index];
}
char CentreLetterOf(int plane_normal, int index) {
  static constexpr char kCentres[3][3] = {"JK", "KI", "IJ"};
  return kCentres[plane_normal][index];
}

}  // namespace

bool Corners::HoldsCorner(const char* text, size_t size) {
  const char* const end = text + size;
  for (const char* at = text; at < end && *at != ';'; ++at) {
    if (at > text && IsOfName(at[-1])) continue;
    if (NameStandsAt(at, end, "RND") || NameStandsAt(at, end, "CHF") || NameStandsAt(at, end, "CHR") ||
        NameStandsAt(at, end, "FRCM"))
      return true;
  }
  return false;
}

void Corners::NoteFeed(const char* text, size_t size) {
  const char* const end = std::find(text, text + size, ';');
  bool is_in_text = false;
  for (const char* at = text; at < end; ++at) {
    is_in_text ^= *at == '"';
    if (is_in_text || Capital(*at) != 'F' || (at > text && IsOfName(at[-1]))) continue;
    const char* digit = at + 1;
    while (digit < end && (Class(*digit) == kBlank || *digit == '=')) ++digit;
    if (digit < end && IsOfName(*digit) && digit == at + 1) continue;  // another word: FRC, FB
    const char* last = digit;
    while (last < end && (Class(*last) == kDigit || *last == '.')) ++last;
    const bool is_plain = last > digit && (last == end || !std::strchr("+-*/([", *last));
    // In a block that may be skipped it may not act.
    feed_ = is_plain && text[0] != '/' ? std::string(digit, last) : "";
  }
}

void Corners::ReadSide(int64_t number, const char* text, size_t size, bool is_changed, Side* side) {
  side->text.assign(text, size);
  side->number = number;
  side->is_changed = is_changed;
  side->edits.clear();
  ahead_->ReadAs(number);
  ahead_->Read(side->text.data(), TextSize(side->text.data(), size), &side->block, &side->step);
  side->modal = ahead_->modal();
  side->offsets = ahead_->coordinates().offsets();
}

void Corners::Take(int64_t number, const char* text, size_t size, CornerHost* host) {
  if (!is_holding_) return Begin(number, text, size, false, host);
  ReadSide(number, text, size, false, &to_);
  if (!to_.step.has_words && !to_.step.begins_structure && between_.size() < kMostBetween)
    return between_.emplace_back(text, size), void();
  if (between_.size() < kMostBetween && IsOfAllAlone()) return;
  Decide(host);
}

void Corners::Begin(int64_t number, const char* text, size_t size, bool is_changed, CornerHost* host) {
  if (host->reader().programs_begun() != programs_begun_) all_ = All();
  if (!all_.size && !HoldsCorner(text, size)) {
    const CornerLine line{text, size, number, is_changed, false, "", false};
    return host->Read(line);
  }
  ahead_.emplace(host->reader());
  ahead_->LeaveCorners();
  ReadSide(number, text, size, is_changed, &from_);
  programs_begun_ = ahead_->programs_begun();
  const std::string problem = from_.step.begins_structure ? "" : ReadWords();
  between_.clear();
  is_on_contour_ = host->IsOnContour();
  is_holding_ = problem.empty() && from_.step.kind == StepKind::kMove && (is_own_ || all_.size);
  if (is_holding_) return;
  // Where it leads is not known, nor what RNDM makes of it.
  const bool is_lost = all_.size && !is_own_ && from_.step.kind == StepKind::kUnsupported;
  const bool is_odd = !problem.empty() && from_.block.problem == LexProblem::kNone;
  ReadHeld(Edited(from_, {}), is_lost ? absl::StrCat("RNDM=", all_.text, ": the block is not followed") : problem,
           is_lost || is_odd, host);
}

Corners::Edit Corners::Erased(const Side& side, const Word& word) {
  size_t at = word.letter_at;
  while (at > 0 && Class(side.text[at - 1]) == kBlank) --at;
  return {at, word.end, ""};
}

bool Corners::TakeAll(const Side& side, const Word& word, All* all) const {
  const char* const text = side.text.data();
  const std::string written = side.text.substr(word.number_at, word.end - word.number_at);
  if (word.letter == 'S' && NameStandsAt(text + word.letter_at, text + word.end, "FRCM")) {
    all->feed = word.number.mantissa == 0 ? "" : written;
    return true;
  }
  if (word.letter != 0) return false;
  const Keyword& keyword = ahead_->dialect().keywords[static_cast<size_t>(word.keyword)];
  if (keyword.meaning != Meaning::kCorner || keyword.detail == 0) return false;
  const std::optional<Ticks> size = ahead_->LengthTicks(word);
  all->size = size && *size > 0 ? size : std::nullopt;
  all->text = written;
  return true;
}

bool Corners::IsOfAllAlone() {
  if (to_.block.problem != LexProblem::kNone || to_.block.has_assignment || to_.step.begins_structure) return false;
  All all = next_all_;
  bool has_some = false;
  for (const Word& word : to_.block) {
    const bool is_of_all = TakeAll(to_, word, &all);
    if (!is_of_all && word.letter != 'N') return false;
    has_some |= is_of_all;
    if (is_of_all && word.letter == 0) to_.edits.push_back(Erased(to_, word));
  }
  if (!has_some) return false;
  next_all_ = all;
  changes_all_ = true;
  between_.push_back(Edited(to_, {}));
  return true;
}

std::string Corners::ReadWords() {
  const Dialect& dialect = ahead_->dialect();
  corner_words_.clear();
  is_own_ = false;
  corner_feed_.clear();
  if (from_.block.problem != LexProblem::kNone) return "the block is not read to its end";
  std::string problem;
  bool has_feed = false;
  for (const Word& word : from_.block) {
    const char* const text = from_.text.data();
    const std::string written = from_.text.substr(word.number_at, word.end - word.number_at);
    if (TakeAll(from_, word, &all_)) {
      if (word.letter == 0) from_.edits.push_back(Erased(from_, word));
      if (word.number.mantissa < 0) problem = "below 0";
      continue;
    }
    if (word.letter == 'S' && NameStandsAt(text + word.letter_at, text + word.end, "FRC")) {
      corner_feed_ = word.number.mantissa == 0 ? "" : written;
      has_feed = true;
      corner_words_.push_back(Erased(from_, word));
      if (word.number.mantissa < 0) problem = "below 0";
      continue;
    }
    if (word.letter != 0) continue;
    const Keyword& keyword = dialect.keywords[static_cast<size_t>(word.keyword)];
    if (keyword.meaning != Meaning::kCorner) continue;
    const std::optional<Ticks> size = ahead_->LengthTicks(word);
    const std::string name = absl::StrCat(keyword.name, "=", written);
    if (!size || *size < 0 || word.distance != Distance::kModal) {
      problem = name + ": expected a length of 0 or more";
      continue;
    }
    if (is_own_) problem = "two corners in one block";
    is_own_ = true;
    kind_ = std::strcmp(keyword.name, "RND") == 0   ? Kind::kRounding
            : std::strcmp(keyword.name, "CHF") == 0 ? Kind::kChamfer
                                                    : Kind::kLegs;
    size_ = *size;
    name_ = name;
    corner_words_.push_back(Erased(from_, word));
  }
  if (!is_own_ && all_.size) kind_ = Kind::kRounding, size_ = *all_.size, name_ = "RNDM=" + all_.text;
  if (!has_feed) corner_feed_ = all_.feed;
  next_all_ = all_;
  changes_all_ = false;
  return problem;
}

std::string Corners::WhyNotInPlane(const Side& side, bool* is_in_plane) const {
  const Step& step = side.step;
  *is_in_plane = true;
  if (step.kind != StepKind::kMove || step.leaves_text || step.moves_away || step.is_tool_change)
    return "the block behind it is no move of the contour";
  if (step.wrapped != 0 || step.has_vector) return "a rotary axis turns beside it";
  bool is_known = true;
  *is_in_plane = step.is_arc;
  for (const int axis : {first_, second_}) {
    const bool knows = step.start.is_known(axis) && step.end.is_known(axis);
    *is_in_plane |= knows ? step.start.ticks[axis] != step.end.ticks[axis] : step.word_of_axis[axis] >= 0;
    is_known &= knows;
  }
  if (!is_known && *is_in_plane) return "it is not known where its moves begin";
  for (int axis = 0; axis < machine::kMaxAxes; ++axis) {
    if (axis == first_ || axis == second_ || step.word_of_axis[axis] < 0) continue;
    if (!step.start.is_known(axis) || step.start.ticks[axis] != step.end.ticks[axis])
      return "a move beside it leaves the working plane, and the control makes no corner there";
  }
  if (step.is_rapid) return "a rapid move beside it";
  if (step.is_arc && (step.arc.first != first_ || step.arc.second != second_)) return "the working plane changes there";
  return "";
}

std::string Corners::WhyNot(bool* has_none) const {
  *has_none = false;
  const Step &from = from_.step, &to = to_.step;
  if (to.begins_structure) return "a call stands behind it";
  if (first_ < 0 || second_ < 0) return "the machine has no two axes in the working plane";
  if (to.kind != StepKind::kMove) {
    *has_none = !is_own_ && (to.ends_program || to.kind == StepKind::kUntouched);
    return *has_none ? "" : "the block behind it is no move";
  }
  bool is_from_in_plane = false, is_to_in_plane = false;
  const std::string of_from = WhyNotInPlane(from_, &is_from_in_plane), of_to = WhyNotInPlane(to_, &is_to_in_plane);
  // RNDM acts between moves of the plane alone.
  *has_none = !is_own_ && from.kind == StepKind::kMove && (!is_from_in_plane || !is_to_in_plane) &&
              from.cutter_side == 0 && to.cutter_side == 0;
  if (*has_none) return "";
  if (!of_from.empty()) return of_from;
  if (!of_to.empty()) return of_to;
  if (!is_from_in_plane || !is_to_in_plane) return "a move beside it has no part in the working plane";
  for (const Side* side : {&from_, &to_}) {
    const Block& block = side->block;
    if (block.is_deletable) return "a block beside it may be skipped";
    if (block.has_expression || block.has_assignment || block.problem != LexProblem::kNone)
      return "variables in a block beside it";
    if (side->step.ends_block) return "a block beside it has a code that acts behind the move";
    if (side->modal.uncertain != 0) return "modal codes in force are not known";
  }
  if (from.is_tool_point && from.placed == nullptr) return "under tool centre point control";
  if (from.placed != to.placed || from.is_tool_point != to.is_tool_point || from.tool_length != to.tool_length ||
      from_.offsets != to_.offsets || from_.modal.is_inch != to_.modal.is_inch)
    return "coordinates change there";
  if (from.placed != nullptr) {
    const Eigen::Matrix3d& linear = from.placed->linear;
    if (!(linear.transpose() * linear - Eigen::Matrix3d::Identity()).isZero(kSquareFrame))
      return "in scaled coordinates";
  }
  if (from_.modal.plane_normal != to_.modal.plane_normal) return "the working plane changes there";
  if (from_.modal.feed_mode != to_.modal.feed_mode || from_.modal.feed_mode == FeedMode::kInverseTime)
    return "in G93 its share of the time is not known";
  if (from.cutter_side != to.cutter_side || from.cutter_radius != to.cutter_radius)
    return "cutter compensation begins or ends there";
  if (from.cutter_side != 0 && !is_on_contour_) return "the move in front of it leads to the contour";
  return "";
}

CornerMove Corners::MoveOf(const Step& step) const {
  const auto at = [&](const Positions& positions) -> Eigen::Vector2d {
    return Eigen::Vector2d(static_cast<double>(positions.ticks[first_]),
                           static_cast<double>(positions.ticks[second_])) /
           kTicksPerUnit;
  };
  CornerMove move{at(step.start), at(step.end), step.is_arc, step.arc};
  return move;
}

void Corners::Decide(CornerHost* host) {
  const int normal = from_.modal.plane_normal;
  first_ = ahead_->AxisOf(LetterOf(normal, 0));
  second_ = ahead_->AxisOf(LetterOf(normal, 1));
  unit_ = from_.modal.is_inch ? kTicksPerInch : kTicksPerMm;
  bool has_none = false, is_refused = false;
  std::string problem = WhyNot(&has_none);
  if (problem.empty() && !has_none && !host->Knows(from_.step))
    problem = "it is not known where all axes stand, and nothing is corrected there";
  CornerPath path;
  if (problem.empty() && !has_none && size_ > 0) {
    const CornerMove from = MoveOf(from_.step), to = MoveOf(to_.step);
    const double size_mm = static_cast<double>(size_) / kTicksPerUnit;
    const absl::StatusOr<CornerPath> found = kind_ == Kind::kRounding
                                                 ? RoundCorner(from, to, size_mm)
                                                 : ChamferCorner(from, to, size_mm, kind_ == Kind::kChamfer);
    if (found.ok()) path = *found;
    is_refused = !found.ok();
    if (is_refused)
      problem = absl::StrCat(found.status().message(), ": the control would make it smaller, by how much is not known");
    has_none = found.ok() && path.is_none;
    const bool is_used_up =
        (from.is_arc && path.left_of_from_mm < kLeastArcMm) || (to.is_arc && path.left_of_to_mm < kLeastArcMm);
    if (found.ok() && !has_none && is_used_up) problem = "nothing is left of the arc beside it", is_refused = true;
  } else if (problem.empty()) {
    has_none = true;
  }
  const bool is_there = problem.empty() && !has_none;
  bool says_feed = false;
  for (const Word& word : to_.block) {
    says_feed |= ahead_->RoleOf(word.letter) == Role::kFeed;
    All all;
    changes_all_ |= TakeAll(to_, word, &all) && word.letter == 0;
  }
  if (!has_none && !is_own_ && changes_all_)
    problem = "another RNDM or FRCM stands behind it: whether it acts there is not known", is_refused = true;
  if (is_there && !corner_feed_.empty() && !says_feed && feed_.empty())
    problem = "the feed to which the control returns behind it is not known: state F in front of it";
  const bool has_room = path.left_of_from_mm > kRoomMm && path.left_of_to_mm > kRoomMm;
  const bool stays = !problem.empty() || (!has_none && has_room && host->MayStay(from_.step, to_.step, path.reach_mm));
  if (!problem.empty()) problem = absl::StrCat(name_, ": ", problem);
  std::string behind = to_.text;
  bool is_behind_changed = false;
  const int64_t behind_number = to_.number;
  if (stays) {
    std::vector<Edit> more;
    // Behind RNDM every corner that stays says so itself.
    if (!is_own_) {
      const size_t at = EndOfWords(*ahead_, from_);
      more.push_back({at, at, " RND=" + all_.text});
    }
    ReadHeld(Edited(from_, more), problem, is_refused, host);
  } else if (has_none) {
    ReadHeld(Edited(from_, corner_words_), "", false, host);
  } else {
    EndAt(path.from_mm);
    StartAt(path.to_mm);
    const bool has_motion =
        std::any_of(to_.block.begin(), to_.block.end(), [&](const Word& word) { return ahead_->IsMotionCode(word); });
    if (!has_motion) {
      const auto first = std::find_if(to_.block.begin(), to_.block.end(), [&](const Word& word) {
        return ahead_->AxisOf(word.letter) >= 0 || ahead_->RoleOf(word.letter) == Role::kCentre;
      });
      const std::string motion = !to_.step.is_arc ? "G1 " : to_.modal.is_clockwise ? "G2 " : "G3 ";
      to_.edits.push_back({first->letter_at, first->letter_at, motion});
    }
    if (!corner_feed_.empty() && !says_feed) {
      const size_t at = EndOfWords(*ahead_, to_);
      to_.edits.push_back({at, at, " F" + feed_});
    }
    behind = Edited(to_, {});
    is_behind_changed = true;
    const std::string inserted = CornerBlock(path);
    const int64_t number = from_.number;
    std::vector<std::string> between;
    between.swap(between_);
    ReadHeld(Edited(from_, corner_words_), "", false, host);
    host->Read({inserted.data(), inserted.size(), number, true, true, "", false});
    int64_t next = number;
    for (const std::string& line : between)
      host->Read({line.data(), line.size(), ++next, changes_all_, false, "", false});
  }
  all_ = next_all_;
  Begin(behind_number, behind.data(), behind.size(), is_behind_changed, host);
}

void Corners::Release(const std::string& problem, CornerHost* host) {
  if (!is_holding_) return;
  ReadHeld(Edited(from_, {}), is_own_ ? absl::StrCat(name_, ": ", problem) : "", false, host);
  all_ = next_all_;
}

void Corners::ReadHeld(const std::string& text, const std::string& problem, bool is_refused, CornerHost* host) {
  is_holding_ = false;
  const bool is_changed = from_.is_changed || text != from_.text;
  host->Read({text.data(), text.size(), from_.number, is_changed, false, problem, is_refused});
  int64_t next = from_.number;
  for (const std::string& line : between_)
    host->Read({line.data(), line.size(), ++next, changes_all_, false, "", false});
  between_.clear();
}

std::string Corners::NumberOf(Ticks number, int decimals) const {
  const RewriteOptions& options = ahead_->options();
  const int least = std::max(decimals, unit_ == kTicksPerInch ? options.decimals_inch : options.decimals_mm);
  return TicksText(number, unit_, least);
}

void Corners::Say(const Word& word, Ticks number, Side* side) const {
  side->edits.push_back({word.number_at, word.end, NumberOf(number, word.number.decimals)});
}

size_t Corners::EndOfWords(const Interpreter& reader, const Side& side) {
  size_t at = 0;
  for (const Word& word : side.block) {
    if (reader.AxisOf(word.letter) < 0 && reader.RoleOf(word.letter) != Role::kCentre) continue;
    at = word.end;
    if (word.distance == Distance::kModal) continue;
    while (at < side.text.size() && Class(side.text[at]) == kBlank) ++at;
    at = at < side.text.size() && side.text[at] == ')' ? at + 1 : word.end;
  }
  return at;
}

void Corners::EndAt(const Eigen::Vector2d& at_mm) {
  std::string inserted;
  for (const int index : {0, 1}) {
    const int axis = PlaneAxis(index), word = from_.step.word_of_axis[axis];
    const Ticks was = from_.step.end.ticks[axis];
    Ticks is = std::llround(at_mm[index] * kTicksPerUnit);
    is = from_.step.start.ticks[axis] == was && !from_.step.is_arc ? was : is;
    if (is == was) continue;
    if (word >= 0) {
      const Word& said = from_.block.words[static_cast<size_t>(word)];
      Say(said, *ahead_->LengthTicks(said) + is - was, &from_);
      continue;
    }
    const Ticks base = from_.modal.is_incremental ? from_.step.start.ticks[axis] : from_.offsets[axis];
    absl::StrAppend(&inserted, " ", std::string(1, LetterOf(from_.modal.plane_normal, index)), NumberOf(is - base, 0));
  }
  const size_t at = EndOfWords(*ahead_, from_);
  if (!inserted.empty()) from_.edits.push_back({at, at, inserted});
}

void Corners::StartAt(const Eigen::Vector2d& at_mm) {
  std::string inserted;
  const size_t at = EndOfWords(*ahead_, to_);
  for (const int index : {0, 1}) {
    const int axis = PlaneAxis(index), word = to_.step.word_of_axis[axis];
    const Ticks was = to_.step.start.ticks[axis], end = to_.step.end.ticks[axis];
    Ticks is = std::llround(at_mm[index] * kTicksPerUnit);
    is = was == end && !to_.step.is_arc ? was : is;
    const char letter = LetterOf(to_.modal.plane_normal, index),
               centre_letter = CentreLetterOf(to_.modal.plane_normal, index);
    if (word >= 0) {
      const Word& said = to_.block.words[static_cast<size_t>(word)];
      const bool is_difference =
          said.distance == Distance::kModal ? to_.modal.is_incremental : said.distance == Distance::kIncremental;
      if (is_difference && is != was) Say(said, *ahead_->LengthTicks(said) - (is - was), &to_);
    } else if (is != end) {
      const Ticks base = to_.modal.is_incremental ? is : to_.offsets[axis];
      absl::StrAppend(&inserted, " ", std::string(1, letter), NumberOf(end - base, 0));
    }
    if (!to_.step.is_arc || is == was) continue;
    bool is_found = false, has_radius = false;
    for (const Word& centre : to_.block) {
      has_radius |= ahead_->RoleOf(centre.letter) == Role::kRadius;
      if (ahead_->RoleOf(centre.letter) != Role::kCentre || centre.letter != centre_letter) continue;
      is_found = true;
      if (centre.distance != Distance::kAbsolute) Say(centre, *ahead_->LengthTicks(centre) - (is - was), &to_);
    }
    if (!is_found && !has_radius) absl::StrAppend(&inserted, " ", std::string(1, centre_letter), NumberOf(was - is, 0));
  }
  if (!inserted.empty()) to_.edits.push_back({at, at, inserted});
}

std::string Corners::CornerBlock(const CornerPath& path) const {
  const int normal = from_.modal.plane_normal;
  std::string text = !path.is_arc ? "G1" : path.is_counterclockwise ? "G3" : "G2", centre;
  for (const int index : {0, 1}) {
    const int axis = PlaneAxis(index);
    const auto ticks = [&](const Eigen::Vector2d& at_mm) -> Ticks {
      return std::llround(at_mm[index] * kTicksPerUnit);
    };
    Ticks from = ticks(path.from_mm), to = ticks(path.to_mm);
    if (from_.step.start.ticks[axis] == from_.step.end.ticks[axis] && !from_.step.is_arc)
      from = from_.step.end.ticks[axis];
    if (to_.step.start.ticks[axis] == to_.step.end.ticks[axis] && !to_.step.is_arc) to = to_.step.start.ticks[axis];
    const Ticks base = from_.modal.is_incremental ? from : from_.offsets[axis];
    absl::StrAppend(&text, " ", std::string(1, LetterOf(normal, index)), NumberOf(to - base, 0));
    absl::StrAppend(&centre, " ", std::string(1, CentreLetterOf(normal, index)),
                    NumberOf(ticks(path.centre_mm) - from, 0));
  }
  if (path.is_arc) text += centre;
  if (!corner_feed_.empty()) absl::StrAppend(&text, " F", corner_feed_);
  return text + from_.text.substr(TextSize(from_.text.data(), from_.text.size()));
}

std::string Corners::Edited(const Side& side, const std::vector<Edit>& more) {
  std::vector<Edit> edits = side.edits;
  edits.insert(edits.end(), more.begin(), more.end());
  std::stable_sort(edits.begin(), edits.end(),
                   [](const Edit& a, const Edit& b) { return a.at != b.at ? a.at < b.at : a.end < b.end; });
  std::string text = side.text;
  // From behind; where two insert at one place, the second stands behind the first.
  for (size_t i = edits.size(); i-- > 0;) text.replace(edits[i].at, edits[i].end - edits[i].at, edits[i].by);
  return text;
}

}  // namespace axiscal::nc
