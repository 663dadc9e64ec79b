// What the readings of an eccentricity session stand for: each is a linear functional of a ball bar's whole trace.
#ifndef AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_RUN_H_
#define AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_RUN_H_

#include <Eigen/Core>
#include <vector>

namespace axiscal::instruments {
struct MeasuringRun;
}

namespace axiscal::eccentricity {

// One component of one run's eccentricity: the sum of weight[n] * dL at reading n of the trace.
struct Reading {
  int trace = 0;
  Eigen::VectorXd weight;
  // Where it stands in the session: line of data, from 0, and component 0 1 2 for ex ey ez.
  int row = 0, component = 0;
};

struct Eccentricities {
  std::vector<instruments::MeasuringRun> traces;  // ball-bar runs, one per path and sense
  std::vector<Reading> readings;
};

}  // namespace axiscal::eccentricity

#endif  // AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_RUN_H_
