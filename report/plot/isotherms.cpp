// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "report/plot/thermal_image.hpp"

namespace gyrotherm::plot {
namespace {

/// Number of a grid edge: even for the edge from a sample to its right neighbour, odd for the one to the sample below.
using Edge = std::size_t;

/// The line segments of one level. Each segment connects two edges, and at most two segments meet at an edge.
class Pieces {
 public:
  Pieces(const SampledField& field, double level) : field_(field), level_(level) {
    for (std::size_t row = 0; row + 1 < field.rows; ++row) {
      for (std::size_t column = 0; column + 1 < field.columns; ++column) cross_cell(row, column);
    }
  }

  /// Removes and returns one line; nothing if none is left. Open lines come first and start at one of their ends.
  [[nodiscard]] std::optional<Isotherm> take() {
    if (neighbours_.empty()) return std::nullopt;
    auto start = neighbours_.begin();
    for (auto candidate = start; candidate != neighbours_.end(); ++candidate) {
      if (candidate->second.size() == 1) {
        start = candidate;
        break;
      }
    }
    Isotherm line{point_on(start->first)};
    for (auto next = step_from(start->first); next; next = step_from(*next)) line.push_back(point_on(*next));
    return line;
  }

 private:
  [[nodiscard]] Edge edge_right(std::size_t row, std::size_t column) const {
    return 2 * (row * field_.columns + column);
  }
  [[nodiscard]] Edge edge_below(std::size_t row, std::size_t column) const { return edge_right(row, column) + 1; }

  [[nodiscard]] FieldPoint point_on(Edge edge) const {
    const std::size_t row = edge / 2 / field_.columns, column = edge / 2 % field_.columns;
    const bool downwards = edge % 2 == 1;
    const double from = field_.at(row, column),
                 to = downwards ? field_.at(row + 1, column) : field_.at(row, column + 1);
    const double part = (level_ - from) / (to - from);
    return {static_cast<double>(column) + (downwards ? 0 : part), static_cast<double>(row) + (downwards ? part : 0)};
  }

  void join(Edge a, Edge b) {
    neighbours_[a].push_back(b);
    neighbours_[b].push_back(a);
  }

  void cross_cell(std::size_t row, std::size_t column) {
    const std::array corners{field_.at(row, column), field_.at(row, column + 1), field_.at(row + 1, column + 1),
                             field_.at(row + 1, column)};
    double sum = 0;
    unsigned above = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (std::isnan(corners[k])) return;
      sum += corners[k];
      above |= (corners[k] >= level_ ? 1U : 0U) << k;
    }
    const Edge top = edge_right(row, column), bottom = edge_right(row + 1, column);
    const Edge left = edge_below(row, column), right = edge_below(row, column + 1);
    const bool middle_above = sum / 4 >= level_;
    switch (above) {
      case 0:
      case 15: return;
      case 1:
      case 14: return join(left, top);
      case 2:
      case 13: return join(top, right);
      case 4:
      case 11: return join(right, bottom);
      case 8:
      case 7: return join(bottom, left);
      case 3:
      case 12: return join(left, right);
      case 6:
      case 9: return join(top, bottom);
      default: break;
    }
    const bool cut_top_left = (above == 5) != middle_above;
    join(left, cut_top_left ? top : bottom);
    join(right, cut_top_left ? bottom : top);
  }

  /// Removes the segment that continues from `edge` and returns its other edge.
  std::optional<Edge> step_from(Edge edge) {
    const auto here = neighbours_.find(edge);
    if (here == neighbours_.end()) return std::nullopt;
    const Edge next = here->second.back();
    here->second.pop_back();
    if (here->second.empty()) neighbours_.erase(here);
    const auto there = neighbours_.find(next);
    std::erase(there->second, edge);
    if (there->second.empty()) neighbours_.erase(there);
    return next;
  }

  const SampledField& field_;
  double level_;
  std::map<Edge, std::vector<Edge>> neighbours_;
};

}  // namespace

std::vector<Isotherm> isotherms(const SampledField& field, double level) {
  Pieces pieces(field, level);
  std::vector<Isotherm> lines;
  while (auto line = pieces.take()) lines.push_back(std::move(*line));
  return lines;
}

}  // namespace gyrotherm::plot
