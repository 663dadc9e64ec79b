#include "core/effects/catalogue.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <tuple>

#include "core/effects/harmonic_scan.h"
#include "core/effects/instrumental.h"
#include "core/effects/shaped.h"
#include "core/identify/reduction.h"
#include "core/loop/dictionary.h"
#include "core/objective/moments.h"

namespace axiscal::effects {
namespace {

using instruments::MeasuringRun;
using loop::Candidate;
using loop::Family;

// The same shape closer than that in the logarithm of its length or time constant is the same effect: ln 1.3.
constexpr double kApart = 0.26;

class Builder {
 public:
  Builder(const Linearised& linearised, const machine::ErrorModel& declared, const std::vector<Candidate>& known,
          const Linearised* thinned)
      : linearised_(linearised),
        thinned_(thinned),
        machine_(*linearised.problem->machine),
        known_(known),
        plain_(Plain(*linearised.problem)),
        spans_(loop::SpansOf(plain_)) {
    model_ = declared;
    for (const Candidate& one : known)
      if (loop::IsTerm(one.family)) model_.terms.push_back(one.term);
  }

  Catalogue Build(const std::vector<loop::BadRow>& bad_rows) {
    AddKnown(bad_rows);
    std::vector<Candidate> candidates = loop::MakeDictionary(plain_, model_);
    std::erase_if(candidates, [](const Candidate& one) { return !loop::IsTerm(one.family); });
    if (thinned_ == nullptr) AddFurther(&candidates);
    std::erase_if(candidates, [this](const Candidate& one) {
      return !linearised_.Tells(one.term.shape) || (thinned_ != nullptr && thinned_->Tells(one.term.shape));
    });
    AddShaped(candidates);
    if (thinned_ == nullptr) AddInstruments();
    AddSlips();
    if (linearised_.step.empty()) AddRows();
    return std::move(catalogue_);
  }

 private:
  // The problem as if nothing had slipped and instruments were sound.
  static identify::Problem Plain(const identify::Problem& problem) {
    identify::Problem plain = problem;
    for (MeasuringRun& run : plain.runs) {
      run.setup.resize(static_cast<size_t>(instruments::OwnSetupCount(run)));
      run.distortions.clear();
      run.slips.clear();
    }
    return plain;
  }

  void Add(std::unique_ptr<objective::Source> source) {
    if (!source->groups().empty()) catalogue_.sources.push_back(std::move(source));
  }

  // Effects that were found, in their order: a source each, as one may be a slip and the next a term.
  void AddKnown(const std::vector<loop::BadRow>& bad_rows) {
    for (const Candidate& one : known_) {
      catalogue_.known.push_back(static_cast<int>(catalogue_.effects.size()));
      catalogue_.effects.push_back({one});
      if (one.family == Family::kInstrument) {
        Add(std::make_unique<Instrumental>(linearised_, std::vector<Instrumental::Item>{ItemOf(one.distortion)}));
      } else if (one.family == Family::kStep) {
        Add(SlipSource(one.run, one.carrier, {one.first_reading}));
      } else {
        Add(std::make_unique<Shaped>(linearised_,
                                     std::vector<ShapedItem>{ItemOf(one, LargestValueOf(one.term.shape))}));
      }
    }
    std::vector<int> rows;
    for (const loop::BadRow& bad : bad_rows) {
      const int channels = linearised_.problem->runs[bad.run].row_count;
      for (int at = 0; at < linearised_.count(); ++at) {
        if (linearised_.run[at] != bad.run || linearised_.reading[at] != static_cast<int>(bad.row) / channels ||
            linearised_.channel[at] != static_cast<int>(bad.row) % channels)
          continue;
        rows.push_back(at);
        catalogue_.known.push_back(static_cast<int>(catalogue_.effects.size()));
        catalogue_.effects.push_back({{}, at});
      }
    }
    bad_.insert(rows.begin(), rows.end());
    Add(std::make_unique<objective::SingleRows>(linearised_.count(), rows, BadRowModel()));
  }

  static objective::Group BadRowModel() {
    objective::Group model;
    model.family = kBadRowFamily;
    model.is_counted = false;
    return model;
  }

  // `largest_value`: of its shape (LargestValueOf).
  ShapedItem ItemOf(const Candidate& one, double largest_value) {
    ShapedItem item{one.term.shape, SensitivityOf(linearised_, one.term), {}};
    item.group.family = static_cast<int>(one.family);
    item.group.largest_amplitude = LargestAmplitudeOf(one, largest_value);
    item.group.is_exotic = loop::IsFurther(one.family) || loop::IsUnnamed(one.family);
    // Where a tool or a table stands is nominal data; of a lag only differences bend a path.
    item.group.has_usual_size = one.family != Family::kConstant && one.family != Family::kLag;
    // What an axis loses on its way: none of it gives back what another takes.
    if (std::holds_alternative<shapes::Play>(one.term.shape) ||
        std::holds_alternative<shapes::Backlash>(one.term.shape))
      item.group.one_sign = item.sensitivity;
    if (shapes::IsFree(one.term.shape)) {
      item.group.spectrum.resize(shapes::BasisCount(one.term.shape));
      for (int i = 0; i < item.group.spectrum.size(); ++i) {
        const double root = shapes::PriorRoot(one.term.shape, i);
        item.group.spectrum[i] = root * root;
      }
      item.group.largest_amplitude = INFINITY;
      const double largest = LargestCurveOf(one.term) / LargestFactorOf(one.term.shape);
      item.group.largest_variance = largest * largest;
      if (const auto* curve = shapes::CurveOf(one.term.shape)) {  // of any smoothness: one effect
        const auto kin = std::make_tuple(static_cast<int>(one.term.shape.index()), curve->axis, item.sensitivity,
                                         std::string(curve->span.is_turn ? "turn" : ""));
        item.group.kin = kins_.try_emplace(kin, static_cast<int>(kins_.size())).first->second;
        item.group.apart = 1.0;  // they have no place
      }
      return item;
    }
    const auto* bump = std::get_if<shapes::Bump>(&one.term.shape);
    if (bump == nullptr && shapes::NonlinearParameter(one.term.shape) == nullptr) return item;
    // The dictionary's next one is at most a factor of two, or kPitchStep of a period over the range, away.
    constexpr double kReach = 0.7;  // ln 2
    const auto* pitch = std::get_if<shapes::Harmonic>(&one.term.shape);
    const int axis = shapes::VariableAxis(one.term.shape).value_or(-1);
    const auto* lag = std::get_if<shapes::ThermalLag>(&one.term.shape);
    const std::string channel = lag == nullptr ? "" : lag->channel;
    const auto kin = std::make_tuple(static_cast<int>(one.term.shape.index()), axis, item.sensitivity, channel);
    item.group.kin = kins_.try_emplace(kin, static_cast<int>(kins_.size())).first->second;
    if (bump != nullptr) {  // the dictionary's next one of its width is one width away
      item.group.place = bump->at;
      item.group.apart = bump->width;
      item.group.reach = 0.5 * bump->width;
      item.group.size = std::log(bump->width);
      // Half way to the dictionary's next width, a factor of two away, and no wider than a local defect is.
      constexpr double kHalfWay = 0.35;
      item.group.size_reach = std::min(kHalfWay, std::log(loop::WidestBump(machine_, bump->axis) / bump->width));
      return item;
    }
    const auto form = std::make_tuple(static_cast<int>(one.term.shape.index()), axis, -1, channel);
    item.group.form = kins_.try_emplace(form, static_cast<int>(kins_.size())).first->second;
    item.group.place = PlaceOf(one.term.shape);
    item.group.apart = kApart;
    item.group.reach = kReach;
    if (pitch != nullptr) {
      item.group.apart = 2.0 * std::numbers::pi / (spans_[pitch->axis].highest - spans_[pitch->axis].lowest);
      item.group.reach = loop::kPitchStep * item.group.apart;
    }
    return item;
  }

  // The largest value that a shape with unit amplitudes takes in the readings.
  double LargestValueOf(const shapes::Shape& shape) const {
    constexpr int kLooks = 100;
    double largest = 0.0, basis[shapes::kMaxBasisCount];
    for (int at = 0; at < linearised_.count(); at += std::max(1, linearised_.count() / kLooks)) {
      shapes::Basis(shape, linearised_.StateAt(at), basis);
      for (int b = 0; b < shapes::BasisCount(shape); ++b) largest = std::max(largest, std::abs(basis[b]));
    }
    return largest;
  }

  // The largest factor of its functions in the readings (shapes::Times).
  double LargestFactorOf(const shapes::Shape& shape) const {
    const shapes::Times* times = shapes::TimesOf(shape);
    if (times == nullptr || times->axis < 0) return 1.0;
    const loop::AxisSpan& span = spans_[times->axis];
    return std::max(std::abs(span.lowest), std::abs(span.highest)) / times->reference;
  }

  Instrumental::Item ItemOf(const instruments::Distortion& one) {
    if (one.kind != instruments::Distortion::kGrowth) return {one, -1};
    constexpr int kNoShape = -1;  // where terms have their shape's index
    const auto kin =
        std::make_tuple(kNoShape, static_cast<int>(one.kind), static_cast<int>(one.instrument), std::string());
    return {one, kins_.try_emplace(kin, static_cast<int>(kins_.size())).first->second};
  }

  void AddInstruments() {
    std::vector<Instrumental::Item> items;
    for (const instruments::Distortion& one : DistortionsOf(plain_.runs)) {
      const bool is_known = std::any_of(known_.begin(), known_.end(), [&](const Candidate& known) {
        return known.family == Family::kInstrument && IsSameFault(known.distortion, one) &&
               known.distortion.tau_s == one.tau_s;
      });
      if (is_known) continue;
      items.push_back(ItemOf(one));
      Candidate candidate;
      candidate.family = Family::kInstrument;
      candidate.distortion = one;
      catalogue_.effects.push_back({candidate});
    }
    Add(std::make_unique<Instrumental>(linearised_, std::move(items)));
  }

  // Prior standard deviation of a free curve, at most: far more than guides and gears have. Without a cap curves took
  // up set-ups that stood a millimetre off.
  static double LargestCurveOf(const machine::ErrorTerm& term) {
    constexpr double kMostMm = 0.1, kMostRad = 300e-6;
    return machine::IsAngle(term.component) ? kMostRad : kMostMm;
  }

  static double LargestAmplitudeOf(const Candidate& one, double largest_value) {
    return largest_value > 0.0 ? LargestErrorOf(one) / largest_value : INFINITY;
  }

  void AddAtJoint(Family family, int joint, const shapes::Shape& shape, std::vector<Candidate>* candidates) const {
    for (int component = 0; component < machine::kComponents; ++component)
      AddComponent(family, {joint, static_cast<machine::Component>(component), shape, {}}, candidates);
  }

  void AddComponent(Family family, const machine::ErrorTerm& term, std::vector<Candidate>* candidates) const {
    const bool is_known = std::any_of(known_.begin(), known_.end(), [&](const Candidate& known) {
      return known.family == family && loop::IsSameEffect(known.term, term) &&
             std::abs(PlaceOf(known.term.shape) - PlaceOf(term.shape)) < kApart &&
             (shapes::CurveOf(term.shape) == nullptr || known.term.shape == term.shape);
    });
    if (is_known) return;
    Candidate one;
    one.family = family;
    one.term = term;
    candidates->push_back(one);
  }

  // Free curves and what remembers temperatures, which the dictionary does not have.
  void AddFurther(std::vector<Candidate>* candidates) const {
    if (std::any_of(plain_.runs.begin(), plain_.runs.end(),
                    [](const MeasuringRun& run) { return run.path_readings != nullptr; }))
      return;
    AddThermalLags(candidates);
    AddCurves(candidates);
    AddCrossed(candidates);
    AddUnrecordedHeat(candidates);
    AddHysteresis(candidates);
  }

  // What remembers temperatures, which the dictionary does not have: any channel at any joint, and times the position
  // of an axis at that axis.
  void AddThermalLags(std::vector<Candidate>* candidates) const {
    const shapes::Temperatures* history = plain_.runs.front().history.get();
    if (history == nullptr) return;
    const double elapsed_s = history->time_s().back() - history->time_s().front();
    std::vector<double> taus_s;  // 0: at once, what the dictionary has of one channel
    constexpr double kShortest = 60.0;
    for (const double share : {0.01, 0.02, 0.04, 0.08, 0.16, 0.32})
      if (elapsed_s > kShortest) taus_s.push_back(share * elapsed_s);
    taus_s.push_back(0.0);
    for (const shapes::Temperatures::Channel& channel : history->channels()) {
      const bool is_recorded = std::all_of(plain_.runs.begin(), plain_.runs.end(), [&](const MeasuringRun& run) {
        const std::vector<std::string> columns = instruments::TemperatureColumns(run);
        return std::find(columns.begin(), columns.end(), channel.name) != columns.end();
      });
      if (!is_recorded) continue;
      const auto [coldest, warmest] = std::minmax_element(channel.celsius.begin(), channel.celsius.end());
      constexpr double kSmallestWarming = 0.05;
      if (!(*warmest - *coldest > kSmallestWarming)) continue;
      for (const double tau_s : taus_s) {
        const bool is_plain = tau_s == 0.0 && channel.name == shapes::kTemperatureChannel;
        for (int joint = 0; !is_plain && joint < machine_.joint_count(); ++joint)
          AddAtJoint(Family::kThermalLag, joint, shapes::ThermalLag{channel.name, tau_s}, candidates);
        for (int axis = 0; axis < machine_.axis_count(); ++axis) {
          if (spans_[axis].finest_step == 0.0) continue;
          const shapes::ThermalLag lag{channel.name, tau_s, machine::TimesPositionOf(machine_, axis)};
          AddAtJoint(Family::kThermalLag, axis, lag, candidates);
        }
      }
    }
  }

  bool IsRotary(int axis) const { return machine_.axes[axis].kind == machine::AxisKind::kRotary; }

  shapes::Span SpanOf(int axis) const {
    // Twelve poses 30 deg apart go around, although the last is 330 deg from the first.
    constexpr double kNearlyATurn = 0.99 * 2.0 * std::numbers::pi;
    const loop::AxisSpan& span = spans_[axis];
    if (IsRotary(axis) && span.highest - span.lowest + span.finest_step > kNearlyATurn) return {.is_turn = true};
    return {span.lowest, span.highest};
  }

  // Functions of an axis' position that the readings of the finest session tell, up to `most`; of turns in pairs.
  int FunctionsTold(int axis, int most) const {
    const loop::AxisSpan& span = spans_[axis];
    if (span.finest_step == 0.0) return 0;
    const double highest = loop::kBelowNyquist * std::numbers::pi / span.finest_step;
    const double told =
        SpanOf(axis).is_turn ? 2.0 * std::floor(highest) : highest * (span.highest - span.lowest) / std::numbers::pi;
    return static_cast<int>(std::min<double>(most, told));
  }

  // Curves of an axis over its own position. How smooth one is the data say: each function has its price, so that a
  // smooth error that had to have all of them would cost more than a few local defects that lie about it.
  static constexpr int kFewestFunctions = 6;  // three orders of a turn: fewer are slopes and single harmonics
  static constexpr int kMostFunctions = 24;   // finer waves are harmonics
  void AddCurves(std::vector<Candidate>* candidates) const {
    for (int axis = 0; axis < machine_.axis_count(); ++axis) {
      const loop::AxisSpan& span = spans_[axis];
      shapes::Curve curve{axis, SpanOf(axis)};
      const int finest = FunctionsTold(axis, kMostFunctions);
      if (finest < 4) continue;
      std::vector<shapes::Span> spans = {curve.span};
      // What does not close, as of a cable or a scale that was wound on.
      if (curve.span.is_turn) spans.push_back({span.lowest, span.highest});
      for (const shapes::Span& one : spans) {
        curve.span = one;
        for (curve.functions = finest; curve.functions >= std::min(finest, kFewestFunctions);
             curve.functions = curve.functions / 4 * 2)  // of turns in pairs
          AddAtJoint(Family::kCurve, axis, curve, candidates);
      }
      // Where the lost motion is more here than there; wear is smooth.
      if (!span.has_both_senses) continue;
      curve.span = spans.front();
      for (curve.functions = std::min(finest, 2 * kFewestFunctions);
           curve.functions >= std::min(finest, kFewestFunctions); curve.functions = curve.functions / 4 * 2)
        AddAtJoint(Family::kCurve, axis, shapes::BacklashCurve{curve}, candidates);
    }
  }

  // Errors over the positions of two axes.
  void AddCrossed(std::vector<Candidate>* candidates) const {
    for (int axis = 0; axis < machine_.axis_count(); ++axis) {
      for (int other = 0; other < machine_.axis_count(); ++other) {
        if (other == axis) continue;
        shapes::Crossed crossed{axis, other, SpanOf(axis), SpanOf(other)};
        crossed.each = std::min(FunctionsTold(axis, crossed.each), FunctionsTold(other, crossed.each));
        if (crossed.span.is_turn || crossed.second.is_turn) crossed.each -= crossed.each % 2;
        if (crossed.each > 0) AddAtJoint(Family::kCrossed, axis, crossed, candidates);
      }
    }
  }

  // What moves tool or table over hours that no channel recorded (the joints between would be further names for it), or
  // makes a scale longer: whatever course it takes, and as a body that warms up, which goes on after the readings.
  void AddUnrecordedHeat(std::vector<Candidate>* candidates) const {
    double first_s = INFINITY, last_s = -INFINITY;
    for (const MeasuringRun& run : plain_.runs) {
      if (!run.has_time) return;
      const auto [first, last] = std::minmax_element(run.time_s.begin(), run.time_s.end());
      first_s = std::min(first_s, *first);
      last_s = std::max(last_s, *last);
    }
    constexpr double kShortest = 60.0;
    if (!(last_s - first_s > kShortest)) return;
    for (const int joint : {machine_.tool_joint(), machine_.work_joint()})
      AddAtJoint(Family::kTimeCurve, joint, shapes::TimeCurve{{first_s, last_s}}, candidates);
    std::vector<int> scales;
    for (int axis = 0; axis < machine_.axis_count(); ++axis)
      if (spans_[axis].finest_step > 0.0) scales.push_back(axis);
    shapes::TimeCurve curve{{first_s, last_s}};
    for (const int axis : scales) {
      curve.times = machine::TimesPositionOf(machine_, axis);
      AddAtJoint(Family::kTimeCurve, axis, curve, candidates);
    }
    for (const double share : loop::kWarmings) {
      for (const int axis : scales) {
        const shapes::DriftExp warming{share * last_s, machine::TimesPositionOf(machine_, axis)};
        AddAtJoint(Family::kThermalLag, axis, warming, candidates);
      }
    }
  }

  // How far an axis came, along its own motion. Elements of friction (shapes::Play) are no candidates: with them a
  // smooth straightness was taken for three local defects and a harmonic.
  void AddHysteresis(std::vector<Candidate>* candidates) const {
    constexpr double kStep = 4.0;       // between lengths: the search moves each by up to half of it
    constexpr double kSaturated = 0.5;  // of the finest step: shorter ones are plain backlash in all readings
    for (int axis = 0; axis < machine_.axis_count(); ++axis) {
      const loop::AxisSpan& span = spans_[axis];
      if (!span.has_both_senses || span.finest_step == 0.0) continue;
      const machine::Component along = machine::PositioningOf(machine_, axis);
      double longest = 0.0;
      for (const MeasuringRun& run : plain_.runs) {
        for (int k = 1; k < run.reading_count(); ++k)
          longest = std::max(longest, std::abs(run.PositionsOf(k)[axis] - run.PositionsOf(k - 1)[axis]));
      }
      // Longer than half of the longest move it is a line, and what a long move would do is not known.
      for (double length = 0.5 * longest; length > kSaturated * span.finest_step; length /= kStep)
        AddComponent(Family::kHysteresis, {axis, along, shapes::LastMove{axis, length}, {}}, candidates);
    }
  }

  // A source for each stretch of one family and axis; items of one shape together.
  void AddShaped(const std::vector<Candidate>& candidates) {
    std::map<std::pair<Family, int>, std::vector<ShapedItem>> items;
    std::map<std::pair<Family, int>, std::vector<Effect>> effects;
    const shapes::Shape* last = nullptr;
    double largest = 0.0;
    bool is_worth = true;
    for (const Candidate& one : candidates) {
      // What depends on the shape alone is asked once per shape: its candidates stand together.
      if (last == nullptr || !(*last == one.term.shape)) {
        largest = LargestValueOf(one.term.shape);
        is_worth = HasEnoughReadings(one.term.shape);
        last = &one.term.shape;
      }
      if (!is_worth) continue;
      const auto key = std::pair(one.family, shapes::VariableAxis(one.term.shape).value_or(-1));
      items[key].push_back(ItemOf(one, largest));
      effects[key].push_back({one});
    }
    for (auto& [key, its] : items) {
      // Local defects are wide: constants explain most of many.
      const bool is_scan = key.first == Family::kFineHarmonic || key.first == Family::kPitch;
      std::unique_ptr<Shaped> source;
      if (is_scan) source = HarmonicScan::Make(linearised_, its);
      if (source == nullptr) source = std::make_unique<Shaped>(linearised_, std::move(its), is_scan);
      Add(std::move(source));
      catalogue_.effects.insert(catalogue_.effects.end(), effects[key].begin(), effects[key].end());
    }
  }

  // A local defect shows in several readings; fewer are bad ones that lie near each other.
  bool HasEnoughReadings(const shapes::Shape& shape) const {
    const auto* bump = std::get_if<shapes::Bump>(&shape);
    if (bump == nullptr) return true;
    constexpr int kFewest = 4;
    int count = 0;
    for (int at = 0; at < linearised_.count() && count < kFewest; ++at) {
      const bool is_first = linearised_.channel[at] == 0;
      count += is_first && std::abs(linearised_.StateAt(at).axes[bump->axis].position - bump->at) < bump->width;
    }
    return count >= kFewest;
  }

  std::unique_ptr<objective::Source> SlipSource(int run, instruments::Carrier carrier,
                                                const std::vector<int>& first_readings) {
    std::vector<objective::Slips::Series> series;
    const int tool = machine::kComponents * machine_.tool_joint();
    Eigen::MatrixXd columns(linearised_.count(), 3);
    Eigen::Index count = 0;
    for (const objective::Stretch& some : linearised_.rows.stretches) {
      if (some.begin == some.end || linearised_.run[some.begin] != run) continue;
      objective::Slips::Series& one = series.emplace_back();
      one.begin = some.begin;
      one.end = some.end;
      const auto begin = linearised_.reading.begin();
      for (const int first : first_readings)
        one.first.push_back(static_cast<int>(std::lower_bound(begin + some.begin, begin + some.end, first) - begin));
      const Eigen::Index n = some.end - some.begin;
      if (carrier == instruments::Carrier::kTable) {
        columns.middleRows(count, n) = linearised_.artefact.middleRows(some.begin, n);
      } else {
        columns.middleRows(count, n) = linearised_.sensitivity.block(some.begin, tool, n, 3);
      }
      count += n;
    }
    objective::Group model;
    model.family = carrier == instruments::Carrier::kTable ? static_cast<int>(Family::kStep) : kToolSlipFamily;
    model.looks = 1.0 / loop::kMomentsPerLook;
    model.precision = Eigen::VectorXd::Constant(3, 1.0 / (instruments::kSlipSigmaMm * instruments::kSlipSigmaMm));
    return std::make_unique<objective::Slips>(linearised_.count(), std::move(series), columns.topRows(count), model);
  }

  void AddSlips() {
    // The dictionary says what may slip where; its moments are too far apart for a slip that is faint or that others
    // hide.
    std::map<std::pair<int, instruments::Carrier>, std::vector<int>> moments;
    for (const Candidate& one : loop::MakeDictionary(plain_, machine::ErrorModel()))
      if (one.family == Family::kStep) moments[{one.run, one.carrier}];
    for (auto& one : moments) {
      const std::pair<int, instruments::Carrier>& of = one.first;
      std::vector<int>& its = one.second;
      const MeasuringRun& run = plain_.runs[of.first];
      const int stride = loop::StepStride(run);
      const auto is_near_known = [&](int k) {  // of whatever slipped
        return std::any_of(known_.begin(), known_.end(), [&](const Candidate& known) {
          return known.family == Family::kStep && known.run == of.first && std::abs(known.first_reading - k) <= stride;
        });
      };
      const auto is_known = [&](int k) {
        return std::any_of(known_.begin(), known_.end(), [&](const Candidate& known) {
          return known.family == Family::kStep && known.run == of.first && known.carrier == of.second &&
                 known.first_reading == k;
        });
      };
      for (int k = loop::kSlipReadings; k + loop::kSlipReadings <= run.reading_count(); ++k) {
        const bool is_asked = (k - loop::kSlipReadings) % stride == 0 || is_near_known(k);
        if (is_asked && !is_known(k)) its.push_back(k);
      }
    }
    for (const auto& [of, its] : moments) {
      for (const int first : its) {
        Candidate one;
        one.family = Family::kStep;
        one.run = of.first;
        one.carrier = of.second;
        one.first_reading = one.earliest = one.latest = first;
        catalogue_.effects.push_back({one});
      }
      Add(SlipSource(of.first, of.second, its));
    }
  }

  void AddRows() {
    std::vector<int> rows;
    for (int at = 0; at < linearised_.count(); ++at) {
      if (bad_.contains(at)) continue;
      rows.push_back(at);
      catalogue_.effects.push_back({{}, at});
    }
    Add(std::make_unique<objective::SingleRows>(linearised_.count(), rows, BadRowModel()));
  }

  const Linearised& linearised_;
  const Linearised* const thinned_;
  const machine::Machine& machine_;
  const std::vector<Candidate>& known_;
  const identify::Problem plain_;
  const std::vector<loop::AxisSpan> spans_;
  machine::ErrorModel model_;
  std::map<std::tuple<int, int, int, std::string>, int> kins_;
  std::set<int> bad_;
  Catalogue catalogue_;
};

}  // namespace

double LargestErrorOf(const loop::Candidate& one) {
  const bool is_large = one.family == Family::kConstant || one.family == Family::kLag;
  constexpr double kFarOffMm = 30.0, kFarOffRad = 0.1;  // where a tool or a table may stand, and how an axis may lag
  const bool is_play =
      one.family == Family::kBacklash || one.family == Family::kReversal || one.family == Family::kHysteresis;
  constexpr double kPlayMm = 1.0, kPlayRad = 0.01;  // of a machine that is in use
  constexpr double kWarmMm = 0.5, kWarmRad = 2e-3;  // of what warms up late: beyond, it is a lag longer than the data
  const bool is_warm = one.family == Family::kThermalLag;
  const double most_mm = is_large ? kFarOffMm : is_warm ? kWarmMm : is_play ? kPlayMm : identify::kLargestErrorMm;
  const double most_rad = is_large  ? kFarOffRad
                          : is_warm ? kWarmRad
                          : is_play ? kPlayRad
                                    : identify::kLargestErrorRad;
  return machine::IsAngle(one.term.component) ? most_rad : most_mm;
}

Catalogue MakeCatalogue(const Linearised& linearised, const machine::ErrorModel& declared,
                        const std::vector<Candidate>& known, const std::vector<loop::BadRow>& bad_rows,
                        const Linearised* thinned) {
  return Builder(linearised, declared, known, thinned).Build(bad_rows);
}

}  // namespace axiscal::effects
