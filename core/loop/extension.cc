#include "core/loop/extension.h"

#include <algorithm>

namespace axiscal::loop {
namespace {

using instruments::MeasuringRun;

MeasuringRun Part(const MeasuringRun& run, int begin, int end, const std::string& name) {
  MeasuringRun part = run;
  part.session = part.setup_name = name;
  const size_t axes = run.axis_count;
  part.positions.assign(run.positions.begin() + begin * axes, run.positions.begin() + end * axes);
  part.axis_states.assign(run.axis_states.begin() + begin * axes, run.axis_states.begin() + end * axes);
  part.time_s.assign(run.time_s.begin() + begin, run.time_s.begin() + end);
  part.temperature_celsius.assign(run.temperature_celsius.begin() + begin, run.temperature_celsius.begin() + end);
  part.measured_mm = run.measured_mm.middleCols(begin, end - begin);
  if (run.kind == instruments::Kind::kTouch) {
    const touch::Touches& touches = run.touches;
    part.touches.feature_of.assign(touches.feature_of.begin() + begin, touches.feature_of.begin() + end);
    part.touches.approach.assign(touches.approach.begin() + begin, touches.approach.begin() + end);
    part.touches.approach_in_spindle.assign(touches.approach_in_spindle.begin() + begin,
                                            touches.approach_in_spindle.begin() + end);
    part.touches.rejected.clear();
    for (touch::Rejection rejection : touches.rejected) {
      if (rejection.reading < begin || rejection.reading >= end) continue;
      rejection.reading -= begin;
      part.touches.rejected.push_back(std::move(rejection));
    }
  }
  return part;
}

}  // namespace

machine::ErrorModel Extension::Model() const {
  machine::ErrorModel model = machine::DeclaredModel(*machine_);
  for (const Added& one : effects) {
    if (one.candidate.family != Family::kStep) model.terms.push_back(one.candidate.term);
  }
  return model;
}

int Extension::TermOf(size_t effect) const {
  int term = static_cast<int>(machine::DeclaredModel(*machine_).terms.size());
  for (size_t i = 0; i < effect; ++i) term += effects[i].candidate.family != Family::kStep;
  return term;
}

std::vector<MeasuringRun> Extension::Runs() const {
  std::vector<MeasuringRun> out;
  for (size_t i = 0; i < runs_->size(); ++i) {
    std::vector<int> cuts = {0};
    for (const Added& one : effects) {
      if (one.candidate.family == Family::kStep && one.candidate.run == static_cast<int>(i))
        cuts.push_back(one.candidate.first_reading);
    }
    std::sort(cuts.begin(), cuts.end());
    cuts.push_back((*runs_)[i].reading_count());
    for (size_t c = 0; c + 1 < cuts.size(); ++c) {
      if (cuts.size() == 2) {
        out.push_back((*runs_)[i]);
      } else {
        out.push_back(Part((*runs_)[i], cuts[c], cuts[c + 1], absl::StrCat((*runs_)[i].session, "#", c + 1)));
      }
    }
  }
  return out;
}

void Extension::MapSlip(const identify::Problem& problem, Candidate* candidate) const {
  const MeasuringRun& part = problem.runs[candidate->run];
  for (size_t i = 0; i < runs_->size(); ++i) {
    const bool is_whole = (*runs_)[i].session == part.session;
    const bool is_part = part.session.rfind((*runs_)[i].session + "#", 0) == 0;
    if (!is_whole && !is_part) continue;
    int before = 0;
    while ((*runs_)[i].time_s[before] < part.time_s.front()) ++before;
    candidate->run = static_cast<int>(i);
    candidate->first_reading += before;
    candidate->earliest += before;
    candidate->latest += before;
    return;
  }
}

std::string Extension::NameOf(size_t effect) const {
  const Candidate& candidate = effects[effect].candidate;
  if (candidate.family != Family::kStep) return machine::NameOf(*machine_, candidate.term);
  return absl::StrCat("a slip in session ", (*runs_)[candidate.run].session);
}

void SetClass(const Finding& finding, Added* added) {
  const auto fill = [&](const std::vector<Scored>& from, std::vector<Candidate>* to) {
    for (const Scored& other : from) {
      const auto is_listed = [&](const Candidate& one) { return IsSameEffect(one.term, other.candidate.term); };
      if (IsUnnamed(other.candidate.family) || is_listed(added->candidate) ||
          std::any_of(added->equivalent.begin(), added->equivalent.end(), is_listed) ||
          std::any_of(to->begin(), to->end(), is_listed))
        continue;
      to->push_back(other.candidate);
    }
  };
  added->equivalent.clear();
  added->rivals.clear();
  fill(finding.equivalent, &added->equivalent);
  fill(finding.rivals, &added->rivals);
}

}  // namespace axiscal::loop
