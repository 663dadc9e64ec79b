// The temperatures that sessions recorded, and what a body that takes them on late remembers of them: first-order lag
//   dF/dt = (T - F) / tau,   T linear between the moments, F = T at the first one.
// Exact for such T: with e = exp(-dt / tau)
//   F(k+1) = F(k) e + T(k+1) - T(k) e - (T(k+1) - T(k)) (tau / dt) (1 - e).
#ifndef AXISCAL_CORE_SHAPES_TEMPERATURES_H_
#define AXISCAL_CORE_SHAPES_TEMPERATURES_H_

#include <memory>
#include <string>
#include <vector>

namespace axiscal::shapes {

class Temperatures {
 public:
  struct Channel {
    std::string name;  // of its column: "temp_C", "T_spindle_C"
    std::vector<double> celsius;
  };
  struct Late {
    double celsius = 0.0;
    double per_s = 0.0;  // its derivative by tau
  };

  // `time_s` never runs back; each channel has a value per moment.
  Temperatures(std::vector<double> time_s, std::vector<Channel> channels);
  ~Temperatures();
  Temperatures(const Temperatures&) = delete;
  Temperatures& operator=(const Temperatures&) = delete;

  const std::vector<Channel>& channels() const { return channels_; }
  const std::vector<double>& time_s() const { return time_s_; }
  // Null where there is no such channel.
  const Channel* Find(const std::string& name) const;

  // F at a moment; tau 0: T itself. The whole history of a time constant is computed once and kept while it is among
  // the last ones that were asked for. For use by several threads.
  Late At(const Channel& channel, double tau_s, int moment) const;

 private:
  struct Memory;

  const std::vector<double> time_s_;
  const std::vector<Channel> channels_;
  const std::unique_ptr<Memory> memory_;
};

// Those of a channel with a time constant at all moments.
std::vector<Temperatures::Late> LateOf(const std::vector<double>& time_s, const std::vector<double>& celsius,
                                       double tau_s);

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_TEMPERATURES_H_
