// Who gives way where more are there than may be: of the host that has most, so that one host's many take no place of
// another's few.
#ifndef AXISCAL_SERVER_ACCESS_CROWD_H_
#define AXISCAL_SERVER_ACCESS_CROWD_H_

#include <cstddef>
#include <string>
#include <vector>

namespace axiscal::access {

// Of connections, the first to come first, with the host of each (PeerHost()): the places in `hosts` of those that are
// to be ended for `most` to be left. Again and again the first of the host that has most.
std::vector<size_t> BeyondTheMost(const std::vector<std::string>& hosts, size_t most);

}  // namespace axiscal::access

#endif  // AXISCAL_SERVER_ACCESS_CROWD_H_
