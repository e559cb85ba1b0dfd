// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/web.hpp"

#include <algorithm>
#include <set>

#include "core/json.hpp"
#include "core/json_reader.hpp"

namespace gyrotherm::monitor {
namespace {

/// Returns whether a key occurs twice. JSON readers differ in the value that they use in this case.
bool has_duplicate_key(const std::string& body) {
  std::set<std::string> keys;
  bool twice = false;
  const auto look = [&](int, Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::key) twice = !keys.insert(value.get<std::string>()).second || twice;
    return true;
  };
  return !Json::parse(body, look, false).is_discarded() && twice;
}

}  // namespace

Result<std::map<std::string, std::string>> read_body(const WebRequest& request, const std::vector<std::string>& keys) {
  const auto refuse = [](const char* why) { return failure(FaultKind::usage, "body", why); };
  const auto type = request.head.header("content-type");
  if (type != "application/json" && !type.starts_with("application/json;")) return refuse("the body is not JSON");
  const auto root = JsonNode::parse(request.body, "body");
  if (!root) return refuse("the body is not JSON");
  std::map<std::string, std::string> texts;
  for (const auto& key : keys) texts[key];
  for (const auto& [key, place] : root->members()) {
    if (std::ranges::find(keys, key) == keys.end()) return refuse("unknown key in the body");
    texts[key] = place.text();
  }
  if (!root->verdict()) return refuse("the body is not an object of strings");
  if (has_duplicate_key(request.body)) return refuse("duplicate key in the body");
  return texts;
}

WebAnswer refusal(int status, std::string_view why) {
  return {.status = status, .body = text_of(Json{{"error", std::string(why)}}) + "\n"};
}

}  // namespace gyrotherm::monitor
