// Scattered bad readings (chips, mis-touches, spikes): readings that stand out of their own series (Hampel identifier).
// A reading is compared with the running median of its neighbours, in robust standard deviations of all such
// differences, so that an effect which the model lacks is not taken for chips. Neighbours that stand out together on
// one side are such an effect and stay.
#ifndef AXISCAL_CORE_IDENTIFY_OUTLIERS_H_
#define AXISCAL_CORE_IDENTIFY_OUTLIERS_H_

#include <Eigen/Core>
#include <vector>

namespace axiscal::identify {

struct OutlierOptions {
  int half_window = 5;      // readings on either side that make the running median
  double threshold = 6.0;   // robust standard deviations; six are exceeded by 2 in 1e9 Gaussian readings
  int min_readings = 20;    // shorter series have no running median: their own median and a stricter threshold judge
  int fewest_readings = 8;  // still shorter ones cannot tell a bad reading from structure
  double short_threshold = 9.0;  // robust standard deviations
  int max_cluster = 2;           // more neighbours than this standing out on one side are structure
};

// Per reading of one series: true where it stands out alone. `sigma_floor_mm` bounds the robust scale from below
// (quantised series).
std::vector<bool> FindOutliers(const Eigen::VectorXd& series_mm, double sigma_floor_mm,
                               const OutlierOptions& options = {});

// Each value minus the median of its neighbours, `half_window` on either side, itself left out; at the ends the window
// is one-sided.
Eigen::VectorXd OffRunningMedian(const Eigen::VectorXd& series, int half_window);

// 1.4826 times the median of absolute values: the standard deviation of Gaussian deviations.
double RobustSigma(Eigen::VectorXd deviations);

// Median of `values` (destroyed). 0 for none.
double Median(std::vector<double>* values);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_OUTLIERS_H_
