/// Foreign records in.
#pragma once

#include <cstddef>
#include <string>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm {

struct ImportSummary {
  std::size_t rows{};
  Duration span{};         ///< from the first row to the last
  std::size_t silences{};  ///< spacings longer than 10 times the median one
};

/// Makes a finished record at `record_path` of the text table at `table_path`, as the map at `map_path` says: each row
/// at its own time, its slot the row's number from 0, no segments and no cycles; missing stretches are told in an
/// event. Fails with bad_file (`file:line:column: what, what was expected`) or storage (the record exists); then
/// nothing is left.
[[nodiscard]] Result<ImportSummary> import_record(const std::string& table_path, const std::string& map_path,
                                                  const std::string& record_path, const std::string& program_version);

}  // namespace gyrotherm
