// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/web.hpp"

#include "core/json.hpp"

namespace gyrotherm::monitor {

WebAnswer refusal(int status, std::string_view why) {
  return {.status = status, .body = text_of(Json{{"error", std::string(why)}}) + "\n"};
}

}  // namespace gyrotherm::monitor
