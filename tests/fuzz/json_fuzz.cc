// JSON of any bytes: the strict reader takes no more than the library does, and gives the same; and every document that
// is read by it beside machines and errors: scenarios, cutters, reports of jobs.
#include "core/base/strict_json.h"
#include "core/machine/testing/machines.h"
#include "core/reports/calibration.h"
#include "core/reports/identification.h"
#include "core/reports/loop.h"
#include "core/reports/rewrite.h"
#include "core/reports/table.h"
#include "core/reports/tool_setter.h"
#include "core/synthetic/scenario.h"
#include "core/toolsetter/cutter_keys.h"
#include "tests/fuzz/driver.h"

namespace axiscal::fuzz {
namespace {

template <typename Result>
void MustBeReadOrRefused(const Result& result) {
  MUST(result.ok() || !result.status().message().empty());
}

}  // namespace

void Look(const std::string& bytes) {
  const auto document = base::ParseStrictJson(bytes);
  if (document.ok()) {
    const auto loose = nlohmann::ordered_json::parse(bytes, nullptr, false);
    MUST(!loose.is_discarded() && loose == *document);
    MUST(base::ShortJson(*document).size() < 100);
    const auto again = base::ParseStrictJson(document->dump());
    MUST(again.ok() && *again == *document);
  } else {
    MUST(absl::IsInvalidArgument(document.status()));
  }
  static const machine::Machine* const machine = new machine::Machine(machine::testing::MultiTasking());
  MustBeReadOrRefused(synthetic::ReadPlanSource(bytes));
  MustBeReadOrRefused(synthetic::ReadScenario(bytes, *machine));
  MustBeReadOrRefused(toolsetter::ReadCutterJson(bytes));
  MustBeReadOrRefused(toolsetter::HeaderOfCutter(bytes));
  MustBeReadOrRefused(reports::ReadCalibrationReport(bytes));
  MustBeReadOrRefused(reports::ReadIdentification(bytes));
  MustBeReadOrRefused(reports::ReadLoop(bytes));
  MustBeReadOrRefused(reports::ReadRewrite(bytes));
  MustBeReadOrRefused(reports::ReadTable(bytes));
  MustBeReadOrRefused(reports::ReadToolSetter(bytes));
}

}  // namespace axiscal::fuzz
