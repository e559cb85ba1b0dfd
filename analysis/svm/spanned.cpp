// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/spanned.hpp"

#include <Eigen/QR>
#include <cmath>

namespace gyrotherm::svm {
namespace {

constexpr double kFlat = 1e-13;

using Qr = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;

// Returns whether the first few samples already differ in all directions, as samples of independent inputs mostly do.
bool few_differ_in_all(const Eigen::Ref<const Eigen::MatrixXd>& centred) {
  const Eigen::Index inputs = centred.cols(), few = 4 * inputs;
  if (centred.rows() <= few || inputs == 0) return false;
  const Qr of_few(centred.topRows(few));
  return std::abs(of_few.matrixR()(inputs - 1, inputs - 1)) > kFlat * centred.norm();
}

}  // namespace

// Factors long columns first: the rows of R span the same space as the samples, and there are only as many as inputs.
Eigen::MatrixXd directions_of(const Eigen::Ref<const Eigen::MatrixXd>& centred) {
  const Eigen::Index inputs = centred.cols();
  if (few_differ_in_all(centred)) return Eigen::MatrixXd::Identity(inputs, inputs);
  Qr of_samples;
  of_samples.setThreshold(kFlat);
  of_samples.compute(centred);
  const Eigen::Index rank = of_samples.rank();
  Eigen::MatrixXd basis = Eigen::MatrixXd::Identity(inputs, rank);
  if (rank == inputs) return basis;
  const Eigen::MatrixXd rows = of_samples.matrixR().topRows(rank).triangularView<Eigen::Upper>();
  const Eigen::HouseholderQR<Eigen::MatrixXd> of_rows((rows * of_samples.colsPermutation().transpose()).transpose());
  basis.applyOnTheLeft(of_rows.householderQ());
  return basis;
}

Eigen::MatrixXd spanned(const Eigen::Ref<const SampleMatrix>& x) {
  Eigen::MatrixXd places = x;
  if (x.rows() == 0) return places;
  const Eigen::RowVectorXd mean = places.colwise().mean();
  const Eigen::MatrixXd centred = places.rowwise() - mean;
  const Eigen::MatrixXd basis = directions_of(centred);
  if (basis.cols() < x.cols()) places = centred * basis;
  return places;
}

}  // namespace gyrotherm::svm
