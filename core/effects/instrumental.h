// Columns of instruments at fault (core/instruments/distortion.h). An effect is one instrument's, in all its sessions
// with the same amplitudes; fits give each session its own.
#ifndef AXISCAL_CORE_EFFECTS_INSTRUMENTAL_H_
#define AXISCAL_CORE_EFFECTS_INSTRUMENTAL_H_

#include <memory>
#include <vector>

#include "core/effects/linearised.h"
#include "core/objective/source.h"

namespace axiscal::effects {

// Families of the objective, one for each instruments::Distortion::Kind from this on.
inline constexpr int kInstrumentFamily = 110;

// All that could be wrong with the instruments of these sessions.
std::vector<instruments::Distortion> DistortionsOf(const std::vector<instruments::MeasuringRun>& runs);

// The same fault, whatever its time constant and variance.
bool IsSameFault(const instruments::Distortion& a, const instruments::Distortion& b);

class Instrumental : public objective::Source {
 public:
  struct Item {
    instruments::Distortion distortion;
    int kin = -1;  // of those with a time constant
  };
  // `linearised` must outlive it.
  Instrumental(const Linearised& linearised, std::vector<Item> items);

  Eigen::MatrixXd Columns(int group) const override;
  std::unique_ptr<objective::Source> Moved(int group, double place) const override;
  void AddProducts(int begin, const Eigen::MatrixXd& u, Eigen::Ref<Eigen::MatrixXd> products) const override;

 private:
  // Columns of the items first .. last in the rows begin .. begin + out->rows().
  void Fill(size_t first, size_t last, int begin, Eigen::Ref<Eigen::MatrixXd> out) const;

  const Linearised& linearised_;
  const std::vector<Item> items_;
};

}  // namespace axiscal::effects

#endif  // AXISCAL_CORE_EFFECTS_INSTRUMENTAL_H_
