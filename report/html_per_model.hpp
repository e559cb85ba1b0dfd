/// Rows of the HTML report's tables that have a cell per model.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "report/report_view.hpp"

namespace gyrotherm {

template <class T, class Cell>
std::vector<std::string> cells(std::string head, const PerModel<T>& of, Cell cell) {
  return {std::move(head), cell(of.three_point), cell(of.multi_point), cell(of.multi_point_t)};
}

[[nodiscard]] inline std::vector<std::string> model_header(std::string head) {
  return {std::move(head), "Three-point", "Multi-point", "Multi-point with temperature"};
}

}  // namespace gyrotherm
