#include "core/loop/extension.h"

#include <algorithm>

#include "core/instruments/distortion.h"

namespace axiscal::loop {

using instruments::MeasuringRun;

machine::ErrorModel Extension::Model() const {
  machine::ErrorModel model = machine::DeclaredModel(*machine_);
  for (const Added& one : effects) {
    if (IsTerm(one.candidate.family)) model.terms.push_back(one.candidate.term);
  }
  return model;
}

int Extension::TermOf(size_t effect) const {
  int term = static_cast<int>(machine::DeclaredModel(*machine_).terms.size());
  for (size_t i = 0; i < effect; ++i) term += IsTerm(effects[i].candidate.family);
  return term;
}

std::vector<MeasuringRun> Extension::Runs() const {
  std::vector<MeasuringRun> runs = *runs_;
  for (const Added& one : effects) {
    if (one.candidate.family != Family::kInstrument) continue;
    for (MeasuringRun& run : runs)
      if (instruments::CanHave(run, one.candidate.distortion)) AddDistortion(one.candidate.distortion, &run);
  }
  for (const Added& one : effects) {
    const Candidate& slip = one.candidate;
    if (slip.family == Family::kStep) instruments::AddSlip({slip.carrier, slip.first_reading}, &runs[slip.run]);
  }
  for (const BadRow& bad : bad_rows) runs[bad.run].bad_rows.push_back(bad.row);
  return runs;
}

size_t Extension::AmplitudesOf(size_t effect, int run) const {
  const MeasuringRun& of = (*runs_)[run];
  size_t at = of.setup.size();
  for (size_t i = 0; i < effect; ++i) {
    const Candidate& one = effects[i].candidate;
    if (one.family == Family::kInstrument && instruments::CanHave(of, one.distortion))
      at += static_cast<size_t>(instruments::AmplitudeCount(one.distortion, of.row_count));
  }
  return at;
}

size_t Extension::FirstSlipOf(int run) const { return AmplitudesOf(effects.size(), run); }

size_t Extension::SetupOf(size_t effect) const {
  const int run = effects[effect].candidate.run;
  size_t at = FirstSlipOf(run);
  for (size_t i = 0; i < effect; ++i) {
    const bool is_before = effects[i].candidate.family == Family::kStep && effects[i].candidate.run == run;
    if (is_before) at += 3;
  }
  return at;
}

std::string Extension::NameOf(size_t effect) const {
  const Candidate& candidate = effects[effect].candidate;
  if (IsTerm(candidate.family)) return machine::NameOf(*machine_, candidate.term);
  if (candidate.family == Family::kInstrument)
    return absl::StrCat("the instrument: ", instruments::TextOf(candidate.distortion));
  return absl::StrCat("a slip in session ", (*runs_)[candidate.run].session);
}

}  // namespace axiscal::loop
