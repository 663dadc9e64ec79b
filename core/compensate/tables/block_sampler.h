// The functions of one block of a table over one axis: sampled, nodes placed within the format's limits, values fitted.
#ifndef AXISCAL_CORE_COMPENSATE_TABLES_BLOCK_SAMPLER_H_
#define AXISCAL_CORE_COMPENSATE_TABLES_BLOCK_SAMPLER_H_

#include <functional>
#include <vector>

#include "core/compensate/nodes.h"
#include "core/compensate/tables/plan.h"

namespace axiscal::tables {

// All columns at a position and sense, mm or rad.
using Evaluator = std::function<absl::Status(double position, double sense, std::vector<double>* values)>;

struct Sampler {
  const Plan& plan;
  int argument = 0;
  std::vector<double> tolerance;  // per column, mm or rad
  bool by_sense = false;
  Evaluator evaluate;
  bool is_fitted = true;  // the table's values are fitted to the samples; false: they are those at the nodes

  // The number of samples that is enough to show every period and bend.
  size_t sample_count() const;
  // Functions: the columns, forward; then, if by sense, the columns, reverse. In units of the tolerance.
  absl::StatusOr<compensate::Curve> Sample(const std::vector<double>& positions) const;
  // Positions of the controller's resolution between `from` and `to`, both included.
  std::vector<double> Even(double from, double to, size_t count, double step) const;
};

// As few nodes as keep the tolerance, or as many as the format holds.
absl::StatusOr<std::vector<double>> ChooseNodes(const Sampler& sampler);
// The block with a column per target, not rounded yet.
absl::StatusOr<compensate::TableBlock> SampleBlock(const Sampler& sampler, const std::vector<int>& targets);

}  // namespace axiscal::tables

#endif  // AXISCAL_CORE_COMPENSATE_TABLES_BLOCK_SAMPLER_H_
