// SPDX-License-Identifier: Apache-2.0
/// The body of a POST: a flat JSON object of texts.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "apps/monitor/web.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

/// The texts of these keys, empty where one is missing. Fails with usage if the content type is another than
/// application/json, if it is no object of texts, or has another key.
[[nodiscard]] Result<std::map<std::string, std::string>> read_body(const WebRequest& request,
                                                                   const std::vector<std::string>& keys);

}  // namespace gyrotherm::monitor
