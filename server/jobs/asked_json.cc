#include "server/jobs/asked_json.h"

#include <nlohmann/json.hpp>

namespace axiscal::jobs {
namespace {

using json = nlohmann::ordered_json;

template <typename Params>
void AddSimulation(const Params& params, json* asked) {
  if (!params.budget_json.empty()) (*asked)["budget"] = json::parse(params.budget_json);
  if (params.monte_carlo_runs)
    (*asked)["monte_carlo"] = {{"runs", *params.monte_carlo_runs}, {"seed", params.monte_carlo_seed}};
}

json SessionsJson(const std::vector<records::SessionRecord>& records) {
  json sessions = json::array();
  for (const records::SessionRecord& record : records)
    sessions.push_back({{"id", record.id.number()}, {"session", record.name}, {"hash", record.hash}});
  return sessions;
}

}  // namespace

std::string AskedJson(const records::IdentifyParams& params) {
  json asked = {{"declared", params.declared}};
  AddSimulation(params, &asked);
  if (params.held_calibration) asked["held"] = {{"calibration", params.held_calibration->number()}};
  if (!params.held_errors_json.empty()) asked["held"] = json::parse(params.held_errors_json);
  return asked.dump();
}

std::string AskedJson(const records::CloseLoopParams& params, const std::vector<records::SessionRecord>& fit,
                      const std::vector<records::SessionRecord>& check) {
  json asked = {{"fit", SessionsJson(fit)}, {"check", SessionsJson(check)}};
  if (params.max_effects) asked["max_effects"] = *params.max_effects;
  AddSimulation(params, &asked);
  return asked.dump();
}

}  // namespace axiscal::jobs
