// What the words of a block ask for: codes change the modal state at once, what acts on axis words waits for `Act`.
#include <algorithm>
#include <cstring>

#include "core/nc/char_class.h"
#include "core/nc/request.h"

namespace axiscal::nc {
namespace {

bool IsCapitalOrDigit(char c) { return (Capital(c) >= 'A' && Capital(c) <= 'Z') || (c >= '0' && c <= '9'); }

}  // namespace

std::string WordText(const Word& word) {
  std::string text(1, word.letter);
  AppendFixed(word.number.mantissa, word.number.decimals, false, word.number.has_point, &text);
  return text;
}

const Interpreter::Code& Interpreter::Find(const Word& word) const {
  static const Code kUnknown = {Meaning::kUnknown, 0, "unknown code"}, kStatedHarmless = {Meaning::kHarmless, 0, ""};
  if (word.letter == 'M' && word.number.decimals == 0 && word.number.mantissa >= 0 &&
      word.number.mantissa < static_cast<int64_t>(is_stated_harmless_.size()) &&
      is_stated_harmless_[static_cast<size_t>(word.number.mantissa)])
    return kStatedHarmless;
  int64_t tenths = word.number.mantissa;
  int decimals = word.number.decimals;
  for (; decimals > 1 && tenths % 10 == 0; --decimals) tenths /= 10;
  if (decimals > 1) return kUnknown;
  if (decimals == 0 && tenths < kCodes) tenths *= 10;
  if (tenths < 0 || tenths >= kCodes) return kUnknown;
  return (word.letter == 'G' ? dialect_->g_codes : dialect_->m_codes)[static_cast<size_t>(tenths)];
}

bool Interpreter::IsMotionCode(const Word& word) const {
  if (word.letter != 'G' || RoleOf('G') != Role::kCode) return false;
  switch (Find(word).meaning) {
    case Meaning::kRapid:
    case Meaning::kLinear:
    case Meaning::kArc:
    case Meaning::kCancelMotion:
    case Meaning::kDrillCycle:
    case Meaning::kOtherMotion:
      return true;
    default:
      return false;
  }
}

bool Interpreter::IsArcCode(const Word& word) const {
  return IsMotionCode(word) && Find(word).meaning == Meaning::kArc;
}

void Interpreter::ScanWords(const Block& block, Request* request, Step* step) {
  step->word_of_axis.fill(-1);
  for (int i = 0; i < block.word_count; ++i) {
    const Word& word = block.words[static_cast<size_t>(i)];
    if (word.letter == 0) {
      ScanKeyword(block, word, request, step);
      continue;
    }
    const size_t letter = static_cast<size_t>(word.letter - 'A');
    const Role role = roles_[letter];
    step->has_other_words |= role != Role::kLineNumber && role != Role::kProgramNumber;
    switch (role) {
      case Role::kCode:
        ScanCode(word, Find(word), request, step);
        break;
      case Role::kAxis: {
        if (axis_of_letter_[letter] < 0) {
          if (request->foreign_axis == 0) request->foreign_axis = word.letter;
          break;
        }
        int8_t& index = step->word_of_axis[static_cast<size_t>(axis_of_letter_[letter])];
        if (index >= 0) request->Refuse(absl::StrCat("two words ", std::string(1, word.letter), " in one block"));
        index = static_cast<int8_t>(i);
        request->has_axis = true;
        break;
      }
      case Role::kParameter:
        if (is_followed_call_) break;  // of the call
        if (request->parameter == 0) {
          request->parameter = word.letter;
          if (word.letter == 'P') request->number_of_parameter = &word;
        }
        break;
      case Role::kProgramNumber:
        // "o100 while ..." of LinuxCNC names no program.
        if (i + 1 == block.word_count || block.words[static_cast<size_t>(i) + 1].letter != 0) StartProgram();
        break;
      case Role::kToolLength:
      case Role::kActiveToolLength:
        request->length_number = &word;
        break;
      case Role::kToolRadius:
        request->radius_number = &word;
        break;
      case Role::kCentre:
        request->has_centre = true;
        request->centre[letter - ('I' - 'A')] = &word;
        break;
      case Role::kRadius:
        request->radius = &word;
        break;
      case Role::kRadiusCompensation:
        // Of the arc that touches the contour.
        if (request->departs || request->IsOfContour(kApproach) || request->IsOfContour(kDeparture)) break;
        if (word.number.mantissa != 0) request->Refuse("word R other than R0");
        EndMode(kCutterCompensation);
        break;
      case Role::kLineNumber:
        NoteNumber(word);
        break;
      case Role::kPassive:
        break;
      case Role::kFeed:
        request->has_feed = true;
        break;
      case Role::kToolNumber:
        called_tool_ = word.number.mantissa;
        is_called_tool_sure_ = !block.is_deletable || options_->block_delete != BlockDelete::kEither;
        request->may_switch_offset = word.number.digits >= 3 && word.number.mantissa % 100 != 0;
        break;
    }
  }
}

void Interpreter::ScanKeyword(const Block& block, const Word& word, Request* request, Step* step) {
  const Keyword& keyword = dialect_->keywords[static_cast<size_t>(word.keyword)];
  step->has_other_words |= keyword.meaning != Meaning::kHead;
  if (keyword.meaning == Meaning::kHead) {
    StartProgram();
    if (word.says_inch || word.says_mm) {
      modal_.is_inch = word.says_inch;
      modal_.uncertain &= static_cast<uint8_t>(~kUnitGroup);
      (word.says_inch ? says_inch_ : says_mm_) = true;
    }
    return;
  }
  if (keyword.meaning == Meaning::kToolChange && dialect_->tool_call_sets_length)
    return CallTool(block, word, request, step);
  ScanCode(word, dialect_->keyword_codes[static_cast<size_t>(word.keyword)], request, step);
}

// TOOL CALL: without a number or a name only speed, feed or the length's difference change.
void Interpreter::CallTool(const Block& block, const Word& word, Request* request, Step* step) {
  const bool names_tool = word.number.digits > 0 || word.number.has_plus;
  const bool has_difference = block.length_difference.digits > 0;
  const bool has_radius = block.radius_difference.digits > 0 || block.has_odd_radius;
  if (has_radius) LoseCutter();
  if (!names_tool && !has_difference && !has_radius && !word.number.has_point) return;
  const int number =
      word.number.digits == 0 || word.number.mantissa > 9999 ? -1 : static_cast<int>(word.number.mantissa);
  const std::optional<Ticks> difference =
      ToTicks(block.length_difference, modal_.is_inch ? kTicksPerInch : kTicksPerMm);
  step->is_tool_change |= names_tool;
  if (names_tool) called_tool_ = number, is_called_tool_sure_ = !block_may_be_skipped_;
  // Whether a tilted plane goes on with another tool is not known.
  if ((names_tool || has_difference) && (modal_.tool_point & ~kTurnedFrames) != 0) LoseToolPoint();
  if (names_tool) request->away = "tool change";
  std::string problem;
  if (word.number.has_point || !difference || std::abs(*difference) > kTicksPerMm * 1000) {
    problem = "TOOL CALL with an index, a tool axis other than Z or a difference DL that is no length: not followed";
  } else if (names_tool) {
    EndMode(kUnstatedLength);
    if (!coordinates_.SelectLength(number, 1)) {
      problem = number < 0 ? "tool call by name: the tool's length is not stated"
                           : absl::StrCat("TOOL CALL ", number, ": the tool's length is not stated");
    }
  }
  if (problem.empty() && has_difference) problem = UnitProblem();
  if (names_tool) radius_difference_ = 0;
  if (block.has_odd_radius) {
    radius_difference_ = std::nullopt;
  } else if (block.radius_difference.digits > 0) {
    radius_difference_ = ToTicks(block.radius_difference, modal_.is_inch ? kTicksPerInch : kTicksPerMm);
  }
  if (problem.empty()) {
    if (has_difference) coordinates_.SetLengthDifference(*difference);
    return;
  }
  coordinates_.DropLength();
  modal_.blockers |= kUnstatedLength;
  request->Refuse(problem);
}

void Interpreter::ScanCode(const Word& word, const Code& code, Request* request, Step* step) {
  request->has_code = true;
  const auto named = [&] {
    const std::string name =
        word.letter == 0 ? dialect_->keywords[static_cast<size_t>(word.keyword)].name : WordText(word);
    return absl::StrCat(name, " (", code.text, ")");
  };
  const auto feed = [&](FeedMode mode) {
    request->Choose(&request->feed, code, "feed mode");
    request->stated |= kFeedGroup;
    modal_.lacks_feed |= modal_.feed_mode != mode;
    modal_.feed_mode = mode;
  };
  const auto distance = [&](bool is_incremental) {
    request->Choose(&request->distance, code, "distance (G90, G91)");
    request->stated |= kDistanceGroup;
    modal_.is_incremental = is_incremental;
  };
  const auto unit = [&](bool is_inch) {
    request->Choose(&request->unit, code, "unit");
    request->stated |= kUnitGroup;
    modal_.is_inch = is_inch;
    (is_inch ? says_inch_ : says_mm_) = true;
  };
  switch (code.meaning) {
    case Meaning::kUnknown:
      modal_.blockers |= kUnfollowedMode;  // it may be modal, and nothing is known that ends it
      if (word.letter == 'M') {
        NoteCall();
        const std::string name = WordText(word);
        const std::string ask =
            word.number.decimals == 0 ? ", if it does neither, state --harmless-m " + name.substr(1) : std::string();
        return request->Refuse(absl::StrCat(name, ": it may start a macro or move axes", ask));
      }
      return request->Refuse(named() + ": it might move axes");
    case Meaning::kHarmless:
      // An M code of the machine's builder, which the user states as harmless: it may clamp the axis behind its move.
      step->ends_block |= word.letter == 'M' && *code.text == 0;
      if (word.letter == 'M' && word.number.mantissa == 61) is_loaded_tool_known_ = false;  // M61 Q3 of LinuxCNC
      if (word.letter == 0 && code.detail == kDefines) {
        modal_.called = DrillCycle();  // or Q parameters, which may be those of the definition
        defined_ = nullptr;
      }
      if (word.letter == 0 && code.detail == kMaySetTransformation && !KeepsTransformation(word)) {
        LoseToolPoint();
        modal_.turns_by_vector = true;
      }
      return;
    case Meaning::kLimits:
      request->owner = &code;
      return;
    case Meaning::kHead:
    case Meaning::kAddress:
    case Meaning::kIncrementalAddress:
      return;
    case Meaning::kPole:
      request->is_pole = true;
      return;
    case Meaning::kArcSense:
      request->sense = &code;
      return;
    case Meaning::kTurns:
      if (word.number.mantissa == 0) return;  // "TURN=0": the arc alone
      step->is_curve = true;
      return request->Refuse(named());
    case Meaning::kCorner:
      if (leaves_corners_) return;
      if (code.detail == 0) {
        request->has_corner = true;
      } else {
        rounds_corners_ = word.number.mantissa != 0;
      }
      return;
    case Meaning::kRapid:
    case Meaning::kLinear:
    case Meaning::kArc:
    case Meaning::kOtherMotion:
    case Meaning::kDrillCycle:
    case Meaning::kCancelMotion:
      // G00 G80 at the begin of programs: the cycle ends, and the other code is in force.
      if (request->motion != nullptr && code.meaning == Meaning::kCancelMotion) return;
      if (request->motion != nullptr && request->motion->meaning != Meaning::kCancelMotion)
        request->Refuse("two motion codes in one block");
      request->motion = &code;
      request->stated |= kMotionGroup;
      if (request->IsOfContour(kDeparture)) EndMode(kCutterCompensation);
      if (code.meaning != Meaning::kOtherMotion) return;
      step->is_curve = code.detail == kCurve;
      step->is_tangential = code.detail == kTangential;
      return request->Refuse(named());
    case Meaning::kCallCycle:
      if (request->cycle_call != nullptr) request->Refuse("two calls of a cycle in one block");
      request->cycle_call = &code;
      request->cycle_call_word = &word;
      return;
    case Meaning::kDefineCycle:
      modal_.called = DrillCycle();
      defined_ = &code;
      definition_ = {};
      return;
    case Meaning::kSelectDatum:
      if (block_may_be_skipped_) {
        modal_.blockers |= kUnstatedOffset;
        return request->Refuse(named() + " in a block that may be skipped: which datum is in force is not known");
      }
      step->begins_definition = true;
      defined_ = &code;
      return;
    case Meaning::kReturnLevel:
      modal_.returns_to_entry = code.detail == 1;
      modal_.is_return_unsure = false;
      return;
    case Meaning::kRapidBlock:
      request->is_rapid_block = true;
      return;
    case Meaning::kOneShot:
      step->is_curve |= code.detail == kCurve;
      step->is_tangential |= code.detail == kTangential;
      return request->Refuse(named());
    case Meaning::kCall:
      if (is_followed_call_) return;
      NoteCall();
      request->is_call = true;
      request->is_local_call |= word.letter == 'M' && word.number.mantissa == 97;
      if (code.detail == 1) modal_.uncertain = kAllGroups | kCentreGroup, modal_.blockers |= blockers_seen_;
      return request->Refuse(named());
    case Meaning::kJump:
      request->is_jump = true;
      return request->Refuse(named());
    case Meaning::kDataInput:
      if (code.detail == kWorkOffsetInput) {
        request->data_input = &code;
        return;
      }
      ForgetStated();
      return request->Refuse(named());
    case Meaning::kMachineMove:
      request->machine_move = &code;
      step->reason = named();
      return;
    case Meaning::kDwell:
      request->is_dwell = true;
      return;
    case Meaning::kSpeedMode:
      request->speed_mode = &word;
      return;
    case Meaning::kInch:
      return unit(true);
    case Meaning::kMillimetre:
      return unit(false);
    case Meaning::kAbsolute:
      return distance(false);
    case Meaning::kIncremental:
      return distance(true);
    case Meaning::kCentreAbsolute:
    case Meaning::kCentreIncremental:
      request->stated |= kCentreGroup;
      modal_.are_centres_absolute = code.meaning == Meaning::kCentreAbsolute;
      return;
    case Meaning::kPlane:
      if (request->plane != nullptr && request->plane->detail != code.detail)
        request->Refuse("two different plane codes in one block");
      request->plane = &code;
      request->stated |= kPlaneGroup;
      modal_.plane_normal = static_cast<int8_t>(code.detail);
      return;
    case Meaning::kShorterWay:
      modal_.way = code.detail == 1 ? Way::kShorter : Way::kOfAxis;
      return;
    case Meaning::kFeedPerMinute:
      return feed(FeedMode::kPerMinute);
    case Meaning::kFeedInverseTime:
      return feed(FeedMode::kInverseTime);
    case Meaning::kFeedPerTurn:
      return feed(FeedMode::kPerTurn);
    case Meaning::kWorkOffset:
    case Meaning::kNoWorkOffset:
      if (request->offset != nullptr) {
        request->Refuse("two work offsets in one block");
        request->has_two_offsets = true;
      }
      request->offset = &word;
      request->offset_code = &code;
      request->stated |= kOffsetGroup;
      return;
    case Meaning::kToolLength:
      LoseControl();  // whether it goes on with the length is not known
      request->length = &code;
      request->stated |= kLengthGroup;
      return;
    case Meaning::kNoToolLength:
      coordinates_.DropLength();
      NeedAbsoluteZ();
      EndMode(kToolControl | kUnstatedLength | code.detail);
      request->stated |= kLengthGroup;
      return;
    case Meaning::kToolPoint:
      request->tool_point = &code;
      request->tool_point_word = &word;
      if ((code.detail & kSelectsLength) == 0) return;
      request->length = &code;
      request->stated |= kLengthGroup;
      return;
    case Meaning::kToolVector:
      if (request->vector[code.detail] != nullptr) request->Refuse("two words " + named() + " in one block");
      request->vector[code.detail] = &word;
      return;
    case Meaning::kSurfaceNormal:
      request->has_normal = true;
      return;
    case Meaning::kTurnByVector:
      modal_.turns_by_vector = code.detail == 1;
      return;
    case Meaning::kPreset:
      request->preset = &code;
      return;
    case Meaning::kLocalShift:
      request->shift = &code;
      return;
    case Meaning::kDepart:
      request->departs = true;
      EndMode(kCutterCompensation);
      modal_.is_cutter_ending = false;
      return;
    case Meaning::kCutterSide:
      request->Choose(&request->cutter_side, code, "side of cutter compensation");
      if (request->cutter_side->detail != code.detail) request->Refuse("two sides of cutter compensation in one block");
      return;
    case Meaning::kBlockerOn:
      modal_.blockers |= code.detail;
      if (code.detail == kMirror) request->mirror_on = &code;
      if (code.detail == kModalMacro && modal_.macro_depth < 255) ++modal_.macro_depth;
      if (code.detail == kModalMacro) NoteCall(), request->is_call = true;
      if (code.detail == kKinematics && word.letter == 'M') {
        const std::string name = WordText(word);
        return request->Refuse(absl::StrCat(
            named(),
            ": to which ones only the machine's ini file says; where they are those of axis positions, state "
            "--harmless-m ",
            name.substr(1), ", and post what runs under others as axis positions"));
      }
      return request->Refuse(named());
    case Meaning::kMirrorOn:
      request->mirror_on = &code;
      [[fallthrough]];
    case Meaning::kRotate:
    case Meaning::kTilt:
    case Meaning::kScale:
    case Meaning::kMoveOrigin:
      request->Choose(&request->frame, code, "frame");
      request->frame_word = &word;
      return;
    case Meaning::kTurnToPlane:
      request->turn_to_plane = &code;
      step->reason = named();
      return;
    case Meaning::kBlockerByRest:
      request->by_rest = &code;
      request->by_rest_word = &word;
      return;
    case Meaning::kBlockerOff:
      if (code.detail == kMirror) {
        request->owner = request->mirror_off = &code;
        return;
      }
      if (code.detail & modal_.blockers & kModalMacro) {
        MayHaveChanged(kCalledGroups);  // by the macro
        if (modal_.macro_depth > 1) {
          --modal_.macro_depth;
          return;
        }
        modal_.macro_depth = 0;
      }
      if (dialect_->transformation_may_drop_offset &&
          (code.detail & (modal_.blockers | modal_.tool_point) & kToolControl) != 0)
        modal_.uncertain |= kOffsetGroup;
      EndMode(code.detail);
      return;
    case Meaning::kScalingOffOrPreset:
      request->scaling_off = &code;
      return;
    case Meaning::kToolChange:
      step->is_tool_change = true;
      LoseToolPoint();
      request->away = code.text;
      request->goes_away_behind = code.detail == kBehindMove;
      // Without a D word the first length of the tool acts.
      if (roles_['D' - 'A'] == Role::kActiveToolLength) modal_.uncertain |= kLengthGroup;
      return;
    case Meaning::kAxesAway:
      request->away = code.text;
      request->changes_pallet = true;
      LoseToolPoint();
      EndMode(code.detail);
      return;
    case Meaning::kEndOfProgram:
      if (code.detail == 1 && is_followed_return_) {
        step->ends_block = true;
        return;
      }
      request->is_end = step->ends_block = true;
      request->is_subprogram_end |= code.detail == 1;
      return;
    case Meaning::kEndOfBlock:
      step->ends_block = true;
      return;
  }
}

// "CYCLE832(0.01,_ORI_FINISH,0.1)": named kinds of machining leave transformations as they are. In numbers of older
// controls a digit switches them.
bool Interpreter::KeepsTransformation(const Word& word) const {
  static constexpr const char* kKinds[] = {"_OFF",        "_FINISH",      "_SEMIFIN",  "_ROUGH",
                                           "_ORI_FINISH", "_ORI_SEMIFIN", "_ORI_ROUGH"};
  const std::string rest = RestOf(text_ + word.end, end_of_text_);
  const size_t begin = rest.find(',');
  if (begin == std::string::npos) return false;
  const std::string kind = rest.substr(begin + 1, rest.find_first_of(",)", begin + 1) - begin - 1);
  return std::any_of(std::begin(kKinds), std::end(kKinds), [&](const char* known) { return kind == known; });
}

// "C X+20 Y+10 DR-".
void Interpreter::SelectSense(Request* request) {
  const bool is_arc = request->motion->meaning == Meaning::kArc;
  if (!is_arc && request->sense != nullptr) request->Refuse("the sense of an arc without one");
  if (!is_arc) return;
  if (request->sense == nullptr) return request->Refuse("a circular move without DR");
  if (!request->has_axis) return request->Refuse("a circular move without a word of X or Y");
  modal_.is_clockwise = request->sense->detail != 0;
}

// "G5 P2" alone: the path stays that of the blocks. Any other number calls a cycle, and axis words make it a spline.
void Interpreter::SelectSpeedMode(Request* request) {
  const Word* const number = request->number_of_parameter;
  const bool is_mode =
      request->parameter == 'P' && number != nullptr && number->number.decimals == 0 &&
      (number->number.mantissa == 0 || number->number.mantissa == 2 || number->number.mantissa == 10000);
  if (is_mode && !request->has_axis && request->foreign_axis == 0 && !request->has_centre) {
    request->parameter = 0;
    return;
  }
  modal_.motion = Meaning::kOtherMotion;
  modal_.motion_text = Find(*request->speed_mode).text;
  request->Refuse(absl::StrCat(WordText(*request->speed_mode), " (", modal_.motion_text, ")"));
}

bool Interpreter::LeavesNumber(const Block& block) const {
  for (const Word& word : block) {
    if (RoleOf(word.letter) != Role::kCode) continue;
    if (IsPlainMode(Find(word).meaning)) continue;
    switch (Find(word).meaning) {
      case Meaning::kArc:
      case Meaning::kCancelMotion:
      case Meaning::kWorkOffset:
      case Meaning::kToolLength:
      case Meaning::kNoToolLength:
      case Meaning::kBlockerOff:
        break;
      case Meaning::kHarmless:
        if (word.letter == 'G') return false;  // G64 P0.01, G8 P1
        [[fallthrough]];
      case Meaning::kEndOfBlock:
        if (Find(word).detail == kReadsNumber) return false;  // M64 P0
        break;
      default:
        return false;
    }
  }
  return true;
}

void Interpreter::SelectOffset(const char* text, const Block& block, Request* request) {
  std::string name;
  const bool is_next = request->number_of_parameter == request->offset + 1;  // "G54 P2"
  // Where P may choose the spindle of M3, or be a second number of an M code.
  const bool may_be_of_m =
      !is_next && std::any_of(block.begin(), block.end(), [](const Word& word) { return word.letter == 'M'; });
  if (request->offset_code->meaning == Meaning::kWorkOffset) {
    name = WordText(*request->offset);
    const bool is_numbered =
        request->parameter == 'P' && request->number_of_parameter != nullptr && LeavesNumber(block);
    const bool may_be_numbered =
        block.problem != LexProblem::kNone &&
        std::any_of(text + block.problem_at, end_of_text_, [](char c) { return Capital(c) == 'P'; });
    if (request->offset_code->detail != 1 && (is_numbered || may_be_numbered)) {
      if (request->offset_code->detail != kOffsetMayHaveNumber || may_be_numbered || may_be_of_m) {
        modal_.blockers |= kUnstatedOffset;
        return request->Refuse(name + " with a P word: which offset it selects is not known");
      }
      name = absl::StrCat(name, ".1 ", WordText(*request->number_of_parameter));
      request->parameter = 0;
    } else if (request->offset_code->detail == 1) {
      if (request->parameter != 'P' || request->number_of_parameter == nullptr) {
        modal_.blockers |= kUnstatedOffset;  // it selects one, which is not known
        return request->Refuse(name + " without a P word");
      }
      if (!is_next && !LeavesNumber(block)) {
        modal_.blockers |= kUnstatedOffset;
        return request->Refuse(name + " without a P word of its own: which offset it selects is not known");
      }
      absl::StrAppend(&name, " ", WordText(*request->number_of_parameter));
      request->parameter = 0;
    }
  }
  // Whether a programmable frame goes on with another work offset is not known.
  if (coordinates_.has_frame()) modal_.blockers |= kFrame;
  const AxisTicks before = coordinates_.offsets();
  const bool is_stated = coordinates_.Select(name);
  for (int i = 0; i < axis_count_ && dialect_->g91_takes_new_offsets; ++i) {
    if (coordinates_.Offset(i) != before[i]) needs_absolute_ |= static_cast<uint16_t>(1u << i);
  }
  if (is_stated && !request->has_two_offsets) {
    EndMode(kUnstatedOffset);
    return;
  }
  modal_.blockers |= kUnstatedOffset;
  if (request->has_two_offsets) return;
  const bool was_stated = std::any_of(options_->work_offsets.begin(), options_->work_offsets.end(),
                                      [&name](const WorkOffset& stated) { return stated.code == name; });
  constexpr char kNoValues[] = "its values are not stated";
  request->Refuse(
      absl::StrCat(name, " (", request->offset_code->text, "): ", was_stated ? WhyNotStated(kNoValues) : kNoValues));
}

std::string Interpreter::WhyNotStated(const std::string& what) const {
  if (forgot_stated_line_ == 0) return what;
  return absl::StrCat(
      "line ", forgot_stated_line_,
      " may have measured or set it anew: what was stated holds in front of that line; make what stands "
      "behind it a program of its own");
}

bool Interpreter::MayJumpBack(const char* text, const Block& block, const Request& request) const {
  if (numbers_seen_.empty()) return false;
  // Blocks that call are not read here: their numbers are not among those seen.
  const bool may_be_call = !stops_at_calls_;
  // M99 P10, M97 P10 of Haas.
  if (request.number_of_parameter != nullptr && (request.is_end || request.is_local_call)) {
    const Decimal& number = request.number_of_parameter->number;
    if (number.decimals > 0 || (may_be_call && request.is_end) || MayBeSeen(number.mantissa)) return true;
  }
  for (const Word& word : block) {
    if (word.letter != 0) continue;
    // "REPEAT LABEL P=3" of Sinumerik runs what stands in front of it again.
    const bool has_label = word.end < end_of_text_ - text && text[word.end] == ' ' &&
                           std::find_if(text + word.end, end_of_text_,
                                        [](char c) { return IsCapitalOrDigit(c) || c == ';'; }) != end_of_text_;
    const char* const name = dialect_->keywords[static_cast<size_t>(word.keyword)].name;
    if (dialect_->has_equals && has_label && std::strcmp(name, "REPEAT") == 0) return true;
  }
  static constexpr char kGoto[] = {'G', 'O', 'T', 'O'};
  const auto same = [](char a, char b) { return Capital(a) == b; };
  for (const char* at = text; (at = std::search(at, end_of_text_, kGoto, kGoto + 4, same)) != end_of_text_;) {
    at += 4;
    if (dialect_->has_equals && at != end_of_text_ && Capital(*at) == 'F') continue;  // forwards
    while (at != end_of_text_ && *at == ' ') ++at;
    int64_t number = 0;
    const char* digit = at;
    for (; digit != end_of_text_ && *digit >= '0' && *digit <= '9' && number < 1'000'000; ++digit)
      number = 10 * number + (*digit - '0');
    if (digit == at || may_be_call || MayBeSeen(number)) return true;
  }
  return false;
}

void Interpreter::NoteCall() {
  LoseCutter();
  last_radius_number_ = -1;
  variables_.ForgetAll();
  modal_.called = DrillCycle();
  MayHaveChanged(kCalledGroups);
  has_called_ = true;
  is_loaded_tool_known_ = false;
  blockers_at_calls_ |= modal_.blockers | modal_.tool_point;
  LoseToolPoint();  // what is called may end it
  if (coordinates_.has_frame()) {
    modal_.blockers |= dialect_->has_poles ? kDatumShift : kFrame;
    modal_.shifted_axes = kAllAxes;
  }
  modal_.turns_by_vector = dialect_->transformation_may_drop_offset;
  if (coordinates_.has_shift() || coordinates_.has_preset() || coordinates_.has_frame()) blockers_at_calls_ |= kShift;
}

void Interpreter::ForgetStated() {
  forgot_stated_line_ = line_;
  modal_.blockers |= kUnstatedOffset;
  if (coordinates_.active_length() >= 0) modal_.blockers |= kUnstatedLength;
  coordinates_.ForgetStated();
}

void Interpreter::SelectMirror(const Request& request, bool is_whole, const Step& step) {
  if (request.mirror_on == nullptr && request.mirror_off == nullptr) return;
  uint16_t axes = 0;
  for (int i = 0; i < axis_count_; ++i) {
    if (step.word_of_axis[i] >= 0) axes |= static_cast<uint16_t>(1u << i);
  }
  const bool names_all = axes != 0 && is_whole && request.foreign_axis == 0;
  if (request.mirror_on != nullptr) modal_.mirrored_axes |= names_all ? axes : kAllAxes;
  if (request.mirror_off == nullptr) return;
  if (axes == 0 && is_whole && request.foreign_axis == 0) axes = kAllAxes;
  modal_.mirrored_axes &= static_cast<uint16_t>(~axes);
  if (modal_.mirrored_axes == 0) EndMode(kMirror);
}

void Interpreter::NeedAbsoluteZ() {
  if (const int z = AxisOf('Z'); z >= 0) needs_absolute_ |= static_cast<uint16_t>(1u << z);
}

bool Interpreter::IsOfOneTool(int number) {
  const int64_t tool = has_changer_ ? loaded_tool_ : called_tool_;
  for (const auto& [known, its_tool] : tool_of_length_) {
    if (known == number) return its_tool == tool;
  }
  tool_of_length_.emplace_back(number, tool);
  return true;
}

// G43 H1, H1 while a length is in force, or D1 of Sinumerik.
void Interpreter::SelectLength(Request* request) {
  const bool acts_alone = roles_['D' - 'A'] == Role::kActiveToolLength;
  if (request->length_number != nullptr) {
    const Decimal& number = request->length_number->number;
    const bool is_number = number.decimals == 0 && number.mantissa >= 0 && number.mantissa <= 9999;
    last_length_number_ = is_number ? static_cast<int>(number.mantissa) : -1;
    if (acts_alone) modal_.uncertain &= static_cast<uint8_t>(~kLengthGroup);
  }
  const bool is_active = coordinates_.active_length() >= 0 || (modal_.tool_point & ~kPlacedFrames) != 0 ||
                         (modal_.blockers & (kToolControl | kUnstatedLength)) != 0;
  if (request->length == nullptr && !acts_alone && !is_active) return;
  // "G43 H#1": its number was not read.
  if (request->length_number == nullptr && (dialect_->takes_loaded_tool || !request->is_whole))
    last_length_number_ =
        is_loaded_tool_known_ && dialect_->takes_loaded_tool && request->is_whole && loaded_tool_ <= 9999
            ? static_cast<int>(loaded_tool_)
            : -1;
  const int sign = request->length != nullptr && request->length->detail == 2 ? -1 : 1;
  NeedAbsoluteZ();
  int number = last_length_number_;
  if (acts_alone && number > 0) {
    const int of_spindle = NumberOfSpindle(number);
    const bool is_stated = coordinates_.IsLengthStated(number);
    if (of_spindle > 0 && (coordinates_.IsEdgeStatedByTool(number) || !is_stated)) {
      number = of_spindle;
    } else if (is_stated && !IsOfOneTool(number)) {
      coordinates_.DropLength();
      modal_.blockers |= kUnstatedLength;
      return request->Refuse(of_spindle > 0 ? absl::StrCat("D", number, " of another tool than before: tool length ",
                                                           ToolNumberText(of_spindle), ": its value is not stated")
                                            : absl::StrCat("D", number,
                                                           " of another tool than before, and no T word with a number "
                                                           "and M6 in front of it say which: its length is not known"));
    }
  }
  if (number >= 0 && coordinates_.SelectLength(number, sign)) {
    EndMode(kUnstatedLength);  // tool centre point control goes on with another length
    if (modal_.plane_normal != 2 && number != 0 && !dialect_->lengths_along_z) {
      modal_.blockers |= kUnstatedLength;
      request->Refuse("a tool length in another plane than XY: controllers differ on its axis");
    }
    return;
  }
  const bool was_stated = std::any_of(options_->tool_lengths.begin(), options_->tool_lengths.end(),
                                      [number](const ToolLength& stated) { return stated.number == number; });
  constexpr char kNoValue[] = "its value is not stated";
  modal_.blockers |= kUnstatedLength;
  request->Refuse(
      request->length_number == nullptr && last_length_number_ < 0
          ? dialect_->takes_loaded_tool
                ? "tool length offset without a number, and no T word and M6 in front of it say which tool "
                  "is in the spindle"
                : "tool length offset without a number"
          : absl::StrCat("tool length ", ToolNumberText(number), ": ", was_stated ? WhyNotStated(kNoValue) : kNoValue));
}

}  // namespace axiscal::nc
