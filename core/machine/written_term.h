// An error term in the words of files: what errors.json and reports say of it beside its amplitude.
#ifndef AXISCAL_CORE_MACHINE_WRITTEN_TERM_H_
#define AXISCAL_CORE_MACHINE_WRITTEN_TERM_H_

#include <optional>
#include <string>

#include "core/base/json_like.h"

namespace axiscal::machine {

struct WrittenTerm {
  std::string symbol, shape;
  std::optional<std::string> variable;  // an axis, or "approach" of a touch
  std::optional<double> at;             // node of a map, mm or deg
  std::optional<std::string> over;      // the map's second axis
  std::optional<double> over_at;        // mm or deg
  std::optional<double> order;          // of a harmonic of a rotary axis
  std::optional<int> lobes;             // "order" of a lobe
  std::optional<double> period_mm;      // of a harmonic of a linear axis
  std::optional<double> length_deg, length_mm, tau_s;
  std::optional<std::string> channel;  // of a late warmth
  // What the readings reached: of the variable of a curve, of `over` of a crossed one, of the temperature of a channel.
  std::optional<double> from_mm, to_mm, from_deg, to_deg, from_s, to_s, from_celsius, to_celsius;
  std::optional<double> over_from_mm, over_to_mm, over_from_deg, over_to_deg;
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
  io.Member("channel", term.channel);
  io.Member("from_mm", term.from_mm);
  io.Member("to_mm", term.to_mm);
  io.Member("from_deg", term.from_deg);
  io.Member("to_deg", term.to_deg);
  io.Member("from_s", term.from_s);
  io.Member("to_s", term.to_s);
  io.Member("from_celsius", term.from_celsius);
  io.Member("to_celsius", term.to_celsius);
  io.Member("over_from_mm", term.over_from_mm);
  io.Member("over_to_mm", term.over_to_mm);
  io.Member("over_from_deg", term.over_from_deg);
  io.Member("over_to_deg", term.over_to_deg);
}

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_WRITTEN_TERM_H_
