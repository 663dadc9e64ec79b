// What a request names: machines, sessions, jobs, calibrations, programs. Found by the names of its fields, wherever in
// the message they stand, so that no message needs code of its own and a new field is not forgotten.
#ifndef AXISCAL_SERVER_ACCESS_NAMED_H_
#define AXISCAL_SERVER_ACCESS_NAMED_H_

#include <google/protobuf/message.h>

#include <optional>
#include <string>
#include <vector>

#include "server/storage/records.h"

namespace axiscal::access {

// What a field of this name names. Nothing for `request_id`, `token_id` and `after_change_id`, which are no places, and
// for fields that name nothing. Every field of a request whose name ends in "_id" or "_ids" must be known here (a test
// holds that).
std::optional<storage::ResourceKind> KindOf(const std::string& field_name);
bool IsKnownId(const std::string& field_name);

// Each once, machines first; what is not set ("" or 0, which no row has) is not named. The machine of a description is
// its id, where it can be read.
std::vector<storage::Resource> NamedIn(const google::protobuf::Message& request);

}  // namespace axiscal::access

#endif  // AXISCAL_SERVER_ACCESS_NAMED_H_
