/// The direction in which the last steps of sequential minimal optimisation went: the few points that moved, and how
/// far each may go on.
#pragma once

#include <array>

namespace gyrotherm {

/// Points i and j of a pair: β_i rises, β_j falls.
struct SmoPair {
  int i{};
  int j{};
  double slack{};      ///< decrease of the dual per unit, at first
  double curvature{};  ///< by which that falls, per unit
};

/// d, as a sum of pairs' directions e_i − e_j. Each point that is part of it stays on its side of zero and in its
/// bounds: there the dual is quadratic.
class SmoDirection {
 public:
  static constexpr int kMostSteps = 5;
  static constexpr int kPlaces = 16;  ///< at least two for each step and the first
  static_assert(2 * (kMostSteps + 1) <= kPlaces);

  struct Point {
    int index;
    double beta;
    double low;  ///< β may go from low to high
    double high;
  };
  struct Length {
    double units;
    int stopped_by;  ///< the place of the point that meets an end, or −1
  };

  void clear();
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] bool full() const { return steps_ >= kMostSteps; }
  /// e_i − e_j alone.
  void start(const Point& i, const Point& j);
  /// d becomes e_i − e_j + kept d.
  void turn(const Point& i, const Point& j, double kept);
  /// Along d, at most `units`.
  [[nodiscard]] Length reach(double units) const;
  /// Moves the points.
  void move(const Length& length);

  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] int index(int place) const { return index_[place]; }
  [[nodiscard]] double beta(int place) const { return beta_[place]; }

 private:
  [[nodiscard]] int place_of(const Point& point);

  int count_ = 0;
  int steps_ = 0;
  std::array<int, kPlaces> index_{};
  // Beyond count_: zeros.
  std::array<double, kPlaces> part_{};
  std::array<double, kPlaces> beta_{};
  std::array<double, kPlaces> low_{};
  std::array<double, kPlaces> high_{};
};

}  // namespace gyrotherm
