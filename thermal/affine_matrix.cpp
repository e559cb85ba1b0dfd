#include "thermal/affine_matrix.hpp"

#include <cassert>

namespace gyrotherm {
namespace {

std::vector<int> places_in(const SparseMatrix& sum, const SparseMatrix& part) {
  std::vector<int> places(static_cast<std::size_t>(part.nonZeros()));
  for (Eigen::Index row = 0; row < part.rows(); ++row) {
    auto place = sum.outerIndexPtr()[row];
    for (auto i = part.outerIndexPtr()[row]; i < part.outerIndexPtr()[row + 1]; ++i) {
      while (place < sum.outerIndexPtr()[row + 1] && sum.innerIndexPtr()[place] < part.innerIndexPtr()[i]) ++place;
      assert(place < sum.outerIndexPtr()[row + 1] && sum.innerIndexPtr()[place] == part.innerIndexPtr()[i]);
      places[static_cast<std::size_t>(i)] = place;
    }
  }
  return places;
}

}  // namespace

AffineMatrix::AffineMatrix(const ThermalSystem& system) {
  assert(system.capacity.isCompressed() && system.conduction.isCompressed());
  sum_ = system.capacity + system.conduction;
  for (const auto& matrix : system.conduction_per) sum_ = (sum_ + matrix).eval();
  sum_.makeCompressed();
  parts_[0] = {&system.capacity, places_in(sum_, system.capacity)};
  parts_[1] = {&system.conduction, places_in(sum_, system.conduction)};
  for (std::size_t m = 0; m < kThermalCoefficients; ++m) {
    assert(system.conduction_per[m].isCompressed());
    parts_[2 + m] = {&system.conduction_per[m], places_in(sum_, system.conduction_per[m])};
  }
}

void AffineMatrix::add(const Part& part, double factor) {
  const double* numbers = part.matrix->valuePtr();
  double* sums = sum_.valuePtr();
  for (std::size_t i = 0; i < part.places.size(); ++i) sums[part.places[i]] += factor * numbers[i];
}

const SparseMatrix& AffineMatrix::sum(double capacity, double conduction, const ThermalCoefficients& c) {
  sum_.coeffs().setZero();
  if (capacity != 0) add(parts_[0], capacity);
  add(parts_[1], conduction);
  for (std::size_t m = 0; m < kThermalCoefficients; ++m) add(parts_[2 + m], conduction * c[m]);
  return sum_;
}

}  // namespace gyrotherm
