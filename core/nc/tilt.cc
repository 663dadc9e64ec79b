// Words of X, Y and Z that a rotation, a mirror, a scale or a tilted plane turns: G68, G68.2, G53.1, G51, G51.1 and
// G254; ROT, MIRROR, SCALE and CYCLE800; cycles 8, 10, 11 and 19 and PLANE SPATIAL. What the controls do is of their
// manuals where docs/nc.md does not say "assumed".
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>

#include "absl/strings/str_split.h"
#include "core/base/units.h"
#include "core/nc/plain_number.h"
#include "core/nc/request.h"
#include "core/nc/tilted_axes.h"

namespace axiscal::nc {
namespace {

constexpr double kSameFrame = 1e-12;
constexpr double kSameTurn = 1e-9;     // rad
constexpr double kMostLeanRad = 5e-4;  // words of rotary axes and of angles have three decimals
constexpr double kLeastScale = 1e-3, kMostScale = 1e3;

Eigen::Matrix3d About(int axis, double angle_deg) {
  return Eigen::AngleAxisd(angle_deg * base::kRadPerDeg, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
}

// "X10", "X=10", "RPL=30", "SPA+45", "X": the name, and the number or nothing. False for anything else.
bool SplitWord(const std::string& word, std::string* name, std::optional<double>* value) {
  size_t at = 0;
  while (at < word.size() && word[at] >= 'A' && word[at] <= 'Z') ++at;
  *name = word.substr(0, at);
  value->reset();
  if (at == word.size()) return at > 0;
  const std::optional<Decimal> number = PlainNumber(std::string_view(word).substr(at + (word[at] == '=')));
  if (!number) return false;
  *value = ValueOf(*number);
  return at > 0;
}

}  // namespace

std::string Interpreter::WhyNoFrame(uint32_t mode, bool in_table) const {
  const bool is_plane = (mode & kTiltedPlanes) != 0;
  if (block_may_be_skipped_) return "in a block that may be skipped: state --block-delete";
  if (options_->orientation) return "with --orientation it is not followed";
  if (!frame_of_words_.has_xyz()) return "the machine has not the linear axes X, Y and Z";
  if ((modal_.blockers & ~mode) != 0) return BlockerText(modal_.blockers & ~mode);
  if ((modal_.tool_point & ~kPlacedFrames) != 0) return "under tool centre point control it is not followed";
  // A new plane of Sinumerik and Klartext takes the place of the one in force.
  const uint32_t replaced = dialect_->has_poles || dialect_->has_equals ? mode : 0;
  const uint32_t others = modal_.tool_point & (is_plane ? kPlacedFrames & ~replaced : kTurnedFrames & ~mode);
  if (others != 0 || frames_.moves_origin) return "while another frame is in force: end that in front of it";
  if ((modal_.uncertain & (kUnitGroup | kOffsetGroup)) != 0) {
    const std::string problem = UnitProblem();
    return problem.empty() ? "the work offset is not known" : problem;
  }
  if (coordinates_.has_preset()) return "with preset coordinates (G92) in force";
  if (!in_table) return "";
  if (!frame_of_words_.problem().empty()) return frame_of_words_.problem();
  if (coordinates_.has_shift() || (coordinates_.has_frame() && dialect_->has_equals))
    return "with shifted coordinates (G52, TRANS) in force";
  if (coordinates_.has_length_difference())
    return "with a difference of the tool length (DL) the tool point is not that of the stated length";
  return RotaryOffsetProblem();
}

void Interpreter::BeginFrame(const Block& block, Request* request, Step* step) {
  const uint32_t bit = request->frame->detail & ~kAnglesXyz;
  blockers_seen_ |= bit;
  const std::string problem = ReadFrame(block, *request);
  step->word_of_axis.fill(-1);  // its words are no positions
  if (problem.empty() && request->problem.empty()) {
    modal_.blockers &= ~bit;
    modal_.tool_point |= bit;
    return;
  }
  if ((modal_.tool_point & kPlacedFrames) != 0) LoseToolPoint();
  modal_.blockers |= bit;
  request->Refuse(absl::StrCat(WordText(*request->frame_word), " (", request->frame->text, ")",
                               problem.empty() ? "" : ": ", problem));
}

std::string Interpreter::ReadFrame(const Block& block, const Request& request) {
  const Code& code = *request.frame;
  const Meaning meaning = code.meaning;
  const bool in_table = meaning == Meaning::kTilt || meaning == Meaning::kMoveOrigin;
  if (std::string problem = WhyNoFrame(code.detail & ~kAnglesXyz, in_table); !problem.empty()) return problem;
  if ((modal_.tool_point & code.detail & kPlacedFrames) != 0) return "while it is in force already: end that in front";
  if (!request.is_whole) return "its words are not plain numbers";
  if (modal_.is_incremental || (modal_.uncertain & kDistanceGroup) != 0) return "program it in G90";
  Eigen::Vector3d at = Eigen::Vector3d::Zero(), angle = Eigen::Vector3d::Zero();
  std::optional<double> radius, factor;
  uint16_t places = 0;
  bool has_angle = false;
  for (const Word& word : block) {
    const Role role = RoleOf(word.letter);
    if (role == Role::kLineNumber || &word == request.frame_word) continue;
    if (role == Role::kCode) {
      const Meaning other = Find(word).meaning;
      if (other == Meaning::kAbsolute || other == Meaning::kPlane || other == Meaning::kMillimetre ||
          other == Meaning::kInch)
        continue;
      return "with another code in its block";
    }
    if (word.distance != Distance::kModal) return "with a word that states its distance";
    if (const std::string problem = WordProblem(word); !problem.empty()) return problem;
    const int k = word.letter - 'X', i = word.letter - 'I';
    const bool is_place = role == Role::kAxis && k >= 0 && k < 3, is_angle = role == Role::kCentre && i >= 0 && i < 3;
    const Ticks unit = is_place && modal_.is_inch ? kTicksPerInch : kTicksPerMm;
    const std::optional<Ticks> ticks = ToTicks(Meant(word.number, unit), unit);
    const double value = static_cast<double>(*ticks) / kTicksPerUnit;
    if (is_place) {
      at[k] = value;
      places |= static_cast<uint16_t>(1u << k);
    } else if (is_angle && meaning == Meaning::kTilt) {
      angle[i] = value;
      has_angle = true;
    } else if (role == Role::kRadius && meaning == Meaning::kRotate) {
      radius = value;
    } else if (word.letter == 'P' && meaning == Meaning::kScale) {
      if (!word.number.has_point) return "its factor P has no point, and what its last digit counts is not known";
      factor = value;
    } else {
      return absl::StrCat("with a word ", std::string(1, word.letter));
    }
  }
  const bool is_xy = modal_.plane_normal == 2 && (modal_.uncertain & kPlaneGroup) == 0;
  switch (meaning) {
    case Meaning::kRotate:
      if (!is_xy) return "in another plane than XY, or where that is not known";
      if (!radius || places != 3) return "followed is G68 X Y R with all three words";
      frames_.inner = About(2, *radius);
      frames_.inner_at_mm = at - frames_.inner * at;
      return "";
    case Meaning::kScale:
      if (places != 7 || !factor || *factor < kLeastScale || *factor > kMostScale)
        return "followed is G51 X Y Z P with all four words";
      frames_.inner = Eigen::Matrix3d::Identity() * *factor;
      frames_.inner_at_mm = at - frames_.inner * at;
      return "";
    case Meaning::kMirrorOn:
      if (places == 0 || (places & 4) != 0 || !is_xy) return "followed is a mirror of X and Y in the plane XY";
      frames_.inner = Eigen::Vector3d(places & 1 ? -1 : 1, places & 2 ? -1 : 1, 1).asDiagonal();
      frames_.inner_at_mm = at - frames_.inner * at;
      return "";
    case Meaning::kMoveOrigin:
      if (places != 0) return "with words of axes";
      frames_.moves_origin = true;
      return "";
    default:
      break;
  }
  if (!has_angle || (places != 0 && places != 7)) return "its words X, Y and Z, or I, J and K, are not complete";
  if ((code.detail & kAnglesXyz) != 0) {
    if ((angle.array() != 0).count() > 1) return "with more than one angle that is not zero";
    Tilt(About(0, angle[0]) * About(1, angle[1]) * About(2, angle[2]), at);
  } else {
    Tilt(About(2, angle[0]) * About(0, angle[1]) * About(2, angle[2]), at);
  }
  return "";
}

void Interpreter::Tilt(const Eigen::Matrix3d& plane, const Eigen::Vector3d& at_mm) {
  frames_.is_tilted = true;
  frames_.plane = plane;
  frames_.plane_at_mm = at_mm;
  axes_of_plane_problem_.clear();
}

bool Interpreter::FrameByRest(const std::string& name, const std::string& rest, uint32_t mode, Step* step,
                              std::string* problem) {
  blockers_seen_ |= mode;
  *problem = WhyNoFrame(mode, (mode & kTiltedPlanes) != 0);
  if (!problem->empty()) return false;
  *problem = mode == kFrame        ? TurnFrame(name, rest)
             : mode == kSwivel     ? Swivel(rest, step)
             : dialect_->has_poles ? TiltKlartext(name, rest, step)
                                   : "it is not followed";
  if (!problem->empty()) return false;
  modal_.blockers &= ~mode;
  modal_.tool_point |= mode;
  return true;
}

// 840D sl, Programming Manual Fundamentals, "Frames": ROT, MIRROR and SCALE replace all that frames stated before, the
// others add to it.
std::string Interpreter::TurnFrame(const std::string& name, const std::string& words) {
  const bool adds = name[0] == 'A';
  const std::string kind = adds ? name.substr(1) : name;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  const std::vector<std::string> parts = absl::StrSplit(words, ' ', absl::SkipEmpty());
  if (parts.empty()) return "it states nothing";
  for (const std::string& part : parts) {
    std::string letter;
    std::optional<double> value;
    if (!SplitWord(part, &letter, &value) || !value) return absl::StrCat("with '", part, "'");
    const int axis = letter.size() == 1 ? letter[0] - 'X' : -1;
    const bool is_xy = modal_.plane_normal == 2 && (modal_.uncertain & kPlaneGroup) == 0;
    if (kind == "ROT" && (letter == "RPL" ? is_xy : axis == 2)) {
      turn = About(2, *value);
    } else if (kind == "ROT" && (axis == 0 || axis == 1) && *value == 0) {
      continue;
    } else if (kind == "ROT") {
      return "it turns the plane away from the tool: followed is a rotation about Z, and CYCLE800";
    } else if (kind == "MIRROR" && (axis == 0 || axis == 1)) {
      turn(axis, axis) = -1.0;
    } else if (kind == "SCALE" && axis >= 0 && axis < 3 && *value >= kLeastScale && *value <= kMostScale) {
      turn(axis, axis) = *value;
    } else {
      return absl::StrCat("with '", part, "'");
    }
  }
  if (adds) {
    frames_.inner = Eigen::Matrix3d(frames_.inner * turn);
    return "";
  }
  for (int i = 0; i < axis_count_; ++i) ShiftFrame(i, 0);
  frames_.inner = turn;
  frames_.inner_at_mm.setZero();
  return "";
}

// 840D sl, Operating Manual Milling, "Swivel - CYCLE800": (retraction, data record, status, mode, X0, Y0, Z0, A, B, C,
// X1, Y1, Z1, direction, ...).
std::string Interpreter::Swivel(const std::string& arguments, Step* step) {
  if (arguments.size() < 2 || arguments.front() != '(' || arguments.back() != ')') return "its arguments are not read";
  std::vector<std::string> parts(1);
  bool is_quoted = false;
  for (size_t i = 1; i + 1 < arguments.size(); ++i) {
    const char c = arguments[i];
    is_quoted ^= c == '"';
    if (c == ',' && !is_quoted) {
      parts.emplace_back();
    } else {
      parts.back().push_back(c);
    }
  }
  parts.resize(std::max<size_t>(parts.size(), 14));
  std::array<double, 14> number{};
  for (size_t i = 0; i < number.size(); ++i) {
    if (i == 1 || parts[i].find_first_not_of(' ') == std::string::npos) continue;
    // The status is a row of digits (200000), of which the last says whether the plane is a new one.
    std::string part = parts[i];
    const size_t first = part.find_first_not_of(' ');
    if (i == 2 && part.find_first_not_of("0123456789", first) == std::string::npos && part.size() - first > 1)
      part = part.substr(part.size() - 1);
    const std::optional<Decimal> value = PlainNumber(part);
    if (!value) return absl::StrCat("its argument ", i + 1, ", '", parts[i], "', is no plain number");
    number[i] = ValueOf(*value);
  }
  if (modal_.is_inch) return "in inch: what its lengths count is not known";
  const int status = static_cast<int>(number[2]), mode = static_cast<int>(number[3]);
  if (status % 10 != 0) return "it adds to a plane in force (status)";
  if (mode < 0 || mode > 63) return "its mode turns otherwise than axis by axis: followed is 57, 27 and the like";
  Eigen::Matrix3d plane = Eigen::Matrix3d::Identity();
  int seen = 0;
  for (int k = 0; k < 3; ++k) {
    const int axis = (mode >> (2 * k) & 3) - 1;
    const double angle_deg = number[7 + static_cast<size_t>(k)];
    if (axis < 0 && angle_deg != 0) return "its mode names no axis for an angle";
    if (axis >= 0 && (seen >> axis & 1)) return "its mode turns about one axis twice";
    if (axis < 0) continue;
    seen |= 1 << axis;
    plane = Eigen::Matrix3d(plane * About(axis, angle_deg));
  }
  const Eigen::Vector3d before_mm(number[4], number[5], number[6]), behind_mm(number[10], number[11], number[12]);
  const Frames frames = frames_;
  Tilt(plane, before_mm + plane * behind_mm);
  if (number[13] == 0) return "";  // the axes stand
  std::string problem = TurnToPlane(0, false, step);
  if (!problem.empty()) frames_ = frames;
  return problem;
}

// TNC 640, User's Manual for Klartext Programming, "PLANE SPATIAL"; for Cycle Programming, cycles 8, 10, 11 and 19.
std::string Interpreter::TiltKlartext(const std::string& name, const std::string& words, Step* step) {
  const bool is_plane = name.rfind("PLANE", 0) == 0, is_cycle_19 = name == "CYCL DEF 19";
  const std::vector<std::string> parts = absl::StrSplit(words, ' ', absl::SkipEmpty());
  Eigen::Vector3d angle = Eigen::Vector3d::Zero();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  int sign = 0;
  bool turns = false, stays = false, goes_shorter = true, has_angle = false;
  for (size_t i = 0; i < parts.size(); ++i) {
    std::string word;
    std::optional<double> value;
    const std::string& part = parts[i];
    const bool is_read = SplitWord(part, &word, &value);
    const int axis = word.size() == 1 ? word[0] - 'X' : -1;
    if (name == "CYCL DEF 8") {
      if (!is_read || value || (axis != 0 && axis != 1)) return absl::StrCat("with '", part, "': followed are X and Y");
      turn(axis, axis) = -1.0;
    } else if (name == "CYCL DEF 10") {
      if (!is_read || word != "ROT" || !value || parts.size() > 1) return "its angle is no plain number";
      turn = About(2, *value);
    } else if (name == "CYCL DEF 11") {
      const std::string& last = parts.back();
      const std::optional<Decimal> apart = part == "SCL" && parts.size() == 2 ? PlainNumber(last) : std::nullopt;
      const double factor = apart                                                    ? ValueOf(*apart)
                            : is_read && word == "SCL" && value && parts.size() == 1 ? *value
                                                                                     : 0;
      if (factor < kLeastScale || factor > kMostScale) return "its factor is no plain number";
      turn = Eigen::Matrix3d::Identity() * factor;
      break;
    } else if (is_cycle_19 ? is_read && value && word.size() == 1 && word[0] >= 'A' && word[0] <= 'C'
                           : is_read && value && word.size() == 3 && word.rfind("SP", 0) == 0 && word[2] <= 'C') {
      angle[word.back() - 'A'] = *value;
      has_angle = true;
    } else if (is_plane && (part == "TURN" || part == "MOVE" || part == "STAY")) {
      (part == "STAY" ? stays : turns) = true;
    } else if (is_plane && (part == "SEQ+" || part == "SEQ-")) {
      sign = part == "SEQ+" ? 1 : -1;
    } else if (is_plane && (part == "SYM+" || part == "SYM-")) {
      goes_shorter = false;
    } else if (part == "FMAX" || part == "FAUTO" || part == "MAX" || (part == "ROT" && i > 0) || part == "TABLE" ||
               part == "COORD" || part == "MB" || part == "DIST" || part == "F" || part == "ABST") {
      continue;  // how it turns; what turns the coordinates about the tool is asked below
    } else if (is_read && value && (word == "F" || word == "DIST" || word == "MB" || word == "ABST")) {
      continue;
    } else if (PlainNumber(part) && i > 0 && (parts[i - 1] == "MB" || parts[i - 1] == "DIST" || parts[i - 1] == "F")) {
      continue;
    } else {
      return absl::StrCat("with '", part, "'");
    }
  }
  if (!is_plane && !is_cycle_19) {
    frames_.inner = turn;
    frames_.inner_at_mm.setZero();
    return "";
  }
  if (!has_angle) return "it states no angle";
  if (is_plane && turns == stays) return "which of TURN, MOVE and STAY it means is not known";
  const Frames frames = frames_;
  Tilt(About(2, angle[2]) * About(1, angle[1]) * About(0, angle[0]), Eigen::Vector3d::Zero());
  if (turns) {
    std::string problem = TurnToPlane(sign, goes_shorter, step);
    if (!problem.empty()) frames_ = frames;
    return problem;
  }
  // The rotary axes are turned by words: "L B+Q121 C+Q122 FMAX".
  AxisTicks at{};
  int free_axis = -1;
  axes_of_plane_problem_ = AxesOfPlane(sign, goes_shorter, &at, &free_axis);
  if (axes_of_plane_problem_.empty()) {
    if (free_axis >= 0)
      axes_of_plane_problem_ = absl::StrCat("the plane leaves open where ", machine_->axes[free_axis].name,
                                            " stands: state its angle as a number");
    for (int i = 0; i < 3; ++i) {
      const int axis = AxisOf(static_cast<char>('A' + i));
      const double value = axis < 0 ? 0.0 : static_cast<double>(at[axis]) / kTicksPerUnit;
      const bool is_known = axis < 0 || (axis != free_axis && !is_linear_[axis]);
      variables_.Set(absl::StrCat("Q", 120 + i), is_known ? std::optional<double>(value) : std::nullopt);
    }
  }
  // Whether cycle 19 turns them itself is the builder's to choose.
  for (int i = 0; is_cycle_19 && i < axis_count_; ++i) {
    if (is_linear_[i]) continue;
    ForgetPosition(i, false);
    step->frame.turned |= static_cast<uint16_t>(1u << i);
  }
  return "";
}

std::string Interpreter::AxesOfPlane(int sign, bool goes_shorter, AxisTicks* at, int* free_axis) const {
  const Eigen::Vector3d direction = frame_of_words_.InTable(Eigen::Vector3d(-frames_.plane.col(2)));
  const std::vector<AxisAngles> ways = ToolAlong(*machine_, direction);
  const bool is_level = (frames_.plane - Eigen::Matrix3d::Identity()).norm() < kSameTurn;
  const int master = MasterAxis(*machine_);
  constexpr double kTurnRad = 2.0 * std::numbers::pi;
  std::vector<AxisTicks> found;
  *free_axis = -1;
  for (const AxisAngles& way : ways) {
    std::vector<AxisTicks> places(1);
    for (int i = 0; i < axis_count_; ++i) {
      if (is_linear_[i]) continue;
      const machine::Axis& axis = machine_->axes[i];
      const double rad = way.position_rad[static_cast<size_t>(i)];
      const double here_rad = static_cast<double>(positions_.ticks[i]) / kTicksPerUnit * base::kRadPerDeg;
      std::vector<double> turned;
      if (axis.min_position && axis.max_position) {
        for (double k = std::ceil((*axis.min_position - rad - kSameTurn) / kTurnRad);
             rad + k * kTurnRad <= *axis.max_position + kSameTurn; k += 1.0)
          turned.push_back(rad + k * kTurnRad);
      } else if (axis.roll_over != machine::RollOver::kNone) {
        turned.push_back(rad < -kSameTurn ? rad + kTurnRad : rad);
      } else {
        turned.push_back(positions_.is_known(i) ? rad + kTurnRad * std::round((here_rad - rad) / kTurnRad) : rad);
      }
      if (i == way.free_axis) {
        turned = {0.0};
        // Nothing turns the coordinates about the tool: the axis stays, or goes to zero with Klartext.
        const bool is_zero = is_level && (dialect_->has_poles || (positions_.is_known(i) && positions_.ticks[i] == 0));
        if (!is_zero) *free_axis = i;
      }
      const std::vector<AxisTicks> before = std::move(places);
      places.clear();
      for (const AxisTicks& place : before) {
        for (const double value : turned) {
          if (i == master && ((sign > 0 && value < -kSameTurn) || (sign < 0 && value > kSameTurn))) continue;
          places.push_back(place);
          places.back()[i] = std::llround(value * base::kDegPerRad * kTicksPerUnit);
        }
      }
    }
    found.insert(found.end(), places.begin(), places.end());
  }
  return ChoosePlace(found, goes_shorter, at);
}

std::string Interpreter::ChoosePlace(const std::vector<AxisTicks>& found, bool goes_shorter, AxisTicks* at) const {
  if (found.empty()) return "no position of the rotary axes within their travel brings the tool to it";
  const auto travel = [&](const AxisTicks& place, int axis) {
    Ticks way = std::abs(place[axis] - positions_.ticks[axis]);
    const bool rolls_over = machine_->axes[axis].roll_over != machine::RollOver::kNone;
    if (rolls_over && !machine_->axes[axis].min_position) way = std::min(way % kTurn, kTurn - way % kTurn);
    return way;
  };
  // Of two that are as near in one axis the other axis decides, whatever a control weighs.
  const auto is_nearer = [&](const AxisTicks& a, const AxisTicks& b) {
    bool is_less = false;
    for (int i = 0; i < axis_count_; ++i) {
      if (is_linear_[i]) continue;
      if (!positions_.is_known(i) || travel(a, i) > travel(b, i) + kTicksPerMm / 1'000'000) return false;
      is_less |= travel(a, i) + kTicksPerMm / 1000 < travel(b, i);
    }
    return is_less;
  };
  for (const AxisTicks& place : found) {
    const bool is_chosen =
        found.size() == 1 || (goes_shorter && std::all_of(found.begin(), found.end(), [&](const AxisTicks& other) {
                                return &other == &place || is_nearer(place, other);
                              }));
    if (!is_chosen) continue;
    *at = place;
    return "";
  }
  std::string text;
  for (const AxisTicks& place : found) {
    if (!text.empty()) text += " or ";
    std::string words;
    for (int i = 0; i < axis_count_; ++i) {
      if (is_linear_[i]) continue;
      absl::StrAppend(&words, words.empty() ? "" : " ", machine_->axes[i].name);
      AppendFixed(RoundToGrains(place[i], kTicksPerMm / 1000), 3, false, false, &words);
    }
    text += words;
  }
  std::string unknown;  // the control goes by where they stand
  for (int i = 0; goes_shorter && i < axis_count_; ++i) {
    if (!is_linear_[i] && !positions_.is_known(i))
      absl::StrAppend(&unknown, unknown.empty() ? "" : ", ", machine_->axes[i].name);
  }
  const bool is_unknown = !unknown.empty();
  return absl::StrCat("several positions of the rotary axes bring the tool to it (", text,
                      "), and which the control takes is not known",
                      is_unknown ? ", since where " + unknown + " stood before is not known: " : ": ",
                      is_unknown ? "program it in front, or state --start, or " : "",
                      "turn the axes to one by words in front of it, or state travel limits in machine.json that leave "
                      "one",
                      dialect_->has_poles && frames_.is_tilted ? ", or SEQ" : "");
}

std::string Interpreter::TurnToPlane(int sign, bool goes_shorter, Step* step) {
  AxisTicks at{};
  int free_axis = -1;
  if (std::string problem = AxesOfPlane(sign, goes_shorter, &at, &free_axis); !problem.empty()) return problem;
  for (int i = 0; i < axis_count_; ++i) {
    if (is_linear_[i]) continue;
    const auto bit = static_cast<uint16_t>(1u << i);
    step->frame.turned |= bit;
    if (i == free_axis) {
      ForgetPosition(i, false);
      continue;
    }
    positions_.ticks[i] = at[i];
    positions_.sense[i] = 0;
    positions_.known |= bit;
  }
  for (const int axis : frame_of_words_.xyz()) {
    if (positions_.is_known(axis)) ForgetPosition(axis, false);
  }
  step->frame = {true, FrameChange::To::kSame, 0, coordinates_.length(), step->frame.turned};
  return "";
}

void Interpreter::PlaceWords(Request* request, Step* step) {
  const std::array<int, 3>& xyz = frame_of_words_.xyz();
  const auto refuse = [&](const std::string& reason) {
    LoseToolPoint();
    request->Refuse(reason);
  };
  if (request->mirror_off != nullptr && (modal_.tool_point & kMirror) != 0)
    refuse("one of two mirrored axes alone is no longer mirrored: end both, and state the other again");
  std::array<Ticks, 3> offsets{};
  for (size_t k = 0; k < 3; ++k) {
    const Ticks inner = dialect_->has_equals ? coordinates_.frame(xyz[k]) : 0;
    offsets[k] = coordinates_.WithoutLength(xyz[k]) - inner;
  }
  const std::shared_ptr<const WordFrame> before = request->word_frame_before;
  if (before != nullptr && (modal_.tool_point & kPlacedFrames) != 0 && offsets != placed_offsets_)
    refuse("the work offset or a shift changes while words are turned: end the turn in front of it");
  const uint32_t in_force = modal_.tool_point & kPlacedFrames;
  std::array<Ticks, 3> origins{};
  for (size_t k = 0; k < 3; ++k) origins[k] = offset(xyz[k]);
  const bool is_untouched = before != nullptr && before == word_frame_ && request->frame == nullptr &&
                            request->by_rest == nullptr && origins == placed_origins_ &&
                            in_force == (request->tool_point_before & kPlacedFrames) &&
                            request->length_before == coordinates_.active_length();
  if (is_untouched) return;
  if ((in_force & kTiltedPlanes) == 0) {
    const Frames turned = frames_;
    frames_ = Frames();
    frames_.inner = turned.inner, frames_.inner_at_mm = turned.inner_at_mm;
  }
  if ((in_force & kTurnedFrames) == 0) frames_.inner.setIdentity(), frames_.inner_at_mm.setZero();
  const bool in_table = frames_.is_tilted || frames_.moves_origin;
  coordinates_.SetToolPoint(in_table);
  WordFrame now;
  if (in_force != 0) {
    placed_offsets_ = offsets;
    for (size_t k = 0; k < 3; ++k) placed_origins_[k] = offset(xyz[k]);
    Eigen::Vector3d origin_mm, shift_mm = Eigen::Vector3d::Zero();
    for (size_t k = 0; k < 3; ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      origin_mm[row] = static_cast<double>(offset(xyz[k])) / kTicksPerUnit;
      if (dialect_->has_equals) shift_mm[row] = static_cast<double>(coordinates_.frame(xyz[k])) / kTicksPerUnit;
    }
    now.base = frames_.is_tilted      ? WordFrame::Base::kTable
               : frames_.moves_origin ? WordFrame::Base::kOrigin
                                      : WordFrame::Base::kAxes;
    now.linear = frames_.plane * frames_.inner;
    now.inverse = now.linear.inverse();
    now.up = frames_.plane.col(2);
    now.shift_mm = origin_mm - shift_mm + frames_.plane_at_mm + frames_.plane * (shift_mm + frames_.inner_at_mm) -
                   now.linear * origin_mm;
    if (frames_.moves_origin) now.shift_mm = origin_mm;
    const Eigen::Matrix3d squared = now.linear.transpose() * now.linear;
    const double largest = std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(squared).eigenvalues().maxCoeff());
    now.scale = std::abs(largest - 1.0) < kSameFrame ? 1.0 : largest;
    now.keeps_circles = std::abs(squared(0, 0) - squared(1, 1)) + std::abs(squared(0, 1)) < kSameTurn * squared(0, 0);
  }
  const bool was_in_table = before != nullptr && before->base != WordFrame::Base::kAxes;
  const WordFrame was = before != nullptr ? *before : WordFrame();
  const bool is_same_base = was.base == now.base;
  const Eigen::Matrix3d change = now.inverse * was.linear;
  const Eigen::Vector3d moved_mm = now.inverse * (was.shift_mm - now.shift_mm);
  const bool is_longer = in_table && request->length_before != coordinates_.active_length();
  uint16_t kept = 0;
  for (size_t k = 0; k < 3; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const Eigen::Vector3d unit = Eigen::Vector3d::Unit(row);
    const bool is_same = (change.row(row).transpose() - unit).norm() < kSameFrame && std::abs(moved_mm[row]) < 1e-9;
    // Between frames of the workpiece positions are followed only where nothing changes.
    if (is_same_base && is_same && !(is_longer && k == 2)) kept |= static_cast<uint16_t>(1u << xyz[k]);
  }
  const auto all = static_cast<uint16_t>(1u << xyz[0] | 1u << xyz[1] | 1u << xyz[2]);
  if (in_table && kept != all &&
      !(is_longer && (change - Eigen::Matrix3d::Identity()).norm() < kSameFrame && moved_mm.norm() < 1e-9))
    kept = 0;
  word_frame_ = in_force != 0 ? std::make_shared<const WordFrame>(now) : nullptr;
  if (kept == all && was_in_table == in_table) return;
  AxisTicks traced = positions_.ticks;
  const bool is_traced = Trace(*request, before.get(), &traced);
  for (const int axis : xyz) {
    const auto bit = static_cast<uint16_t>(1u << axis);
    if ((kept & bit) != 0) continue;
    positions_.sense[axis] = 0;
    needs_absolute_ |= bit;
    if (positions_.is_known(axis)) ForgetPosition(axis, false);
    if (!is_traced) continue;
    positions_.ticks[axis] = traced[axis];
    traced_ |= bit;
  }
  pole_.is_known = false;
  is_tool_length_asked_ = false;
  if (in_table != was_in_table) modal_.called = DrillCycle();
  if (modal_.motion == Meaning::kDrillCycle) {
    modal_.motion = Meaning::kOtherMotion;
    modal_.motion_text = "a drilling cycle in which the frame of its words changed";
    modal_.cycle = DrillCycle();
  }
  if (in_table && !has_noted_tilt_) {
    has_noted_tilt_ = true;
    step->note = RemarkAt(line_, "tilted-plane",
                          "tilted plane: the control's kinematics are taken as machine.json's nominal chain, the work "
                          "offset as that of the table at zero");
  }
  step->frame = {true, FrameChange::To::kSame, kept, coordinates_.length(), step->frame.turned};
}

bool Interpreter::Trace(const Request& request, const WordFrame* before, AxisTicks* ticks) const {
  const auto known = static_cast<uint16_t>(positions_.known | traced_);
  if (known != (1u << axis_count_) - 1 || !request.problem.empty() ||
      request.length_before != coordinates_.active_length())
    return false;
  const double length_mm = static_cast<double>(coordinates_.length()) / kTicksPerUnit;
  std::array<double, machine::kMaxAxes> values{};
  for (int i = 0; i < axis_count_; ++i)
    values[i] = static_cast<double>((*ticks)[i]) / kTicksPerUnit * (is_linear_[i] ? 1.0 : base::kRadPerDeg);
  if (before != nullptr && !frame_of_words_.ToAxes(length_mm, before, values.data())) return false;
  if (word_frame_ != nullptr && !frame_of_words_.ToWords(length_mm, word_frame_.get(), values.data())) return false;
  for (const int axis : frame_of_words_.xyz()) (*ticks)[axis] = std::llround(values[axis] * kTicksPerUnit);
  return true;
}

bool Interpreter::KeepsPlane(Step* step) {
  bool turns = false, is_known = true;
  for (int i = 0; i < axis_count_; ++i) {
    if (is_linear_[i]) continue;
    is_known &= step->end.is_known(i);
    turns |= step->word_of_axis[i] >= 0 &&
             (!step->start.is_known(i) || !step->end.is_known(i) || step->start.ticks[i] != step->end.ticks[i]);
  }
  if (turns && !step->is_rapid) {
    Unsupported("a feed move that turns rotary axes in a tilted plane: turn them by a rapid move of their own", false,
                step);
    return false;
  }
  bool names_linear = false;
  for (const int axis : frame_of_words_.xyz()) {
    names_linear |= step->word_of_axis[axis] >= 0;
    if (!turns || step->word_of_axis[axis] >= 0) continue;
    // It stands while the table turns the words away under it.
    ForgetPosition(axis, false);
    step->end.known &= static_cast<uint16_t>(~(1u << axis));
  }
  const bool is_turning_alone = turns && !names_linear;
  if (word_frame_->base != WordFrame::Base::kTable || !is_known || is_turning_alone) return true;
  if (frame_of_words_.Lean(step->end.ticks, *word_frame_) <= kMostLeanRad) return true;
  Unsupported(
      "the tool does not stand upright to the tilted plane: turn the rotary axes to it in front (G53.1, TURN, or words "
      "of these axes)",
      false, step);
  return false;
}

}  // namespace axiscal::nc
