#include "analysis/methods/orthogonal_least_squares.hpp"

#include <algorithm>
#include <cassert>

namespace gyrotherm {

OrthogonalPath orthogonal_least_squares(const Eigen::Ref<const Eigen::MatrixXd>& candidates,
                                        const Eigen::Ref<const Eigen::VectorXd>& y, double tolerance,
                                        Eigen::Index most) {
  assert(candidates.rows() == y.size() && candidates.cols() > 0);
  constexpr double kOwn = 1e-12;  // of a candidate's squared norm; what is left below is rounding
  OrthogonalPath path;
  path.means = candidates.colwise().mean();
  path.target_mean = y.mean();
  Eigen::MatrixXd left = candidates.rowwise() - path.means;  // orthogonal to all that were taken
  const Eigen::VectorXd target = y.array() - path.target_mean;
  const Eigen::ArrayXd whole = left.colwise().squaredNorm().transpose();
  const double spread = target.squaredNorm();
  most = std::min({most, candidates.cols(), candidates.rows() - 1});
  path.triangle = Eigen::MatrixXd::Identity(most, most);
  path.orthogonal.setZero(most);
  Eigen::MatrixXd shares = Eigen::MatrixXd::Zero(most, candidates.cols());  // of each taken direction in each candidate
  Eigen::ArrayXd open = Eigen::ArrayXd::Ones(candidates.cols());
  double unexplained = 1;
  while (static_cast<Eigen::Index>(path.order.size()) < most && spread > 0 && unexplained >= tolerance) {
    const Eigen::ArrayXd squares = left.colwise().squaredNorm().transpose();
    open = (squares > kOwn * whole).select(open, 0.0);
    const Eigen::ArrayXd products = left.transpose() * target;
    const Eigen::ArrayXd ratios = (open > 0).select(products.square() / (squares * spread), 0.0);
    Eigen::Index best = 0;
    if (!(ratios.maxCoeff(&best) > 0)) break;
    const auto k = static_cast<Eigen::Index>(path.order.size());
    const Eigen::VectorXd direction = left.col(best);
    path.triangle.col(k).head(k) = shares.col(best).head(k);
    path.orthogonal(k) = products(best) / squares(best);
    path.order.push_back(best);
    path.ratios.push_back(ratios(best));
    unexplained -= ratios(best);
    shares.row(k) = (direction.transpose() * left) / squares(best);
    left -= direction * shares.row(k);
    open(best) = 0;
  }
  return path;
}

Eigen::Index taken_at(const OrthogonalPath& path, double tolerance) {
  double unexplained = 1;
  Eigen::Index count = 0;
  for (const double ratio : path.ratios) {
    if (unexplained < tolerance) break;
    unexplained -= ratio;
    ++count;
  }
  return count;
}

Eigen::VectorXd weights_of(const OrthogonalPath& path, Eigen::Index count) {
  assert(count <= static_cast<Eigen::Index>(path.order.size()));
  return path.triangle.topLeftCorner(count, count)
      .triangularView<Eigen::UnitUpper>()
      .solve(path.orthogonal.head(count));
}

double offset_of(const OrthogonalPath& path, const Eigen::VectorXd& weights) {
  double offset = path.target_mean;
  for (Eigen::Index k = 0; k < weights.size(); ++k) offset -= path.means(path.order[k]) * weights(k);
  return offset;
}

}  // namespace gyrotherm
