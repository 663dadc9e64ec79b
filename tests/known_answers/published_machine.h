// Machines of publications: the descriptions that the worked examples ship.
#ifndef AXISCAL_TESTS_KNOWN_ANSWERS_PUBLISHED_MACHINE_H_
#define AXISCAL_TESTS_KNOWN_ANSWERS_PUBLISHED_MACHINE_H_

#include <string>
#include <vector>

#include "core/base/demand.h"
#include "core/base/testing/source_path.h"
#include "core/machine/machine_json.h"

namespace axiscal::known_answers {

// `name` below deploy/examples; `declared` in place of the description's, where given.
inline machine::Machine PublishedMachine(const std::string& name, const std::vector<std::string>& declared = {}) {
  auto machine = machine::ReadMachineFile(base::SourcePath("/deploy/examples/") + name);
  DEMAND(machine.ok());
  if (!declared.empty()) machine->declared.clear();
  for (const std::string& symbol : declared) machine->declared.push_back(machine::ParseErrorSymbol(symbol).value());
  return *std::move(machine);
}

}  // namespace axiscal::known_answers

#endif  // AXISCAL_TESTS_KNOWN_ANSWERS_PUBLISHED_MACHINE_H_
