// SPDX-License-Identifier: Apache-2.0
/// Writes the uncertainty of an exported model's means as C.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "analysis/model/budget.hpp"
#include "analysis/model/export_parts.hpp"

namespace gyrotherm::model {
namespace {

constexpr const char* kUncertaintyDeclarations =
    R"(/* The expanded uncertainty U, in degrees per hour, of a mean of compensated bias over @name@_SECONDS seconds,
   inside the trained range: @coverage@ % of errors are within U, k = @k@. U does not depend on the temperature. */
double @name@_uncertainty(void);
/* U with an input outside the trained range, where it is larger. excess: result of @name@_excess(). */
double @name@_uncertainty_outside(double excess);

)";

constexpr const char* kUncertaintyDefinitions = R"(/* Standard uncertainty by source, in degrees per hour. */
static const double contribution[] = {
@contributions@};

double @name@_uncertainty(void) { return @expanded@; }

/* Assumes that the model form error is linear in the input and continues outside the range. */
double @name@_uncertainty_outside(double excess) {
  const double square = @standard@ * @standard@ + 3.0 * ((1.0 + 2.0 * excess) * (1.0 + 2.0 * excess) - 1.0) * @form@;
  return excess > 0.0 ? @k@ * sqrt(square) : @name@_uncertainty();
}

)";

constexpr const char* kTest = R"(  double square = 0.0;
  for (int i = 0; i < (int)(sizeof contribution / sizeof contribution[0]); ++i) {
    square += contribution[i] * contribution[i];
  }
  if (!(fabs(@k@ * sqrt(square) - @name@_uncertainty()) <= 1e-12 * @name@_uncertainty())) return 1;
  if (!(@name@_uncertainty_outside(1.0) >= @name@_uncertainty())) return 1;
)";

/// Formats a row: "  0.0003, /* angle random walk */".
std::string c_line(const BudgetRow& row) {
  std::string what = fmt::format("{}{}{}", name(row.source), row.of.empty() ? "" : " ", row.of);
  if (const auto row_remarks = remarks(row); !row_remarks.empty())
    what += fmt::format(" ({})", fmt::join(row_remarks, ", "));
  return fmt::format("  {}, /* {} */\n", c_number(contribution_deg_per_h(row)), c_comment(what));
}

}  // namespace

Result<CPart> uncertainty_in_c(const Model& model, std::string_view name) {
  if (!model.uncertainty || model.uncertainty->budget.rows.empty()) return CPart{};
  const std::vector<BudgetRow> rows = convert_averaging(model.uncertainty->budget, rows_in_cluster(model)).rows;
  const CombinedUncertainty all = combined(rows);
  if (!std::isfinite(all.expanded_deg_per_h))
    return failure(FaultKind::usage, "C export", "the combined uncertainty of the model is not finite");
  std::string contributions;
  for (const BudgetRow& row : rows) contributions += c_line(row);
  const CPlaceholders placeholders = {{"name", std::string(name)},
                                      {"coverage", fmt::format("{:.0f}", 100 * kCoverage)},
                                      {"k", c_number(all.coverage_factor)},
                                      {"contributions", contributions},
                                      {"expanded", c_number(all.expanded_deg_per_h)},
                                      {"standard", c_number(all.standard_deg_per_h)},
                                      {"form", c_number(form_variance(rows))}};
  return CPart{.declarations = c_fill(kUncertaintyDeclarations, placeholders),
               .definitions = c_fill(kUncertaintyDefinitions, placeholders),
               .test = c_fill(kTest, placeholders)};
}

}  // namespace gyrotherm::model
