#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>

#include "analysis/data/features.hpp"
#include "analysis/model/selection.hpp"

namespace gyrotherm {
namespace {

/// Centred, each column of length 1; one that does not vary is 0.
Eigen::MatrixXd unit_columns(const SampleMatrix& values) {
  constexpr double kRounding = 1e-12;
  Eigen::MatrixXd unit = values.rowwise() - values.colwise().mean();
  for (Eigen::Index j = 0; j < unit.cols(); ++j) {
    const double length = unit.col(j).norm();
    if (length > kRounding * values.col(j).norm())
      unit.col(j) /= length;
    else
      unit.col(j).setZero();
  }
  return unit;
}

/// Less what the columns of `fixed` say of them. Twice, so that what is left is orthogonal to rounding.
void project_out(const Eigen::MatrixXd& fixed, Eigen::MatrixXd& columns) {
  if (fixed.cols() == 0) return;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(fixed);
  const Eigen::MatrixXd basis = qr.householderQ() * Eigen::MatrixXd::Identity(fixed.rows(), qr.rank());
  for (int pass = 0; pass < 2; ++pass) columns -= basis * (basis.transpose() * columns);
}

}  // namespace

Result<Selection> select_independent(const std::vector<Term>& fixed, const std::vector<Term>& candidates,
                                     const Clusters& training, double tolerance) {
  const auto taken = evaluate(fixed, training);
  if (!taken) return failure(taken.error());
  const auto offered = evaluate(candidates, training);
  if (!offered) return failure(offered.error());
  Eigen::MatrixXd columns = unit_columns(*offered);
  project_out(unit_columns(*taken), columns);

  // Pivoting takes the column with the most left of its own each time; the diagonal of R is how much that was.
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  const Eigen::Index most = std::min(columns.rows(), columns.cols());
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < most && std::abs(qr.matrixR()(k, k)) > tolerance; ++k)
    kept.push_back(qr.colsPermutation().indices()(k));
  std::ranges::sort(kept);

  Selection selection;
  selection.threshold = 0;
  std::vector<std::string> names;
  for (const Eigen::Index column : kept) {
    selection.terms.push_back(candidates[column]);
    names.push_back(text(candidates[column]));
  }
  selection.rank = rank_of(selection.terms);
  selection.statement = fmt::format("{} of {} inputs do not depend on the others to {:g} of their STD: {} (rank {})",
                                    kept.size(), candidates.size(), tolerance,
                                    kept.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")), selection.rank);
  return selection;
}

}  // namespace gyrotherm
