// What came out of an identification.
#ifndef AXISCAL_CORE_IDENTIFY_RESULT_H_
#define AXISCAL_CORE_IDENTIFY_RESULT_H_

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/machine/error_covariance.h"
#include "core/machine/error_model.h"
#include "core/reports/warning.h"

namespace axiscal::identify {

// One fitted number: an amplitude of an error term, or its non-linear parameter.
struct Estimate {
  std::string name;     // EX0C, EXX:backlash, EBB:harmonic(45).cos
  std::string symbol;   // EX0C, EXX
  std::string unit;     // um, urad, um/m ... of `value` and `sigma` below times 1 / factor
  double factor = 1.0;  // mm or rad per unit
  // mm or rad (per the shape's reference). NaN where the data cannot tell: an error that is not identifiable has no
  // number.
  double value = std::numeric_limits<double>::quiet_NaN();
  double sigma = std::numeric_limits<double>::quiet_NaN();  // standard uncertainty, with that of held errors
  bool identifiable = false;
};

// A combination of errors that the data does determine although its parts cannot be separated: "EX0C + EX0B".
struct Combination {
  std::string name;
  std::string unit;
  double factor = 1.0;
  double value = 0.0, sigma = 0.0;
  Eigen::VectorXd of;  // value = of . values of all errors, in the order of Result::estimates
};

struct SetupOffset {
  std::string name;                 // ball_x ...
  double value = 0.0, sigma = 0.0;  // mm or rad; NaN of one that nobody placed (a free datum) and no reading tells
  bool is_angle = false;
};

// Which readings a number comes from: a session, and the set-up that it may share with others.
struct MeasuredIn {
  std::string session, setup;
};

struct SessionFit {
  std::string session;
  std::string setup_name;  // sessions with the same name share their offsets
  int readings = 0;        // numbers, not lines
  double rms_mm = 0.0, max_mm = 0.0;
  std::vector<SetupOffset> setup;
};

// What a gate found before anything was fitted (instruments/touch/touch_bind.h).
struct Gate {
  std::string name;  // "sphere", "repeat"
  double off_mm = 0.0, limit_mm = 0.0;
};

struct Outlier {
  std::string session;
  int row = 0;     // line of data, from 1
  int column = 0;  // which of its readings, from 0
  double residual_mm = 0.0;
  std::optional<Gate> gate;  // set aside by it, else for standing out of its series
};

struct FitStatistics {
  double rms_mm = 0.0, max_mm = 0.0;  // all readings, those set aside too
  double rms_without_outliers_mm = 0.0;
  double chi2_per_dof = 0.0;  // used readings, sigma as stated, or as judged where readings are correlated
  int readings = 0, used = 0, degrees_of_freedom = 0;
};

struct Result {
  machine::ErrorModel model;  // fitted; errors held as the gauge are zero
  std::vector<Estimate> estimates;
  Eigen::MatrixXd correlation;  // of the estimates; NaN rows where not identifiable
  // Of the model's numbers and of held errors, for errors.json: also of those that have no number above, with what the
  // fit held at zero taken for exact, since it is in the model at that value.
  machine::WrittenCovariance covariance;
  // What stated facts (expansions, certified values, thermometers) have in the uncertainties: by how much each fact
  // that is off by one standard uncertainty moves each estimate, mm or rad; NaN where it has no number.
  struct Stated {
    std::string of;
    Eigen::VectorXd moved;
  };
  std::vector<Stated> stated;
  std::vector<Estimate> held_errors;       // errors of an earlier identification, held at their values (held.h)
  Eigen::MatrixXd held_correlation;        // of them with the estimates and with each other: held x (estimates, held)
  std::vector<MeasuredIn> held_from;       // what they come from, as far as it is known
  std::vector<std::string> not_separable;  // directions that change no reading: "EX0B - EX0C"
  std::vector<Combination> determined;
  int rank = 0;
  double condition = 0.0;
  FitStatistics nominal;  // of Identify(): the nominal machine, no errors and no setup offsets
  FitStatistics fit;
  std::vector<SessionFit> sessions;
  std::vector<Outlier> outliers;
  std::vector<reports::WarningFacts> warnings;
  // value +- this many sigma is the 95 % interval: 1.96, or Student's t for the degrees of freedom of the fit where the
  // readings scatter by more than stated, so that the scale of all sigmas was estimated from them.
  double coverage_factor = 1.959964;
  int iterations = 0;
  double noise_scale =
      1.0;  // factor on every stated sigma; not 1 only where the model misses by so much that the misfit took its place
};

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_RESULT_H_
