#include "core/published/comparison.h"

#include "core/published/sources.h"

namespace axiscal::published {

const std::vector<Source>& Sources() {
  static const auto& sources = *new std::vector<Source>{
      {"yao-table-4.5", "Yao 2022 (PhD thesis, TUAT), chapter 4, Table 4.5 from Tables 2.6, 4.3 and 4.4",
       "eccentricity sessions of BX, BY, CR, CA and of CR with a second tool; headers zt_mm and xt_mm", YaoTable45},
      {"yao-compensation", "Yao 2022 (PhD thesis, TUAT), chapter 4, the rule of Fig 4.30",
       "an NC program of linear moves in axis positions, --tool-tip, and errors with EB0B", nullptr, YaoCompensation},
      {"yao-equation-3.13", "Yao 2022 (PhD thesis, TUAT), chapter 3, equation 3.13 as printed",
       "an NC program of linear moves in axis positions, --tool-tip, and errors with EB0B", nullptr, YaoEquation313},
      {"ibaraki-maps",
       "Ibaraki, Iritani, Matsushita, \"Error calibration on five-axis machine tools ...\", eqs 6, 9, 12, 13",
       "one touch session of plane faces, over a grid of the table's two rotary axes with 0, 0 in it", IbarakiMaps},
  };
  return sources;
}

absl::StatusOr<const Source*> FindSource(const std::string& name) {
  std::string known;
  for (const Source& source : Sources()) {
    if (source.name == name) return &source;
    absl::StrAppend(&known, known.empty() ? "" : ", ", source.name);
  }
  return absl::InvalidArgumentError(absl::StrCat("'", name, "' is no published source, expected one of ", known));
}

}  // namespace axiscal::published
