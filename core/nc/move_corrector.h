// From a nominal move to commanded positions: the correction at its end, and where the move must be split because the
// correction along it departs from linear by more than the tolerance.
#ifndef AXISCAL_CORE_NC_MOVE_CORRECTOR_H_
#define AXISCAL_CORE_NC_MOVE_CORRECTOR_H_

#include <vector>

#include "core/base/status.h"
#include "core/compensate/compensator.h"
#include "core/compensate/orientation.h"
#include "core/nc/corrected_word.h"
#include "core/nc/interpreter.h"
#include "core/nc/tool_point_frame.h"

namespace axiscal::nc {

// One piece of the written move: straight, or an arc.
struct Piece {
  double end_fraction = 1.0;  // of the nominal move; the share 0 takes up what the sense of motion changed
  AxisTicks nominal{};        // axis positions at its end
  compensate::Pose pose;      // the same in mm and rad, with the senses of motion there
  compensate::Correction correction;
  AxisTicks targets{};        // corrected, exact; rotary axes as nominal, or with orientation as their words will say
  compensate::Turned turned;  // with orientation: what the rotary axes reach, before rounding
  // Words of X, Y and Z stand in the workpiece's frame: in `nominal` and `targets`; `pose` and `correction` are of
  // axes.
  bool is_tool_point = false;
  const WordFrame* placed = nullptr;     // with is_tool_point: Step::placed, which must outlive the piece's correction
  compensate::AxisValues axis_change{};  // with is_tool_point: correction.corrected - pose.position
  bool is_arc = false;
  Arc arc;  // in corrected positions; valid with is_arc
  // Of an arc with a centre: its words have at least so many, since both ends must have the radius that the control
  // asks.
  int centre_decimals = 0;
};

// A word of an arc's centre.
struct CentreWord {
  WordForm form;
  Ticks ticks_per_unit = 0;
  Ticks origin = 0;  // what a word of 0 means where it counts from the coordinates' origin
  // What it may count from: the block itself may say another thing (I=AC(5)) than the pieces behind it.
  bool from_origin = false, from_start = false;
};

// What the written words can hold.
struct WordGrain {
  AxisTicks of_axis{};   // of each axis' word, ticks; 0: any position
  AxisTicks base{};      // a position that the word can say
  Ticks radius = 0;      // of the R word; 0: the arc has a centre
  bool is_flat = false;  // the arc's block holds no word of another axis than its plane's
  std::array<CentreWord, 2> centre;  // of an arc without a radius word, along the axes of its plane
  double radius_tolerance_mm = kRadiusToleranceMm;  // Dialect::arc_radius_tolerance_mm
  bool takes_finer_centres = false;                 // Dialect::takes_finer_words

  // The position nearest to it that the axis' word can say.
  Ticks Held(int axis, Ticks target) const { return NearestHeld(target, base[axis], of_axis[axis]); }
};

class MoveCorrector {
 public:
  // `length_mm`: of the compensator's tool beyond RewriteOptions::tool_tip_mm.
  MoveCorrector(const compensate::Compensator& compensator, const RewriteOptions& options, double length_mm);

  // The corrected end of a move whose positions are known. Fills `piece`. `grain` matters with orientation only: the
  // linear axes follow the rotary commands as they will be written. Errors of Compensator::Correct.
  absl::Status CorrectEnd(const Step& step, const WordGrain& grain, Piece* piece) const;

  // How far the correction along the linear move departs from the straight line between its ends: an upper bound where
  // that is below the tolerance, sampled otherwise. The move's start must be known; `end` is what CorrectEnd filled.
  absl::StatusOr<double> Departure(const Step& step, const Piece& end) const;

  // Where the start of the move lies by the senses of this move; it differs from what is commanded behind a reversal.
  // The move's start must be known.
  absl::Status CorrectStart(const Step& step, const WordGrain& grain, Piece* piece) const;
  // How far the piece's end lies from what is commanded, mm: the largest difference in one linear axis; with
  // orientation the effect of the difference on the tool (Weight).
  double Apart(const Piece& piece, const AxisTicks& commanded) const;
  bool uses_sense() const { return uses_sense_; }

  // As few pieces as samples of the correction allow, the last one ending the move, each within the tolerance.
  // Positions between the pieces are rounded to the words' grain. FAILED_PRECONDITION when more than kMaxPieces would
  // be needed.
  absl::StatusOr<std::vector<Piece>> Split(const Step& step, const WordGrain& grain) const;

  // The same of an arc that begins at `commanded`: one arc where the corrected points lie on one within the tolerance,
  // else several, else chords. Where an axis turns back, a straight piece takes up its lost motion first.
  absl::StatusOr<std::vector<Piece>> SplitArc(const Step& step, const AxisTicks& commanded,
                                              const WordGrain& grain) const;

  // Largest departure of a written piece that Split and SplitArc leave, mm.
  double tolerance_mm() const { return tolerance_mm_; }

  static constexpr int kMaxPieces = 10000;

 private:
  // Of the corrected axes: corrections or differences of them, mm and rad.
  using Change = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, machine::kMaxAxes, 1>;
  // What the tool does per unit of each entry of a Change: its point (mm), and its direction in the mm that count as
  // much (tolerance_mm per tolerance_rad). Filled with orientation only.
  using Effect = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, machine::kMaxAxes>;
  struct Samples {
    std::vector<Change> changes;
    std::vector<Effect> effects;
    double scale = 1.0;  // ScaleOf the move
  };
  using Senses = std::array<int8_t, machine::kMaxAxes>;

  double ChordDeparture(const Samples& samples, int first, int last) const;
  // The frame in which the words of the move stand.
  static void Begin(const Step& step, Piece* piece) {
    piece->is_arc = false;
    piece->is_tool_point = step.is_tool_point;
    piece->placed = step.placed.get();
  }
  // How far the tool point goes at most per mm of words.
  static double ScaleOf(const WordFrame* placed) { return placed == nullptr ? 1.0 : placed->scale; }
  // The effect of a difference of commands on the tool, mm.
  double Weight(const Change& difference, const Effect& effect) const;
  Effect EffectAt(const Piece& piece) const;
  Effect ToolPointEffectAt(const Piece& piece) const;
  Change ChangeOf(const AxisTicks& to, const AxisTicks& from) const;
  AxisTicks Between(const Step& step, double fraction) const;
  absl::Status CorrectAt(const AxisTicks& nominal, const Senses& senses, const WordGrain& grain, Piece* piece) const;
  // CorrectAt in the workpiece's frame; `piece` has its nominal words and the senses of its pose.
  absl::Status CorrectWords(const WordGrain& grain, Piece* piece) const;
  // The targets of X, Y and Z from the corrected commands: of linear axes in piece->correction, of rotary ones
  // `turned`.
  absl::Status ToWords(const compensate::AxisValues& turned, Piece* piece) const;
  // DepartureBound of a move in the workpiece's frame, infinity where only samples tell.
  double ToolPointDepartureBound(const Step& step) const;
  // How far axes travel along such a move.
  compensate::AxisValues AxisTravels(const Step& step) const;
  // CorrectAt with orientation: `piece` has its pose; `near` is a correction near the answer, mm and rad.
  absl::Status TurnAt(const compensate::AxisValues& near, const WordGrain& grain, Piece* piece) const;
  double TurnedDepartureBound(const compensate::AxisValues& from, const compensate::AxisValues& to,
                              const Piece& end) const;
  // At equidistant points of the move, both ends included.
  absl::Status Sample(const Step& step, int intervals, Samples* samples) const;
  int SampleIntervals(const Step& step) const;

  Senses SensesOfArc(const Step& step, double fraction) const;
  absl::Status CorrectOnArc(const Step& step, double fraction, const Senses& senses, const WordGrain& grain,
                            Piece* piece) const;
  // The fewest decimals of the centre words, at least their own, with which the arc between two written positions has
  // radii that the control takes for one; -1: none.
  static int CentreDecimals(const Arc& arc, const AxisTicks& start, const AxisTicks& end, const WordGrain& grain);
  // How many points inside an arc show its corrections, of one that is `share` of the move.
  int ArcSamples(const Step& step, double share) const;
  // Whether one arc through the corrected points, from `start` to the fraction `last`, keeps the tolerance; fills
  // `piece`. `at_begin`: where the first arc of this move began.
  absl::StatusOr<bool> FitArc(const Step& step, const AxisTicks& at_begin, const AxisTicks& start, double first,
                              double last, const WordGrain& grain, Piece* piece) const;
  // Arcs from `commanded` between two fractions of the move; empty when no number of them keeps the tolerance.
  absl::StatusOr<std::vector<Piece>> ArcPieces(const Step& step, double first, double last, const AxisTicks& commanded,
                                               const WordGrain& grain) const;
  // Appends the pieces between two reversals: one that takes up lost motion, then arcs, or chords where arcs fail.
  absl::Status PiecesBetween(const Step& step, double first, double last, const AxisTicks& commanded,
                             const WordGrain& grain, std::vector<Piece>* pieces) const;
  // Fractions of an arc where an axis whose sense matters turns back, 0 and 1 included.
  std::vector<double> Reversals(const Step& step) const;

  const compensate::Compensator* compensator_;
  ToolPointFrame frame_;
  double length_mm_;
  double tolerance_mm_;
  int axis_count_;
  bool orientation_;
  double max_rotary_correction_rad_;
  double mm_per_rad_;           // tolerance_mm / tolerance_rad
  bool begins_near_;            // the last correction is where the next one is looked for
  std::vector<int> corrected_;  // axes: the linear ones, then with orientation the rotary ones
  bool uses_sense_ = false;
  std::array<double, machine::kMaxAxes> unit_per_tick_{};  // mm or rad
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_MOVE_CORRECTOR_H_
