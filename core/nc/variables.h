// Variables that a program sets itself (#100, #<depth>, R1, _TOL, Q1), and expressions of them. What is set by a number
// or by an expression of known ones is known until somebody else may have changed it.
#ifndef AXISCAL_CORE_NC_VARIABLES_H_
#define AXISCAL_CORE_NC_VARIABLES_H_

#include <map>
#include <optional>
#include <string>

#include "core/nc/dialect.h"

namespace axiscal::nc {

class Variables {
 public:
  // By name as NameOfVariable gives it. nullopt: not known.
  std::optional<double> Value(const std::string& name) const;
  void Set(const std::string& name, std::optional<double> value);
  void ForgetAll() { values_.clear(); }
  // Q100 and above of Klartext: the control and its cycles write them.
  void ForgetOfCycles();
  // Those that belong to one macro or subprogram: #1 to #33, #<name>.
  void ForgetLocals();
  // Those of LinuxCNC that a subprogram leaves to its caller as they were: #1 to #30, and names without '_' in front.
  void TakeLocals(const Variables& caller);

 private:
  std::map<std::string, double> values_;
};

// Where the variable that begins at `at` ends, and its name: "#100", "#<depth>", "R1", "Q5", "_TOL". nullptr: none
// begins there, or it is one of the controller (#5221 is a work offset).
const char* EndOfVariable(const char* at, const char* end, const Dialect& dialect, std::string* name);

// The value of the expression at `*at`, which stands behind it then: "#100", "[#1+2*#2]", "R1*2", "Q3". nullopt, and
// `*at` as it was: it is not one that is read, or holds what is not known.
std::optional<double> Evaluate(const char** at, const char* end, const Dialect& dialect, const Variables& variables);
// The same of what stands right of '=', where sums need no brackets.
std::optional<double> EvaluateSum(const char** at, const char* end, const Dialect& dialect, const Variables& variables);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_VARIABLES_H_
