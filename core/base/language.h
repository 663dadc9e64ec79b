// In which language a text for people is written.
#ifndef AXISCAL_CORE_BASE_LANGUAGE_H_
#define AXISCAL_CORE_BASE_LANGUAGE_H_

#include <algorithm>
#include <string>

namespace axiscal::base {

enum class Language { kEnglish, kGerman };

// A number that was written with a point, as the language writes it.
inline std::string NumberIn(Language language, std::string text) {
  if (language == Language::kGerman) std::replace(text.begin(), text.end(), '.', ',');
  return text;
}

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_LANGUAGE_H_
