/// The sum of a ThermalSystem's matrices for any coefficients, without looking for places twice.
#pragma once

#include <array>
#include <vector>

#include "thermal/reduced/thermal_system.hpp"

namespace gyrotherm {

class AffineMatrix final {
 public:
  /// `system`, whose matrices must be compressed with sorted columns, must outlive this.
  explicit AffineMatrix(const ThermalSystem& system);

  /// capacity·C + conduction·(K₀ + Σ_m c_m K_m); the same object each time, valid until the next call.
  const SparseMatrix& sum(double capacity, double conduction, const ThermalCoefficients& c);

 private:
  struct Part {
    const SparseMatrix* matrix;
    std::vector<int> places;  ///< of its numbers among the sum's
  };
  void add(const Part& part, double factor);

  SparseMatrix sum_;
  std::array<Part, 2 + kThermalCoefficients> parts_;  ///< C, K₀, K_m
};

}  // namespace gyrotherm
