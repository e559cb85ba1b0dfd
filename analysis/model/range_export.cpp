// SPDX-License-Identifier: Apache-2.0
/// Writes the bounded point of inputs outside the trained range as C (Outside::continued).
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>
#include <variant>
#include <vector>

#include "analysis/model/export_parts.hpp"

namespace gyrotherm::model {
namespace {

constexpr const char* kBounding = R"(
/* Moves all inputs towards their means by the same fraction until each is in its range; recomputes products.
   factors: indices of the inputs that a product multiplies; -1: no factor. */
static void bound(double x[]) {
@factors@  double share = 1.0;
  for (int k = 0; k < INPUTS; ++k) {
    if (@is_bounding@(x[k] < low[k] || x[k] > high[k])) {
      const double part = ((x[k] > high[k] ? high[k] : low[k]) - mean[k]) / (x[k] - mean[k]);
      if (part < share) share = part > 0.0 ? part : 0.0;
    }
  }
  for (int k = 0; k < INPUTS; ++k) x[k] = mean[k] + share * (x[k] - mean[k]);
@remake@}
)";

constexpr const char* kProductLoop = R"(  for (int k = 0; k < INPUTS; ++k) {
    if (factors[k][0] < 0) continue;
    x[k] = 1.0;
    for (int i = 0; i < 3 && factors[k][i] >= 0; ++i) x[k] *= x[factors[k][i]];
  }
)";

}  // namespace

std::string bounding_in_c(const Model& model) {
  if (std::holds_alternative<methods::LinearModel>(model.function)) return {};
  const std::vector<RecomputedProduct> recomputed = recomputed_products(model.terms);
  if (recomputed.empty()) return c_fill(kBounding, {{"factors", ""}, {"is_bounding", ""}, {"remake", ""}});
  std::vector<std::vector<Eigen::Index>> factors(model.terms.size());
  for (const RecomputedProduct& product : recomputed) factors[static_cast<std::size_t>(product.term)] = product.factors;
  std::string rows;
  for (std::vector<Eigen::Index>& row : factors) {
    row.resize(data::kMostFactors, -1);
    rows += fmt::format("{}{{{}}}", rows.empty() ? "" : ", ", fmt::join(row, ", "));
  }
  return c_fill(
      kBounding,
      {{"factors", fmt::format("  static const int factors[INPUTS][{}] = {{{}}};\n", data::kMostFactors, rows)},
       {"is_bounding", "factors[k][0] < 0 && "},
       {"remake", kProductLoop}});
}

}  // namespace gyrotherm::model
