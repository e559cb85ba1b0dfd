/// Thins a long series to what a figure can show.
#pragma once

#include <cstddef>
#include <vector>

namespace gyrotherm {

struct Points {
  std::vector<double> x;
  std::vector<double> y;
};

/// Cuts the range of x into `columns` and keeps the least and the greatest y of each, in their order, so that no spike
/// is lost. A NaN of y (a break in the line) is kept, once per run of them. Series of at most two points per column are
/// returned as they are. `x` must not fall; `x` and `y` have the same length.
[[nodiscard]] Points decimate(const std::vector<double>& x, const std::vector<double>& y, std::size_t columns);

}  // namespace gyrotherm
