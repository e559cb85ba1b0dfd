#include "analysis/svm/smo_direction.hpp"

#include <algorithm>
#include <cmath>

#include "analysis/svm/lanes.hpp"

namespace gyrotherm {
namespace {

// Whether a point that moves `units` of its part passes an end.
GYROTHERM_CLONES
bool passes(const double* part, const double* beta, const double* low, const double* high, double units) {
  int passing = 0;
  for (int p = 0; p < SmoDirection::kPlaces; ++p) {
    const double there = beta[p] + units * part[p];
    passing += (there > high[p]) + (there < low[p]);
  }
  return passing > 0;
}

}  // namespace

void SmoDirection::clear() {
  part_.fill(0);
  beta_.fill(0);
  low_.fill(0);
  high_.fill(0);
  count_ = 0;
  steps_ = 0;
}

int SmoDirection::place_of(const Point& point) {
  for (int p = 0; p < count_; ++p) {
    if (index_[p] == point.index) return p;
  }
  index_[count_] = point.index;
  beta_[count_] = point.beta;
  low_[count_] = point.low;
  high_[count_] = point.high;
  return count_++;
}

void SmoDirection::start(const Point& i, const Point& j) {
  clear();
  part_[place_of(i)] = 1;
  part_[place_of(j)] = -1;
}

void SmoDirection::turn(const Point& i, const Point& j, double kept) {
  for (double& part : part_) part *= kept;
  part_[place_of(i)] += 1;
  part_[place_of(j)] -= 1;
  ++steps_;
}

SmoDirection::Length SmoDirection::reach(double units) const {
  Length length{units, -1};
  if (!passes(part_.data(), beta_.data(), low_.data(), high_.data(), units)) return length;
  for (int p = 0; p < count_; ++p) {
    const double room = (part_[p] > 0 ? high_[p] : low_[p]) - beta_[p];
    if (std::abs(room) < length.units * std::abs(part_[p])) length = {room / part_[p], p};
  }
  return length;
}

void SmoDirection::move(const Length& length) {
  for (int p = 0; p < count_; ++p) {
    beta_[p] = std::clamp(beta_[p] + length.units * part_[p], low_[p], high_[p]);
  }
  if (const int p = length.stopped_by; p >= 0) beta_[p] = part_[p] > 0 ? high_[p] : low_[p];
}

}  // namespace gyrotherm
