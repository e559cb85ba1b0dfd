#include "plot/decimate.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace gyrotherm {
namespace {

/// The extremes of one column, by index.
struct Extremes {
  std::size_t least{};
  std::size_t greatest{};
};

class Thinner {
 public:
  Thinner(const std::vector<double>& x, const std::vector<double>& y) : x_(x), y_(y) {}

  void take(std::size_t k) {
    if (!open_) extremes_ = {k, k};
    open_ = true;
    if (y_[k] < y_[extremes_.least]) extremes_.least = k;
    if (y_[k] > y_[extremes_.greatest]) extremes_.greatest = k;
  }
  void close_column() {
    if (!open_) return;
    const auto [first, second] = std::minmax(extremes_.least, extremes_.greatest);
    keep(first);
    if (second != first) keep(second);
    open_ = false;
  }
  void break_line(double x) {
    close_column();
    if (kept_.y.empty() || std::isnan(kept_.y.back())) return;
    kept_.x.push_back(x);
    kept_.y.push_back(std::numeric_limits<double>::quiet_NaN());
  }
  [[nodiscard]] Points finish() && {
    close_column();
    return std::move(kept_);
  }

 private:
  void keep(std::size_t k) {
    kept_.x.push_back(x_[k]);
    kept_.y.push_back(y_[k]);
  }

  const std::vector<double>& x_;
  const std::vector<double>& y_;
  Extremes extremes_;
  bool open_ = false;
  Points kept_;
};

}  // namespace

Points decimate(const std::vector<double>& x, const std::vector<double>& y, std::size_t columns) {
  assert(x.size() == y.size() && columns > 0);
  if (x.size() <= 2 * columns) return {x, y};
  const double width = (x.back() - x.front()) / static_cast<double>(columns);
  Thinner thinner(x, y);
  auto column = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!std::isfinite(y[k])) {
      thinner.break_line(x[k]);
      continue;
    }
    const double own = std::floor((x[k] - x.front()) / width);
    if (own != column) thinner.close_column();
    column = own;
    thinner.take(k);
  }
  return std::move(thinner).finish();
}

}  // namespace gyrotherm
