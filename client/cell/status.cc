#include "client/cell/status.h"

#include <nlohmann/json.hpp>

namespace axiscal::cell {

std::string WriteStatus(const Status& status) {
  using Json = nlohmann::ordered_json;
  Json folders = Json::array();
  for (const FolderStatus& folder : status.folders) {
    folders.push_back({{"folder", folder.folder},
                       {"growing", folder.growing},
                       {"without_end", folder.without_end},
                       {"links", folder.links},
                       {"problem", folder.problem}});
  }
  Json json = {{"cell", status.cell},
               {"version", status.version},
               {"server", status.server},
               {"at_utc_us", base::ToUtcUs(status.at)},
               {"ok", status.alarms.empty() && status.problem.empty()},
               {"doing", status.doing},
               {"doing_since_utc_us", status.doing.empty() ? Json() : Json(base::ToUtcUs(status.doing_since))},
               {"not_told", status.not_told},
               {"connected", status.is_connected},
               {"waiting", status.spool.waiting},
               {"waiting_bytes", status.spool.waiting_bytes},
               {"quarantined", status.spool.refused},
               {"quarantined_bytes", status.spool.refused_bytes},
               {"copies", status.spool.sent},
               {"copies_bytes", status.spool.sent_bytes},
               {"max_bytes", status.max_bytes},
               {"sent_since_start", status.sent},
               {"refused_since_start", status.refused},
               {"last_sent", status.last_sent},
               {"last_sent_utc_us", nullptr},
               {"problem", status.problem},
               {"folders", folders},
               {"alarms", status.alarms}};
  if (status.last_sent_at) json["last_sent_utc_us"] = base::ToUtcUs(*status.last_sent_at);
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace axiscal::cell
