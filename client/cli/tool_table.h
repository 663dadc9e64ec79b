// Tables of tool lengths as controls keep them, by what they look like:
//   LinuxCNC     T5 P5 D6.0 Z120.5 ; drill                          Z is the length of T (and of H, its number), D
//                                                                   the diameter
//   Fanuc, Haas  G10 L10 P5 R120.5                                  H5; with L11 (wear) added. L12, L13: radius of D5
//                                                                   (where the control keeps diameters: --tool-radius)
//   Sinumerik    $TC_DP3[5,1]=120.5, $TC_DP12[5,1]=0.01             D1 of tool 5: length 1 and its wear; $TC_DP6 and
//                                                                   $TC_DP15 of its radius
//   Heidenhain   BEGIN TOOL .T MM, a line of names, and lines below  T, L, DL, R and DR of the columns
// They are in mm where the table does not say inch (G20, BEGIN TOOL .T INCH).
#ifndef AXISCAL_CLIENT_CLI_TOOL_TABLE_H_
#define AXISCAL_CLIENT_CLI_TOOL_TABLE_H_

#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/nc/options.h"

namespace axiscal::cli {

struct ToolTable {
  std::vector<nc::ToolLength> lengths;  // other than zero, by number
  std::vector<nc::ToolRadius> radii;    // that are stated
};

// Of all tools in the text. INVALID_ARGUMENT with `path` and the line: it is none of these tables, a number cannot be
// read, or one number has two lengths or radii (D1 of two tools).
absl::StatusOr<ToolTable> ParseToolTable(const std::string& text, const std::string& path);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_TOOL_TABLE_H_
