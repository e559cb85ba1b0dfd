// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/hex20.hpp"

#include <cassert>
#include <cmath>

namespace gyrotherm::thermal {

namespace {

std::vector<int> find_positions(const SparseMatrix& sum, const SparseMatrix& part) {
  std::vector<int> positions(static_cast<std::size_t>(part.nonZeros()));
  for (Eigen::Index row = 0; row < part.rows(); ++row) {
    auto entry = sum.outerIndexPtr()[row];
    for (auto i = part.outerIndexPtr()[row]; i < part.outerIndexPtr()[row + 1]; ++i) {
      while (entry < sum.outerIndexPtr()[row + 1] && sum.innerIndexPtr()[entry] < part.innerIndexPtr()[i]) ++entry;
      assert(entry < sum.outerIndexPtr()[row + 1] && sum.innerIndexPtr()[entry] == part.innerIndexPtr()[i]);
      positions[static_cast<std::size_t>(i)] = entry;
    }
  }
  return positions;
}

/// Value and slope of the factor of a node's shape function along one axis. `side` is −1, 0 or 1.
struct Factor {
  double value, slope;
};
Factor factor(int side, double at) {
  if (side == 0) return {1 - at * at, -2 * at};
  return {1 + side * at, static_cast<double>(side)};
}

Hex20Integrals integrate() {
  const std::array<double, 3> points{-std::sqrt(0.6), 0, std::sqrt(0.6)};
  constexpr std::array<double, 3> kWeights{5.0 / 9, 8.0 / 9, 5.0 / 9};
  Hex20Integrals sum;
  for (auto& m : sum.slopes) m.setZero();
  for (auto& m : sum.face_mass) m.setZero();
  for (auto& v : sum.face_load) v.setZero();
  sum.cross.setZero();
  sum.mass.setZero();
  sum.load.setZero();
  for (std::size_t p = 0; p < 3; ++p) {
    for (std::size_t q = 0; q < 3; ++q) {
      for (std::size_t r = 0; r < 3; ++r) {
        const double weight = kWeights[p] * kWeights[q] * kWeights[r];
        const auto shape = hex20_shape(points[p], points[q], points[r]);
        const auto slopes = hex20_slopes(points[p], points[q], points[r]);
        for (int d = 0; d < 3; ++d) sum.slopes[d] += weight * slopes.row(d).transpose() * slopes.row(d);
        sum.cross += weight * (slopes.row(0).transpose() * slopes.row(1) + slopes.row(1).transpose() * slopes.row(0));
        sum.mass += weight * shape * shape.transpose();
        sum.load += weight * shape;
      }
      for (int face = 0; face < 6; ++face) {
        std::array<double, 3> at{};
        at[face / 2] = face % 2 == 0 ? -1 : 1;
        at[(face / 2 + 1) % 3] = points[p];
        at[(face / 2 + 2) % 3] = points[q];
        const auto shape = hex20_shape(at[0], at[1], at[2]);
        const double weight = kWeights[p] * kWeights[q];
        sum.face_mass[face] += weight * shape * shape.transpose();
        sum.face_load[face] += weight * shape;
      }
    }
  }
  // Make the matrices exactly symmetric, to the last bit.
  for (auto& m : sum.slopes) m = (0.5 * (m + m.transpose())).eval();
  for (auto& m : sum.face_mass) m = (0.5 * (m + m.transpose())).eval();
  sum.cross = (0.5 * (sum.cross + sum.cross.transpose())).eval();
  sum.mass = (0.5 * (sum.mass + sum.mass.transpose())).eval();
  return sum;
}

}  // namespace

AffineMatrix::AffineMatrix(const ThermalSystem& system) {
  assert(system.capacity.isCompressed() && system.conduction.isCompressed());
  sum_ = system.capacity + system.conduction;
  for (const auto& matrix : system.conduction_per) sum_ = (sum_ + matrix).eval();
  sum_.makeCompressed();
  parts_[0] = {&system.capacity, find_positions(sum_, system.capacity)};
  parts_[1] = {&system.conduction, find_positions(sum_, system.conduction)};
  for (std::size_t m = 0; m < kThermalCoefficients; ++m) {
    assert(system.conduction_per[m].isCompressed());
    parts_[2 + m] = {&system.conduction_per[m], find_positions(sum_, system.conduction_per[m])};
  }
}

void AffineMatrix::add(const Part& part, double factor) {
  const double* numbers = part.matrix->valuePtr();
  double* sums = sum_.valuePtr();
  for (std::size_t i = 0; i < part.positions.size(); ++i) sums[part.positions[i]] += factor * numbers[i];
}

const SparseMatrix& AffineMatrix::sum(double capacity, double conduction, const ThermalCoefficients& c) {
  sum_.coeffs().setZero();
  if (capacity != 0) add(parts_[0], capacity);
  add(parts_[1], conduction);
  for (std::size_t m = 0; m < kThermalCoefficients; ++m) add(parts_[2 + m], conduction * c[m]);
  return sum_;
}

Hex20Vector hex20_shape(double xi, double eta, double zeta) {
  Hex20Vector shape;
  for (int n = 0; n < kHex20; ++n) {
    const int a = kHex20Positions[n][0] - 1;
    const int b = kHex20Positions[n][1] - 1;
    const int c = kHex20Positions[n][2] - 1;
    const double product = factor(a, xi).value * factor(b, eta).value * factor(c, zeta).value;
    shape[n] = n < 8 ? product * (a * xi + b * eta + c * zeta - 2) / 8 : product / 4;
  }
  return shape;
}

Eigen::Matrix<double, 3, kHex20> hex20_slopes(double xi, double eta, double zeta) {
  Eigen::Matrix<double, 3, kHex20> slopes;
  for (int n = 0; n < kHex20; ++n) {
    const int a = kHex20Positions[n][0] - 1;
    const int b = kHex20Positions[n][1] - 1;
    const int c = kHex20Positions[n][2] - 1;
    const auto x = factor(a, xi);
    const auto y = factor(b, eta);
    const auto z = factor(c, zeta);
    const double scale = n < 8 ? (a * xi + b * eta + c * zeta - 2) / 8 : 0.25;
    slopes(0, n) = x.slope * y.value * z.value * scale;
    slopes(1, n) = x.value * y.slope * z.value * scale;
    slopes(2, n) = x.value * y.value * z.slope * scale;
    if (n >= 8) continue;
    const double product = x.value * y.value * z.value / 8;
    slopes(0, n) += a * product;
    slopes(1, n) += b * product;
    slopes(2, n) += c * product;
  }
  return slopes;
}

const Hex20Integrals& hex20_integrals() {
  static const Hex20Integrals integrals = integrate();
  return integrals;
}

}  // namespace gyrotherm::thermal
