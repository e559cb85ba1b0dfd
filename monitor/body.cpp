// SPDX-License-Identifier: Apache-2.0
#include "monitor/body.hpp"

#include <algorithm>

#include "core/json_reader.hpp"

namespace gyrotherm::monitor {

Result<std::map<std::string, std::string>> read_body(const WebRequest& request, const std::vector<std::string>& keys) {
  const auto refuse = [](const char* why) { return failure(FaultKind::usage, "body", why); };
  const auto type = request.head.header("content-type");
  if (type != "application/json" && !type.starts_with("application/json;")) return refuse("the body is no JSON");
  const auto root = JsonPlace::parse(request.body, "body");
  if (!root) return refuse("the body is no JSON");
  std::map<std::string, std::string> texts;
  for (const auto& key : keys) texts[key];
  for (const auto& [key, place] : root->members()) {
    if (std::ranges::find(keys, key) == keys.end()) return refuse("the body has a key that is not known here");
    texts[key] = place.text();
  }
  if (!root->verdict()) return refuse("the body is no object of texts");
  return texts;
}

}  // namespace gyrotherm::monitor
