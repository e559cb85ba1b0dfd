// SPDX-License-Identifier: Apache-2.0
#include "core/json_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/text.hpp"

namespace gyrotherm {
namespace {

using Json = nlohmann::ordered_json;

const Json* as_json(const void* node) { return static_cast<const Json*>(node); }

std::string format_position(std::string_view text, std::size_t byte, const std::string& file) {
  const std::string_view before = text.substr(0, std::min(byte > 0 ? byte - 1 : 0, text.size()));
  const auto line = 1 + std::ranges::count(before, '\n');
  const auto newline = before.rfind('\n');
  const auto column = newline == std::string_view::npos ? before.size() + 1 : before.size() - newline;
  return fmt::format("{}:{}:{}", file, line, column);
}

}  // namespace

struct JsonNode::Document {
  std::string file;
  Nulls nulls;
  Json root;
  std::optional<Fault> first_error;
};

JsonNode::JsonNode(std::shared_ptr<Document> document, const void* node, std::string path)
    : document_(std::move(document)), node_(node), path_(std::move(path)) {}

Result<JsonNode> JsonNode::parse(std::string_view text, std::string file, Nulls nulls) {
  auto document = std::make_shared<Document>();
  std::vector<std::set<std::string>> open_objects;
  std::optional<std::string> repeated_key;
  const auto watch_keys = [&](int, Json::parse_event_t event, const Json& parsed) {
    if (event == Json::parse_event_t::object_start) open_objects.emplace_back();
    if (event == Json::parse_event_t::object_end) open_objects.pop_back();
    if (event == Json::parse_event_t::key && !open_objects.back().insert(parsed.get<std::string>()).second)
      repeated_key = parsed.get<std::string>();
    return true;
  };
  try {
    document->root = Json::parse(text, watch_keys);
  } catch (const Json::parse_error& error) {
    const auto other = detect_other_format(text);
    if (!other.empty() && other != "JSON")
      return failure(FaultKind::bad_file, format_position(text, 1, file),
                     fmt::format("is {}, expected a JSON document", other));
    if (text.find_first_not_of(" \t\r\n") == std::string_view::npos)
      return failure(FaultKind::bad_file, format_position(text, 1, file), "is empty, expected a JSON document");
    if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
      return failure(FaultKind::bad_file, format_position(text, 1, file),
                     "the file is in UTF-16, expected UTF-8: save it as UTF-8, without \"Unicode\" or \"UTF-16\"");
    const bool is_cut = error.byte > text.size();
    return failure(
        FaultKind::bad_file, format_position(text, error.byte, file),
        is_cut ? "the file ends here, expected the rest of a JSON document" : "not JSON, expected a JSON document");
  } catch (const Json::exception& error) {
    return failure(FaultKind::bad_file, file, error.what());
  }
  if (repeated_key)
    return failure(FaultKind::bad_file, file, fmt::format("the key \"{}\" occurs twice in an object", *repeated_key));
  document->file = std::move(file);
  document->nulls = nulls;
  const void* root = &document->root;
  return JsonNode(std::move(document), root, "");
}

void JsonNode::note_error(const std::string& what) const {
  if (document_->first_error) return;
  const std::string where = path_.empty() ? document_->file : document_->file + ": " + path_;
  document_->first_error = Fault{FaultKind::bad_file, where, what};
}

Result<void> JsonNode::verdict() const {
  if (document_->first_error) return failure(*document_->first_error);
  return {};
}

bool JsonNode::has(std::string_view key) const {
  const Json* node = as_json(node_);
  return node != nullptr && node->is_object() && node->contains(key);
}

JsonNode JsonNode::operator[](std::string_view key) const {
  const std::string path = path_.empty() ? std::string(key) : path_ + "." + std::string(key);
  const Json* node = as_json(node_);
  const JsonNode there(document_, has(key) ? &*node->find(key) : nullptr, path);
  if (node != nullptr && !has(key)) there.note_error("missing, expected a value");
  return there;
}

std::vector<JsonNode> JsonNode::elements() const {
  const Json* node = as_json(node_);
  if (node == nullptr) return {};
  if (!node->is_array()) return note_error("wrong type, expected an array"), std::vector<JsonNode>{};
  std::vector<JsonNode> all;
  for (const Json& element : *node)
    all.push_back(JsonNode(document_, &element, fmt::format("{}[{}]", path_, all.size())));
  return all;
}

std::vector<std::pair<std::string, JsonNode>> JsonNode::members() const {
  const Json* node = as_json(node_);
  if (node == nullptr) return {};
  if (!node->is_object())
    return note_error("wrong type, expected an object"), std::vector<std::pair<std::string, JsonNode>>{};
  std::vector<std::pair<std::string, JsonNode>> all;
  for (const auto& [key, value] : node->items()) all.emplace_back(key, JsonNode(document_, &value, path_ + "." + key));
  return all;
}

bool JsonNode::is_null() const {
  const Json* node = as_json(node_);
  return node != nullptr && node->is_null();
}

double JsonNode::number() const {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  const Json* node = as_json(node_);
  if (node == nullptr) return kNothing;
  if (node->is_number()) return node->get<double>();
  const bool may_be_null = document_->nulls == Nulls::read_as_nan;
  if (!node->is_null() || !may_be_null)
    note_error(may_be_null ? "wrong type, expected a number or null" : "wrong type, expected a number");
  return kNothing;
}

int JsonNode::integer() const {
  const Json* node = as_json(node_);
  if (node == nullptr) return 0;
  const bool fits = node->is_number_integer() && node->get<double>() >= std::numeric_limits<int>::min() &&
                    node->get<double>() <= std::numeric_limits<int>::max();
  if (!fits) return note_error("wrong type, expected a whole number"), 0;
  return node->get<int>();
}

std::int64_t JsonNode::long_integer() const {
  const Json* node = as_json(node_);
  if (node == nullptr) return 0;
  const bool fits =
      node->is_number_integer() &&
      (!node->is_number_unsigned() || node->get<std::uint64_t>() <= std::numeric_limits<std::int64_t>::max());
  if (!fits) return note_error("wrong type, expected a whole number"), 0;
  return node->get<std::int64_t>();
}

bool JsonNode::boolean() const {
  const Json* node = as_json(node_);
  if (node == nullptr) return false;
  if (!node->is_boolean()) return note_error("wrong type, expected true or false"), false;
  return node->get<bool>();
}

std::string JsonNode::text() const {
  const Json* node = as_json(node_);
  if (node == nullptr) return {};
  if (!node->is_string()) return note_error("wrong type, expected a text"), std::string{};
  return node->get<std::string>();
}

std::uint64_t JsonNode::whole() const {
  const Json* node = as_json(node_);
  if (node == nullptr) return 0;
  if (!node->is_number_unsigned()) return note_error("wrong type, expected a whole number of 0 or more"), 0;
  return node->get<std::uint64_t>();
}

std::vector<double> JsonNode::numbers() const {
  const Json* node = as_json(node_);
  const bool plain = node != nullptr && node->is_array() && std::ranges::all_of(*node, &Json::is_number);
  if (plain) return node->get<std::vector<double>>();
  std::vector<double> all;
  for (const JsonNode& element : elements()) all.push_back(element.number());
  return all;
}

std::vector<std::string> JsonNode::texts() const {
  std::vector<std::string> all;
  for (const JsonNode& element : elements()) all.push_back(element.text());
  return all;
}

}  // namespace gyrotherm
