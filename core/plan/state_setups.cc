#include "core/plan/state_setups.h"

#include <set>

#include "core/plan/planned_run.h"
#include "core/session/text.h"

namespace axiscal::plan {

absl::Status StateSetups(const machine::Machine& machine, const std::vector<std::string>& stated,
                         const std::vector<session::Session*>& plan) {
  std::vector<std::vector<instruments::SetupParameter>> setups;
  for (size_t i = 0; i < plan.size() && !stated.empty(); ++i) {
    ASSIGN_OR_RETURN(instruments::MeasuringRun run, PlannedRun(machine, *plan[i]));
    if (run.kind == instruments::Kind::kTouch) {  // one line for all of its features
      std::erase_if(run.setup, [](const auto& parameter) { return parameter.name.starts_with("feature_"); });
      run.setup.push_back({"feature", 0.0});
    }
    setups.push_back(std::move(run.setup));
  }
  for (const std::string& text : stated) {
    const size_t blank = text.find(' ');
    std::vector<double> sigma;
    const bool is_stated = blank != std::string::npos && session::ParseNumbers(text.substr(blank + 1), &sigma) &&
                           sigma.size() == 1 && sigma[0] > 0.0;
    if (!is_stated) {
      return absl::InvalidArgumentError(absl::StrCat(
          "'", text, "': expected \"OFFSET SIGMA\", a set-up offset and its sigma in um or urad, above 0"));
    }
    const std::string offset = text.substr(0, blank);
    std::set<std::string> known;
    bool is_anywhere = false;
    for (size_t i = 0; i < plan.size(); ++i) {
      for (const instruments::SetupParameter& parameter : setups[i]) {
        known.insert(parameter.name);
        if (parameter.name != offset) continue;
        is_anywhere = true;
        const std::string key = absl::StrCat(offset, parameter.is_angle ? "_sigma_urad" : "_sigma_um");
        std::erase_if(plan[i]->header, [&](const session::HeaderEntry& entry) { return entry.key == key; });
        plan[i]->header.push_back({key, absl::StrFormat("%.10g", sigma[0])});
      }
    }
    if (is_anywhere) continue;
    std::string names;
    for (const std::string& name : known) absl::StrAppend(&names, names.empty() ? "" : ", ", name);
    return absl::InvalidArgumentError(
        absl::StrCat("'", text, "': no session of the plan has a set-up offset ", offset, ", expected one of ", names));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::plan
