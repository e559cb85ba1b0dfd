// SPDX-License-Identifier: Apache-2.0
/// Parses arbitrary bytes as a model file. A parsed model must be the same after it is written and read again.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "analysis/model/model.hpp"
#include "tests/support/fuzz_target.hpp"

FUZZ_TARGET(model_json, const std::uint8_t* data, std::size_t size) {
  const auto model = gyrotherm::model::model_from_json({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!model) return 0;
  const std::string json = gyrotherm::model::to_json(*model);
  const auto again = gyrotherm::model::model_from_json(json, "fuzz");
  if (!again || gyrotherm::model::to_json(*again) != json) std::abort();
  return 0;
}
