// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/spanned.hpp"

#include <Eigen/QR>
#include <cmath>

namespace gyrotherm::svm {
namespace {

constexpr double kFlatExtent = 1e-13;

using Qr = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;

// Returns whether the first few samples already differ in all directions, as is usual for independent inputs.
bool do_first_samples_span_all(const Eigen::Ref<const Eigen::MatrixXd>& centred) {
  const Eigen::Index inputs = centred.cols(), few = 4 * inputs;
  if (centred.rows() <= few || inputs == 0) return false;
  const Qr few_qr(centred.topRows(few));
  return std::abs(few_qr.matrixR()(inputs - 1, inputs - 1)) > kFlatExtent * centred.norm();
}

}  // namespace

// Factors the samples first: the rows of R span the same space as the samples and are much fewer.
Eigen::MatrixXd spanning_directions(const Eigen::Ref<const Eigen::MatrixXd>& centred) {
  const Eigen::Index inputs = centred.cols();
  if (do_first_samples_span_all(centred)) return Eigen::MatrixXd::Identity(inputs, inputs);
  Qr sample_qr;
  sample_qr.setThreshold(kFlatExtent);
  sample_qr.compute(centred);
  const Eigen::Index rank = sample_qr.rank();
  Eigen::MatrixXd basis = Eigen::MatrixXd::Identity(inputs, rank);
  if (rank == inputs) return basis;
  const Eigen::MatrixXd rows = sample_qr.matrixR().topRows(rank).triangularView<Eigen::Upper>();
  const Eigen::HouseholderQR<Eigen::MatrixXd> row_qr((rows * sample_qr.colsPermutation().transpose()).transpose());
  basis.applyOnTheLeft(row_qr.householderQ());
  return basis;
}

Eigen::MatrixXd project_to_span(const Eigen::Ref<const SampleMatrix>& x) {
  Eigen::MatrixXd coordinates = x;
  if (x.rows() == 0) return coordinates;
  const Eigen::RowVectorXd mean = coordinates.colwise().mean();
  const Eigen::MatrixXd centred = coordinates.rowwise() - mean;
  const Eigen::MatrixXd basis = spanning_directions(centred);
  if (basis.cols() < x.cols()) coordinates = centred * basis;
  return coordinates;
}

}  // namespace gyrotherm::svm
