#include "core/nc/advice.h"

#include <algorithm>
#include <cctype>
#include <numeric>

#include "absl/strings/str_cat.h"

namespace axiscal::nc {
namespace {

constexpr char kHarmless[] = "--harmless-m ";

bool Has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// The digits behind `part`, or "".
std::string NumberBehind(const std::string& text, const std::string& part) {
  const size_t found = text.find(part);
  if (found == std::string::npos) return "";
  size_t end = found + part.size();
  while (end < text.size() && std::isdigit(static_cast<unsigned char>(text[end]))) ++end;
  return text.substr(found + part.size(), end - found - part.size());
}

// "5" or "T5D1" behind `part`, or "".
std::string ToolNumberBehind(const std::string& text, const std::string& part) {
  const std::string plain = NumberBehind(text, part);
  if (!plain.empty()) return plain;
  const std::string tool = NumberBehind(text, part + "T");
  const std::string head = absl::StrCat("T", tool, "D");
  const std::string edge = NumberBehind(text, part + head);
  return tool.empty() || edge.empty() ? "" : head + edge;
}

// As programs write words: X, Y, Z, A, B, C ...
size_t WordPlace(const std::string& name) {
  const size_t place = std::string("XYZABCUVW").find(name[0]);
  return place == std::string::npos ? 9 : place;
}

// --offset "G54 X=... Y=...", with all axes of the machine.
std::string Offset(const std::string& code, const machine::Machine& machine) {
  std::string text = "--offset \"" + code;
  for (const int axis : InWordOrder(machine)) absl::StrAppend(&text, " ", machine.axes[axis].name, "=...");
  return text + "\"";
}

}  // namespace

std::vector<int> InWordOrder(const machine::Machine& machine) {
  std::vector<int> axes(static_cast<size_t>(machine.axis_count()));
  std::iota(axes.begin(), axes.end(), 0);
  std::stable_sort(axes.begin(), axes.end(), [&machine](int a, int b) {
    return WordPlace(machine.axes[a].name) < WordPlace(machine.axes[b].name);
  });
  return axes;
}

std::vector<std::string> MissingOptions(const std::string& reason, const machine::Machine& machine) {
  std::vector<std::string> options;
  const auto add = [&options](std::string option) { options.push_back(std::move(option)); };
  // "G54.1 P6 (additional work offset): its values are not stated"
  if (const size_t at = reason.find("): its values are not stated"); at != std::string::npos) {
    const std::string code = reason.substr(0, reason.rfind(" (", at));
    add(Offset(code.substr(code.rfind(": ") == std::string::npos ? 0 : code.rfind(": ") + 2), machine));
  }
  // "state it with --offset "PRESET 3 X=..."
  if (const size_t at = reason.find("--offset \""); at != std::string::npos) {
    const size_t begin = at + std::string("--offset \"").size();
    add(Offset(reason.substr(begin, reason.find(" X=", begin) - begin), machine));
  }
  std::string length = ToolNumberBehind(reason, "tool length ");
  if (!Has(reason, ": its value is not stated")) length.clear();
  if (length.empty() && Has(reason, ": the tool's length is not stated")) length = NumberBehind(reason, "TOOL CALL ");
  if (!length.empty()) add(absl::StrCat("--tool-length ", length[0] == 'T' ? "" : "H", length, "=..."));
  for (const char letter : {'D', 'T'}) {
    const std::string radius = NumberBehind(reason, std::string("--tool-radius ") + letter);
    if (!radius.empty() && !Has(reason, absl::StrCat("--tool-radius T", radius, "D")))
      add(absl::StrCat("--tool-radius ", std::string(1, letter), radius, "=..."));
  }
  if (const std::string radius = ToolNumberBehind(reason, "--tool-radius "); !radius.empty())
    add(absl::StrCat("--tool-radius ", radius, "=..."));
  if (const std::string code = NumberBehind(reason, kHarmless); !code.empty()) add(kHarmless + code);
  if (Has(reason, "state --block-delete")) add("--block-delete executed (or skipped)");
  if (Has(reason, "--unit mm or --unit")) add(kUnitAdvice);
  if (Has(reason, "nor in a file of --subprograms")) add("--subprograms FOLDER --subprograms-out FOLDER");
  return options;
}

void MergeHarmless(std::vector<std::string>* options) {
  std::string codes;
  std::erase_if(*options, [&codes](const std::string& option) {
    if (option.rfind(kHarmless, 0) != 0) return false;
    absl::StrAppend(&codes, codes.empty() ? "" : ",", option.substr(std::string(kHarmless).size()));
    return true;
  });
  if (!codes.empty()) options->push_back(kHarmless + codes + " (only if they start no macro and move no axis)");
}

}  // namespace axiscal::nc
