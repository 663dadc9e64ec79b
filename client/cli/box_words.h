// A box of axis positions and poses in it, as options state them and as output shows them: mm, or deg of rotary axes.
#ifndef AXISCAL_CLIENT_CLI_BOX_WORDS_H_
#define AXISCAL_CLIENT_CLI_BOX_WORDS_H_

#include <string>
#include <vector>

#include "client/cli/context.h"
#include "core/predict/box_poses.h"

namespace axiscal::cli {

// "X -200 300", what --box states of one axis. INVALID_ARGUMENT naming the text.
absl::Status SetBoxRange(const std::string& text, const machine::Machine& machine, predict::Box* box);

// "X -200 to 300 mm, B 0 to 90 deg"; an object per axis with `axis`, `from`, `to`, `unit`.
std::string BoxText(const machine::Machine& machine, const predict::Box& box);
Json BoxJson(const machine::Machine& machine, const predict::Box& box);

// "X300 B90" and {"X": 300, "B": 90}; positions per axis, mm or rad.
std::string PoseText(const machine::Machine& machine, const std::vector<double>& positions);
Json PoseJson(const machine::Machine& machine, const std::vector<double>& positions);

// Three components in um.
Json VectorJson(const Eigen::Vector3d& mm);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_BOX_WORDS_H_
