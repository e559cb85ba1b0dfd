// SPDX-License-Identifier: Apache-2.0
/// Writes a model and its data as LIBSVM files.
#include <fmt/format.h>

#include <iterator>
#include <variant>

#include "analysis/model/model_export.hpp"

namespace gyrotherm::model {
namespace {

/// Appends " 1:v1 2:v2 …" and a line end; each value is exact.
void append_row(std::string& out, const Eigen::Ref<const Eigen::RowVectorXd>& row) {
  for (Eigen::Index j = 0; j < row.size(); ++j) fmt::format_to(std::back_inserter(out), " {}:{:.17g}", j + 1, row(j));
  out += '\n';
}

}  // namespace

Result<std::string> to_libsvm(const Model& model) {
  const auto* svr = std::get_if<methods::SvrModel>(&model.function);
  if (svr == nullptr)
    return failure(FaultKind::usage, "LIBSVM export", "needs an svr model, this one is " + model.method);
  const double sigma = svr->parameters.sigma;
  std::string out =
      fmt::format("svm_type epsilon_svr\nkernel_type rbf\ngamma {:.17g}\nnr_class 2\ntotal_sv {}\nrho {:.17g}\nSV\n",
                  1 / (2 * sigma * sigma), svr->beta.size(), -svr->b);
  for (Eigen::Index i = 0; i < svr->beta.size(); ++i) {
    fmt::format_to(std::back_inserter(out), "{:.17g}", svr->beta(i));
    append_row(out, svr->support_vectors.row(i));
  }
  return out;
}

Result<std::string> to_libsvm_data(const Model& model, const data::Clusters& clusters) {
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  const data::SampleMatrix scaled = apply(model.scaling, *inputs);
  std::string out;
  for (Eigen::Index k = 0; k < scaled.rows(); ++k) {
    if (!scaled.row(k).allFinite()) continue;
    const double target = (clusters.bias_deg_per_h(k) - model.target_mean_deg_per_h) / model.target_std_deg_per_h;
    fmt::format_to(std::back_inserter(out), "{:.17g}", target);
    append_row(out, scaled.row(k));
  }
  return out;
}

}  // namespace gyrotherm::model
