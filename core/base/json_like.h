// What a struct needs to tell its members for JSON (json_members.h) without the JSON library.
#ifndef AXISCAL_CORE_BASE_JSON_LIKE_H_
#define AXISCAL_CORE_BASE_JSON_LIKE_H_

#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace axiscal::base {

// T& for a reader, const T& for a writer.
template <typename Io, typename T>
using Like = std::conditional_t<Io::kReads, T&, const T&>;

// The members of an object whose names are data (axes, set-up offsets), in the order of the text.
template <typename T>
using Named = std::vector<std::pair<std::string, T>>;

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_JSON_LIKE_H_
