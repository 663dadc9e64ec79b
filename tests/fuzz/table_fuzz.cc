// Compensation tables of any bytes, read by the reader of every format: finite values over nodes that rise, or an error
// with its line.
#include <algorithm>
#include <cmath>

#include "core/compensate/tables/format.h"
#include "core/machine/testing/machines.h"
#include "tests/fuzz/driver.h"

namespace axiscal::fuzz {
namespace {

bool AreFinite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

void LookAt(const compensate::Table& table) {
  for (const compensate::TableBlock& block : table.blocks) {
    for (const compensate::TableArgument& argument : block.arguments) {
      MUST(AreFinite(argument.nodes));
      MUST(std::is_sorted(argument.nodes.begin(), argument.nodes.end()));
    }
    for (const compensate::TableColumn& column : block.columns) {
      MUST(AreFinite(column.forward) && AreFinite(column.reverse));
    }
  }
}

}  // namespace

void Look(const std::string& bytes) {
  static const machine::Machine* const machines[] = {new machine::Machine(machine::testing::MultiTasking()),
                                                     new machine::Machine(machine::testing::TiltingTable())};
  for (const machine::Machine* const machine : machines) {
    for (const tables::Format& format : tables::Formats()) {
      if (format.read == nullptr) continue;
      const auto table = format.read(*machine, bytes);
      if (table.ok()) {
        LookAt(*table);
      } else {
        MUST(absl::IsInvalidArgument(table.status()) || absl::IsFailedPrecondition(table.status()));
      }
    }
  }
}

}  // namespace axiscal::fuzz
