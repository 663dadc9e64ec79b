// The multi-tasking machine of Yao 2022 in our terms. The thesis writes (mm, rad; M small displacements, E motions)
//   T = E_Z M_YZ E_Y M_XY E_X M_XB E_B M_BT [0, 0, -R_B],   W = M_CZ E_C W_C                          (2.1-2.17)
// Our chain is Z, Y, X, B on the tool branch, C on the work branch, each error on the parent side of its joint's
// motion, so M_YZ is the error of Y, M_XY that of X, M_XB that of B, M_BT that of T and M_CZ that of C; the signs are
// the same.
#ifndef AXISCAL_TESTS_KNOWN_ANSWERS_YAO_MACHINE_H_
#define AXISCAL_TESTS_KNOWN_ANSWERS_YAO_MACHINE_H_

#include <array>
#include <string>

#include "core/base/units.h"
#include "core/machine/error_model.h"
#include "core/machine/testing/machines.h"

namespace axiscal::known_answers {

// A number per deviation of the thesis: a deviation in mm or rad, or a coefficient of one.
struct Deviations {
  double aBT = 0, dxBT = 0, dzBT = 0, aXB = 0, bXB = 0, gXB = 0, gXY = 0, aYZ = 0, bYZ = 0, aCZ = 0, bCZ = 0, dxCZ = 0,
         dyCZ = 0;
};

struct NamedDeviation {
  std::string name;    // as in the thesis: a, b, g angles about X, Y, Z
  std::string symbol;  // ours
  double Deviations::*member;
};

inline const std::array<NamedDeviation, 13>& AllDeviations() {
  static const auto& all = *new std::array<NamedDeviation, 13>{{{"aBT", "EA0T", &Deviations::aBT},
                                                                {"dxBT", "EX0T", &Deviations::dxBT},
                                                                {"dzBT", "EZ0T", &Deviations::dzBT},
                                                                {"aXB", "EA0B", &Deviations::aXB},
                                                                {"bXB", "EB0B", &Deviations::bXB},
                                                                {"gXB", "EC0B", &Deviations::gXB},
                                                                {"gXY", "EC0X", &Deviations::gXY},
                                                                {"aYZ", "EA0Y", &Deviations::aYZ},
                                                                {"bYZ", "EB0Y", &Deviations::bYZ},
                                                                {"aCZ", "EA0C", &Deviations::aCZ},
                                                                {"bCZ", "EB0C", &Deviations::bCZ},
                                                                {"dxCZ", "EX0C", &Deviations::dxCZ},
                                                                {"dyCZ", "EY0C", &Deviations::dyCZ}}};
  return all;
}

inline machine::ErrorModel ModelOf(const machine::Machine& machine, const Deviations& deviations) {
  machine::ErrorModel model;
  for (const NamedDeviation& deviation : AllDeviations()) {
    model.terms.push_back(machine::ConstantTerm(machine, machine::ParseErrorSymbol(deviation.symbol).value(),
                                                deviations.*deviation.member));
  }
  return model;
}

// B and C at the machine's origin at home: the frame of the thesis' formulas.
inline machine::Machine YaoMachine() { return machine::testing::MultiTasking(); }

}  // namespace axiscal::known_answers

#endif  // AXISCAL_TESTS_KNOWN_ANSWERS_YAO_MACHINE_H_
