// Tables 4.3 and 4.4 of Yao 2022: ball-bar set-ups and the eccentricities measured with them, three runs.
#ifndef AXISCAL_TESTS_KNOWN_ANSWERS_YAO_TABLES_H_
#define AXISCAL_TESTS_KNOWN_ANSWERS_YAO_TABLES_H_

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "core/base/testing/source_path.h"

namespace axiscal::known_answers {

struct BarSetup {
  double tool_length_mm = NAN, zc_mm = NAN, zt_mm = NAN, xt_mm = NAN;
};

struct YaoTables {
  std::map<std::string, BarSetup> setups;                        // by step: "CR-long"
  std::map<std::string, std::array<double, 3>> eccentricity_um;  // "BX ex"

  double MeanUm(const std::string& name) const {
    const std::array<double, 3>& runs = eccentricity_um.at(name);
    return (runs[0] + runs[1] + runs[2]) / 3.0;
  }
};

inline std::vector<std::vector<std::string>> ReadTable(const std::string& name) {
  std::ifstream file(base::SourcePath("/tests/data/yao/") + name);
  EXPECT_TRUE(file.is_open()) << name;
  std::vector<std::vector<std::string>> rows;
  std::string line;
  std::getline(file, line);  // column names
  while (std::getline(file, line)) rows.push_back(absl::StrSplit(line, ','));
  return rows;
}

inline double Number(const std::string& text) {
  double number = NAN;
  EXPECT_TRUE(absl::SimpleAtod(text, &number)) << text;
  return number;
}

inline YaoTables ReadYaoTables() {
  YaoTables tables;
  for (const auto& row : ReadTable("table-4.4-eccentricity.csv"))
    tables.eccentricity_um[row[1] + " " + row[2]] = {Number(row[3]), Number(row[4]), Number(row[5])};
  for (const auto& row : ReadTable("table-4.3-setup.csv"))
    tables.setups[row[1]] = {Number(row[2]), Number(row[3]), Number(row[4]), Number(row[5])};
  return tables;
}

}  // namespace axiscal::known_answers

#endif  // AXISCAL_TESTS_KNOWN_ANSWERS_YAO_TABLES_H_
