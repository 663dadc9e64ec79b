// Growth: slips that something else explains, and bad readings that look like a slip.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/identify/outliers.h"
#include "core/loop/dictionary.h"
#include "core/loop/fitting.h"
#include "core/loop/growth.h"

namespace axiscal::loop {

using identify::Fit;
using instruments::MeasuringRun;

namespace {

// Rows [first, last) of the readings before or after a slip, whichever are fewer; none where those are many.
std::pair<int, int> ShortSideOf(const Candidate& slip, const MeasuringRun& run) {
  const int count = run.reading_count();
  if (slip.first_reading < kSlipReadings) return {0, slip.first_reading * run.row_count};
  if (count - slip.first_reading < kSlipReadings) return {slip.first_reading * run.row_count, count * run.row_count};
  return {0, 0};
}

}  // namespace

// A slip that affects only the first or last few readings, no more than scattered bad readings side by side, is none:
// these readings are bad where the others are explained as well without them. The running median does not find them,
// because at the ends it has neighbours on one side only.
absl::StatusOr<bool> Growth::SetEndAside(const Scored& found, Fit* fit) {
  const Candidate& slip = found.candidate;
  const int most = identify::OutlierOptions().max_cluster;
  const MeasuringRun& run = fit->problem.runs[slip.run];
  const int count = run.reading_count();
  int first = 0, last = 0;  // readings [first, last)
  if (count - slip.first_reading < kSlipReadings && count - slip.latest <= most) {
    first = slip.latest;
    last = count;
  } else if (slip.first_reading < kSlipReadings && slip.earliest <= most) {
    last = slip.earliest;
  }
  if (first == last) return false;
  std::vector<BadRow>& bad_rows = extension().bad_rows;
  const Extension before = extension();
  const absl::StatusOr<Fit> others = RefitWithout(*fit, slip.run, first, last, identify_options_);
  if (absl::IsCancelled(others.status())) return others.status();
  if (!others.ok()) return false;
  const double noise = run.row_count * (last - first);  // what is left out leaves with its noise
  const double explained = LikelihoodRatio(SquaresOf(*fit), SquaresOf(*fit) - SquaresOf(*others) - noise,
                                           std::max(1, fit->result.fit.degrees_of_freedom));
  if (explained < found.likelihood_ratio - options_.search.indistinguishable) return false;
  for (int row = first * run.row_count; row < last * run.row_count; ++row)
    bad_rows.push_back({slip.run, static_cast<size_t>(row)});
  return Change(before, fit);
}

// A slip near an end with which most of the readings after it (or before it) still stand out is no slip: each of these
// readings is bad by itself.
absl::StatusOr<bool> Growth::SetScatteredAside(size_t effect, Fit* fit) {
  const Candidate slip = effects()[effect].candidate;
  const MeasuringRun& run = fit->problem.runs[slip.run];
  const auto [first, last] = ShortSideOf(slip, run);
  int aside = 0;
  for (int row = first; row < last; row += run.row_count) {
    const auto rows = fit->problem.is_used[slip.run].begin() + row;
    aside += !std::all_of(rows, rows + run.row_count, [](bool used) { return used; });
  }
  if (2 * aside * run.row_count <= last - first) return false;
  const Extension before = extension();
  const std::string name = extension().NameOf(effect);
  effects().erase(effects().begin() + static_cast<std::ptrdiff_t>(effect));
  for (int row = first; row < last; ++row) extension().bad_rows.push_back({slip.run, static_cast<size_t>(row)});
  ASSIGN_OR_RETURN(const bool is_fitted, Change(before, fit));
  if (!is_fitted) return false;
  attempt_->Note(SelectionStep::kDropped, name, *fit);
  attempt_->refused.push_back(slip);
  return true;
}

// Before a slip is known, readings near it fit neither side, may be set aside, and its moment is then found without
// them. Where some were set aside the moment is found again from all readings near it, with the known displacement.
absl::Status Growth::SettleMoment(size_t effect, Fit* fit) {
  constexpr int kBeyond = 2, kLongest = 48;  // readings
  constexpr double kAtMost = 36.0;           // chi-square that a bad reading counts
  Candidate& slip = effects()[effect].candidate;
  const MeasuringRun& run = fit->problem.runs[slip.run];
  const int first = std::max(1, slip.earliest - kBeyond);
  const int last = std::min(run.reading_count() - 1, slip.latest + kBeyond);
  const auto used = fit->problem.is_used[slip.run].begin();
  const bool is_whole = std::all_of(used + std::ptrdiff_t{first - 1} * run.row_count,
                                    used + std::ptrdiff_t{last} * run.row_count, [](bool one) { return one; });
  if (is_whole || last - first > kLongest) return absl::OkStatus();
  const int group = fit->problem.group_of_run[slip.run];
  identify::Problem alone;
  alone.machine = fit->problem.machine;
  alone.runs = {run};
  alone.groups = {fit->problem.groups[group]};
  alone.group_of_run = {0};
  const identify::Point point{fit->point.model, {fit->point.setup[group]}};
  instruments::Slip& moved = alone.runs[0].slips[(extension().SetupOf(effect) - extension().FirstSlipOf(slip.run)) / 3];
  const double variance = std::pow(fit->problem.noise[slip.run].sigma_mm, 2);
  std::vector<double> squares;
  for (int moment = first; moment <= last; ++moment) {
    moved.first_reading = moment;
    const Eigen::MatrixXd residuals_mm = identify::ResidualsOf(alone, point)[0];
    const auto near = residuals_mm.middleCols(first - 1, last - first + 1).array();
    squares.push_back((near.square() / variance).min(kAtMost).sum());
  }
  const auto best = std::min_element(squares.begin(), squares.end());
  const double least = *best;
  const auto is_likely = [&](double value) { return value < least + options_.search.indistinguishable; };
  const Extension before = extension();
  const int moment = slip.first_reading;
  slip.first_reading = first + static_cast<int>(best - squares.begin());
  slip.earliest = first + static_cast<int>(std::find_if(squares.begin(), squares.end(), is_likely) - squares.begin());
  slip.latest = last - static_cast<int>(std::find_if(squares.rbegin(), squares.rend(), is_likely) - squares.rbegin());
  if (slip.first_reading == moment) return absl::OkStatus();
  return Change(before, fit).status();
}

// True where the added slip is none: its readings are bad.
absl::StatusOr<bool> Growth::SettleSlip(size_t effect, Fit* fit) {
  ASSIGN_OR_RETURN(const bool is_bad, SetScatteredAside(effect, fit));
  if (is_bad) return true;
  RETURN_IF_ERROR(SettleMoment(effect, fit));
  return SetScatteredAside(effect, fit);
}

// Readings that were set aside and agree with the effects found since are not bad.
absl::StatusOr<bool> Growth::TakeBack(Fit* fit) {
  constexpr double kAgrees = 4.0;  // standard deviations
  std::vector<BadRow>& bad_rows = extension().bad_rows;
  const Extension before = extension();
  std::erase_if(bad_rows, [fit](const BadRow& one) {
    return std::abs(fit->residuals_mm[one.run].data()[one.row]) < kAgrees * fit->problem.noise[one.run].sigma_mm;
  });
  if (bad_rows.size() == before.bad_rows.size() || attempt_->has_taken_back) {
    bad_rows = before.bad_rows;
    return false;
  }
  attempt_->has_taken_back = true;  // what stands out again stays aside
  return Change(before, fit);
}

// Drops slips that explain less than an effect of three amplitudes must, now that more is known, and those that were
// bad readings.
absl::Status Growth::DropSlips(Fit* fit) {
  constexpr int kOffsets = 3;
  const double needed = options_.search.evidence + options_.search.per_column * (kOffsets - 1);
  for (size_t i = effects().size(); i-- > 0;) {
    const Candidate slip = effects()[i].candidate;
    if (slip.family != Family::kStep) continue;
    ASSIGN_OR_RETURN(const bool is_bad, SetScatteredAside(i, fit));
    if (is_bad) continue;
    // All three offsets together are worth at least as much as any one of them.
    double worth = 0.0;
    for (size_t k = 0; k < kOffsets; ++k) {
      const identify::SetupOffset& offset = fit->result.sessions[slip.run].setup[extension().SetupOf(i) + k];
      worth = std::max(worth, offset.value * offset.value / (offset.sigma * offset.sigma));
    }
    if (worth >= needed) continue;
    const std::string name = extension().NameOf(i);
    const Extension before = extension();
    effects().erase(effects().begin() + static_cast<std::ptrdiff_t>(i));
    const absl::StatusOr<Fit> without = RefitRuns(*fit, extension().Runs(), identify_options_);
    if (absl::IsCancelled(without.status())) return without.status();
    if (!without.ok() || SquaresOf(*without) - SquaresOf(*fit) >= needed) {
      extension() = before;
      continue;
    }
    // Without it, readings that stand out beside it would count as structure, and become a slip again.
    const auto [first, last] = ShortSideOf(slip, fit->problem.runs[slip.run]);
    for (int row = first; row < last; ++row) {
      if (!fit->problem.is_used[slip.run][row]) extension().bad_rows.push_back({slip.run, static_cast<size_t>(row)});
    }
    ASSIGN_OR_RETURN(const bool is_fitted, Change(before, fit));
    if (!is_fitted) continue;
    attempt_->Note(SelectionStep::kDropped, name, *fit);
    attempt_->refused.push_back(slip);
  }
  return absl::OkStatus();
}

}  // namespace axiscal::loop
