// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/web.hpp"

#include <algorithm>
#include <set>

#include "core/json.hpp"
#include "core/json_reader.hpp"

namespace gyrotherm::monitor {
namespace {

/// Returns whether a key occurs twice. JSON parsers differ in which of the two values they use.
bool has_duplicate_key(const std::string& body) {
  std::set<std::string> keys;
  bool has_duplicate = false;
  const auto check_key = [&](int, Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::key)
      has_duplicate = !keys.insert(value.get<std::string>()).second || has_duplicate;
    return true;
  };
  return !Json::parse(body, check_key, false).is_discarded() && has_duplicate;
}

}  // namespace

Result<std::map<std::string, std::string>> read_body(const WebRequest& request, const std::vector<std::string>& keys) {
  const auto refuse = [](const char* reason) { return failure(FaultKind::usage, "body", reason); };
  const auto type = request.head.header("content-type");
  if (type != "application/json" && !type.starts_with("application/json;")) return refuse("the body is not JSON");
  const auto root = JsonNode::parse(request.body, "body");
  if (!root) return refuse("the body is not JSON");
  std::map<std::string, std::string> texts;
  for (const auto& key : keys) texts[key];
  for (const auto& [key, value] : root->members()) {
    if (std::ranges::find(keys, key) == keys.end()) return refuse("unknown key in the body");
    texts[key] = value.text();
  }
  if (!root->verdict()) return refuse("the body is not a JSON object of strings");
  if (has_duplicate_key(request.body)) return refuse("duplicate key in the body");
  return texts;
}

WebAnswer refusal(int status, std::string_view reason) {
  return {.status = status, .body = json_text(Json{{"error", std::string(reason)}}) + "\n"};
}

}  // namespace gyrotherm::monitor
