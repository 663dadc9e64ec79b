// The information of a planned session about any error: the sensitivities of its readings at the fitted machine,
// evaluated once for all classes of effects for which the session is judged.
#ifndef AXISCAL_CORE_LOOP_TEST_ROWS_H_
#define AXISCAL_CORE_LOOP_TEST_ROWS_H_

#include <Eigen/Core>
#include <vector>

#include "core/loop/separation.h"

namespace axiscal::loop {

class TestRows {
 public:
  // `problem`: one run with a setup of its own whose readings are white, not taken along a path. `fitted`: the errors
  // that act.
  TestRows(identify::Problem problem, const machine::ErrorModel& fitted);

  // About ListParameters(model, true). `model`: the fitted terms, then others whose amplitudes are too small to matter.
  Information InformationOf(const machine::ErrorModel& model) const;

 private:
  friend class TestRowSink;

  // Whitened, per parameter.
  Eigen::MatrixXd ColumnsOf(const machine::ErrorModel& others) const;

  identify::Problem problem_;
  size_t fitted_terms_;
  std::vector<int> reading_;     // per row
  Eigen::MatrixXd sensitivity_;  // rows x 6 joints, whitened
  Eigen::MatrixXd fitted_;       // rows x (setup, parameters of the fitted model), whitened
  Eigen::MatrixXd fitted_gram_;
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_TEST_ROWS_H_
