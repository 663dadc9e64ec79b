// Cells of a CSV file that is written.
#ifndef AXISCAL_CORE_PREDICT_NUMBER_CELLS_H_
#define AXISCAL_CORE_PREDICT_NUMBER_CELLS_H_

#include <charconv>
#include <string>

namespace axiscal::predict {

// Appends `number` with `digits` behind the point, zero without a sign.
inline void AppendCell(double number, int digits, std::string* line) {
  char text[400];  // the largest double has 309 digits in front of the point
  const auto [end, error] = std::to_chars(text, text + sizeof(text), number, std::chars_format::fixed, digits);
  const bool is_negative_zero =
      text[0] == '-' && std::string_view(text, end).find_first_of("123456789") == std::string_view::npos;
  line->append(text + (is_negative_zero ? 1 : 0), end);
}

}  // namespace axiscal::predict

#endif  // AXISCAL_CORE_PREDICT_NUMBER_CELLS_H_
