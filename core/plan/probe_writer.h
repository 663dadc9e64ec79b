// Blocks of a probing program, in axis positions: rapid moves and touches of the stylus centre, each touch printed.
#ifndef AXISCAL_CORE_PLAN_PROBE_WRITER_H_
#define AXISCAL_CORE_PLAN_PROBE_WRITER_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/machine/machine.h"

namespace axiscal::plan {

// How a control touches: "G31" with a DPRNT line behind it (Fanuc, Mazak, Haas); "G38.2", which LinuxCNC logs by itself
// between PROBEOPEN and PROBECLOSE; or "MEAS=1 G01" with a WRITE of $AA_MM behind it (Sinumerik), which jumps to
// the label NO_TOUCH where nothing was touched.
enum class TouchLog { kDprnt, kOfTheControl, kSinumerik };
struct ProbeDialect {
  std::string skip = "G31";
  TouchLog log = TouchLog::kDprnt;
};

// What prints where the axes stood at the trigger, behind the block that was stopped by it.
std::string PrintOf(const machine::Machine& machine, const ProbeDialect& dialect);

class ProbeWriter {
 public:
  // `tip_mm`: stylus centre at home, machine frame; the feed (mm/min) is that of touches.
  ProbeWriter(const machine::Machine& machine, const Eigen::Vector3d& tip_mm, const ProbeDialect& dialect,
              double feed_mm_min);

  // G00, or a touch, to where the stylus centre stands at `target_mm` of the table at home, with the rotary axes of
  // `positions` (mm or rad per axis). FAILED_PRECONDITION where the linear axes do not reach or travel ends.
  absl::Status Move(const std::vector<double>& positions, const Eigen::Vector3d& target_mm);
  absl::Status Touch(const std::vector<double>& positions, const Eigen::Vector3d& target_mm);
  std::string Take() { return std::move(text_); }

 private:
  absl::Status Block(const std::string& code, const std::vector<double>& positions, const Eigen::Vector3d& target_mm,
                     const std::string& feed);

  const machine::Machine& machine_;
  const Eigen::Vector3d tip_mm_;
  const ProbeDialect dialect_;
  const std::string feed_, print_;
  std::string text_;
};

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_PROBE_WRITER_H_
