#include "core/effects/thinned.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/loop/dictionary.h"

namespace axiscal::effects {
namespace {

using instruments::MeasuringRun;

// The finest shapes that the dictionary has beside harmonics are local defects of a fiftieth of the range: eight rows
// over the width of one.
constexpr double kShareOfRange = 1.0 / 400.0;
// Rows that are left at least: with so many the F distribution is as good as chi-square, in which policies are stated.
constexpr int kFewestRows = 2000;
// Of a series; a session that looks at a short piece closely keeps its form.
constexpr int kFewestRowsOfASeries = 40;

struct Limits {
  std::vector<double> travel;  // per axis, mm or rad
  double elapsed_s = INFINITY;
  int readings = 1;
};

Limits LimitsOf(const Linearised& linearised) {
  const identify::Problem& problem = *linearised.problem;
  Limits limits;
  for (const loop::AxisSpan& span : loop::SpansOf(problem))
    limits.travel.push_back(kShareOfRange * (span.highest - span.lowest));
  double first_s = INFINITY, last_s = -INFINITY;
  for (const MeasuringRun& run : problem.runs) {
    if (!run.has_time) continue;
    for (const double time_s : run.time_s) {
      first_s = std::min(first_s, time_s);
      last_s = std::max(last_s, time_s);
    }
  }
  if (last_s > first_s) limits.elapsed_s = kShareOfRange * (last_s - first_s);
  limits.readings = linearised.count() / kFewestRows;
  return limits;
}

// Whether a block that began in state `first` may go on to `next`.
bool GoesOn(const Limits& limits, const shapes::State& first, const shapes::State& next) {
  if (first.approach.is_touch || next.approach.is_touch) return false;
  if (std::abs(next.time_s - first.time_s) > limits.elapsed_s) return false;
  for (size_t axis = 0; axis < first.axes.size(); ++axis) {
    const shapes::AxisState &before = first.axes[axis], &after = next.axes[axis];
    if (before.sense != after.sense) return false;
    // An axis that stands still may be recorded with jitter.
    constexpr double kStill = std::min(loop::kStandsStillMm, loop::kStandsStillRad);
    if (std::abs(after.position - before.position) > std::max(limits.travel[axis], kStill)) return false;
  }
  return true;
}

struct Block {
  int begin = 0, end = 0, stretch = 0;
};

std::vector<Block> BlocksOf(const Linearised& linearised, const std::vector<bool>& is_left_out) {
  const Limits limits = LimitsOf(linearised);
  std::vector<Block> blocks;
  for (size_t s = 0; s < linearised.rows.stretches.size(); ++s) {
    const objective::Stretch& some = linearised.rows.stretches[s];
    const int longest = std::min(limits.readings, (some.end - some.begin) / kFewestRowsOfASeries);
    const size_t first_of_series = blocks.size();
    for (int at = some.begin; at < some.end; ++at) {
      if (is_left_out[at]) continue;
      const bool goes_on = blocks.size() > first_of_series && blocks.back().end == at &&
                           at - blocks.back().begin < longest &&
                           GoesOn(limits, linearised.StateAt(blocks.back().begin), linearised.StateAt(at));
      if (goes_on) {
        blocks.back().end = at + 1;
      } else {
        blocks.push_back({at, at + 1, static_cast<int>(s)});
      }
    }
  }
  return blocks;
}

// The row whose columns, times the weight of the sum, are nearest to the sum of the block's whitened columns. The
// whitening lets what changes slowly pass, but ahead of its time: (1 - p z^-1) / (1 - e z^-1) advances it by
// p / (1 - p) - e / (1 - e) readings (group delay at frequency 0; Oppenheim and Schafer, Discrete-Time Signal
// Processing).
int ReadingFor(const Linearised& linearised, const Block& block) {
  const objective::Whitening& whitening = linearised.rows.whitening;
  int at = block.begin + (block.end - block.begin) / 2;
  const double memory = whitening.correlation()[at], echo = whitening.echo()[at];
  const int end = linearised.rows.stretches[static_cast<size_t>(block.stretch)].end;
  auto ahead = static_cast<int>(std::lround(memory / (1.0 - memory) - echo / (1.0 - echo)));
  const shapes::State state = linearised.StateAt(at);
  const auto same_sense = [](const shapes::AxisState& a, const shapes::AxisState& b) { return a.sense == b.sense; };
  for (; ahead > 0 && at + 1 < end; --ahead, ++at) {
    const shapes::State next = linearised.StateAt(at + 1);
    if (!std::equal(state.axes.begin(), state.axes.end(), next.axes.begin(), same_sense)) break;
  }
  return at;
}

// Bad rows, and the row behind each where the whitening remembers it.
std::vector<bool> LeftOut(const Linearised& linearised, const std::vector<loop::BadRow>& bad_rows) {
  std::set<std::pair<int, size_t>> bad;
  for (const loop::BadRow& one : bad_rows) bad.emplace(one.run, one.row);
  std::vector<bool> is_left_out(linearised.count(), false);
  for (int at = 0; !bad.empty() && at < linearised.count(); ++at) {
    const int run = linearised.run[at];
    const size_t row =
        static_cast<size_t>(linearised.reading[at]) * linearised.problem->runs[run].row_count + linearised.channel[at];
    if (!bad.contains({run, row})) continue;
    is_left_out[at] = true;
    if (at + 1 < linearised.count() && linearised.rows.whitening.correlation()[at + 1] != 0.0)
      is_left_out[at + 1] = true;
  }
  return is_left_out;
}

}  // namespace

std::optional<Linearised> Thinned(const Linearised& linearised, const std::vector<loop::BadRow>& bad_rows) {
  const std::vector<MeasuringRun>& runs = linearised.problem->runs;
  const auto is_path = [](const MeasuringRun& run) { return run.path_readings != nullptr; };
  if (linearised.count() < 2 * kFewestRows || std::any_of(runs.begin(), runs.end(), is_path)) return std::nullopt;
  const std::vector<Block> blocks = BlocksOf(linearised, LeftOut(linearised, bad_rows));
  const auto count = static_cast<Eigen::Index>(blocks.size());
  if (2 * count > linearised.count()) return std::nullopt;

  Linearised out;
  out.problem = linearised.problem;
  const objective::Rows& rows = linearised.rows;
  objective::Rows& thin = out.rows;
  thin.own_precision = rows.own_precision;
  thin.common_precision = rows.common_precision;
  thin.own_value = rows.own_value;
  thin.rounding_squares = rows.rounding_squares;
  thin.least_squares = rows.least_squares * static_cast<double>(count) / linearised.count();
  // Of all columns one reading's row: what hides others there hides them in the rows too.
  Eigen::MatrixXd own = rows.own, common = rows.common;
  rows.whitening.Undo(0, own);
  rows.whitening.Undo(0, common);
  out.sensitivity.resize(count, linearised.sensitivity.cols());
  out.artefact.resize(count, linearised.artefact.cols());
  thin.own.resize(count, rows.own.cols());
  thin.common.resize(count, rows.common.cols());
  thin.y.resize(count);
  // What is left by the whitening of a column that hardly changes.
  Eigen::MatrixXd level = Eigen::VectorXd::Ones(linearised.count());
  rows.whitening.Apply(0, level);
  Eigen::ArrayXd weight(count);
  for (const objective::Stretch& some : rows.stretches) thin.stretches.push_back({0, 0, some.group});
  for (Eigen::Index b = 0; b < count; ++b) {
    const Block& block = blocks[static_cast<size_t>(b)];
    const Eigen::Index n = block.end - block.begin;
    const int chosen = ReadingFor(linearised, block);
    const double root = std::sqrt(static_cast<double>(n));
    out.run.push_back(linearised.run[chosen]);
    out.reading.push_back(linearised.reading[chosen]);
    out.channel.push_back(linearised.channel[chosen]);
    out.sound.push_back(linearised.sound[chosen]);
    out.sensitivity.row(b) = linearised.sensitivity.row(chosen);
    out.artefact.row(b) = linearised.artefact.row(chosen);
    thin.y[b] = rows.y.segment(block.begin, n).sum() / root;
    weight[b] = level.col(0).segment(block.begin, n).sum() / root;
    thin.own.row(b) = weight[b] * own.row(chosen);
    thin.common.row(b) = weight[b] * common.row(chosen);
    objective::Stretch& some = thin.stretches[static_cast<size_t>(block.stretch)];
    if (some.end == 0) some.begin = static_cast<int>(b);
    some.end = static_cast<int>(b) + 1;
  }
  // Series without rows stand where the one before them ends.
  for (size_t s = 0; s < thin.stretches.size(); ++s)
    if (thin.stretches[s].end == 0)
      thin.stretches[s].begin = thin.stretches[s].end = s > 0 ? thin.stretches[s - 1].end : 0;
  thin.whitening = objective::Whitening(std::move(weight), Eigen::ArrayXd::Zero(count), Eigen::ArrayXd::Zero(count));
  thin.clusterings = ClusteringsOf(out);
  out.step = LimitsOf(linearised).travel;
  return out;
}

}  // namespace axiscal::effects
