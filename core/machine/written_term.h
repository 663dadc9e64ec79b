// An error term in the words of files: what errors.json and reports say of it beside its amplitude.
#ifndef AXISCAL_CORE_MACHINE_WRITTEN_TERM_H_
#define AXISCAL_CORE_MACHINE_WRITTEN_TERM_H_

#include <optional>
#include <string>

#include "core/base/json_like.h"

namespace axiscal::machine {

struct WrittenTerm {
  std::string symbol, shape;
  std::optional<std::string> variable;   // an axis, or "approach" of a touch
  std::optional<double> at;              // node of a map, mm or deg
  std::optional<std::string> over;       // the map's second axis
  std::optional<double> over_at;         // mm or deg
  std::optional<double> order;           // of a harmonic of a rotary axis
  std::optional<int> lobes;              // "order" of a lobe
  std::optional<double> period_mm;       // of a harmonic of a linear axis
  std::optional<double> length_deg, length_mm, tau_s;
};

template <typename Io>
void Members(Io& io, base::Like<Io, WrittenTerm> term) {
  io.Required("symbol", term.symbol);
  io.Required("shape", term.shape);
  io.Member("variable", term.variable);
  io.Member("at", term.at);
  io.Member("over", term.over);
  io.Member("over_at", term.over_at);
  if (term.shape == "lobe") {
    io.Member("order", term.lobes);
  } else {
    io.Member("order", term.order);
  }
  io.Member("period_mm", term.period_mm);
  io.Member("length_deg", term.length_deg);
  io.Member("length_mm", term.length_mm);
  io.Member("tau_s", term.tau_s);
}

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_WRITTEN_TERM_H_
