// One node of an error map over one or two axes: error = a h(q), or a h(q) g(r) over two. h is 1 at its node, falls
// linearly to 0 at the neighbouring nodes and keeps the end's value beyond the last. A map is the sum of its nodes, one
// term and one amplitude each, so that between nodes it is linear along each axis.
// A map whose mean over an axis belongs to another error (Ibaraki, eq 1: the map of C has zero mean over C at every A)
// ties its last node along that axis: h - h(last), so that its values sum to zero by construction.
#ifndef AXISCAL_CORE_SHAPES_TABULATED_H_
#define AXISCAL_CORE_SHAPES_TABULATED_H_

#include <cmath>
#include <limits>

#include "core/shapes/state.h"

namespace axiscal::shapes {

// Where a node stands along one axis and how far its neighbours are: mm or rad; infinite beyond the ends.
struct Node {
  double at = 0.0;
  double before = std::numeric_limits<double>::infinity();
  double after = std::numeric_limits<double>::infinity();
  double turn = 0.0;  // 2 pi where the nodes go once around a rotary axis, 0 where they end

  double Hat(double position) const {
    double distance = position - at;
    if (turn > 0.0) distance = std::remainder(distance, turn);
    const double neighbour = distance < 0.0 ? before : after;
    return std::isinf(neighbour) ? 1.0 : std::fmax(0.0, 1.0 - std::fabs(distance) / neighbour);
  }
  bool operator==(const Node&) const = default;
};

struct Tabulated {
  static constexpr char kName[] = "tabulated";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 0;

  int axis = 0;
  Node node;
  bool is_tied = false;
  Node tied_to;          // the last node along `axis`
  int second_axis = -1;  // a map over two axes
  Node second;

  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    const double position = state.axes[axis].position;
    double value = node.Hat(position);
    if (is_tied) value -= tied_to.Hat(position);
    if (second_axis >= 0) value *= second.Hat(state.axes[second_axis].position);
    basis[0] = T(value);
  }
  bool operator==(const Tabulated&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_TABULATED_H_
