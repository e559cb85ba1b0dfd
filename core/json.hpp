// SPDX-License-Identifier: Apache-2.0
/// Conversion of described structs (core/form.hpp) to and from JSON: make_json() and read_json(). Include this header
/// only in sources that read or write files, because it includes nlohmann's JSON.
#pragma once

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/form.hpp"
#include "core/json_reader.hpp"
#include "core/quantity.hpp"

namespace gyrotherm {

using Json = nlohmann::ordered_json;

/// Returns a document as text, on one line or with `indent` blanks per level. NaN is written as null. Bytes that are
/// not UTF-8 are replaced by U+FFFD.
[[nodiscard]] inline std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// Writes and reads values of one type. Specialised for every type that is not a described struct.
template <class T>
struct JsonValue;

template <class T>
[[nodiscard]] Json make_json(const T& value) {
  return JsonValue<T>::write(value);
}
/// Reads the value at `node`. Notes an error in the document if the value is wrong.
template <class T>
void read_json(const JsonNode& node, T& value) {
  JsonValue<T>::read(node, value);
}

class JsonWriter {
 public:
  template <class T>
  void operator()(const char* key, const T& value) {
    json_[key] = make_json(value);
  }
  template <class T>
  void derived(const char* key, const T& value) {
    json_[key] = make_json(value);
  }
  void derived(const char* key, const char* text) { json_[key] = text; }
  template <class T>
  void if_present(const char* key, bool there, const T& value) {
    if (there) json_[key] = make_json(value);
  }
  template <class DescribeMembers>
  void object(const char* key, DescribeMembers describe_members) {
    JsonWriter inside;
    describe_members(inside);
    json_[key] = std::move(inside.json_);
  }
  template <class DescribeMembers>
  void object_if_present(const char* key, bool there, DescribeMembers describe_members) {
    if (there) object(key, describe_members);
  }
  void expect(const char*, bool, const char*) {}
  [[nodiscard]] Json json() && { return std::move(json_); }

 private:
  Json json_ = Json::object();
};

class JsonReader {
 public:
  explicit JsonReader(JsonNode node) : node_(std::move(node)) {}

  template <class T>
  void operator()(const char* key, T&& value) {
    JsonValue<std::remove_cvref_t<T>>::read(node_[key], value);
  }
  template <class T>
  void derived(const char*, const T&) {}
  template <class T>
  void if_present(const char* key, bool, T&& value) {
    if (node_.has(key)) (*this)(key, value);
  }
  template <class DescribeMembers>
  void object(const char* key, DescribeMembers describe_members) {
    JsonReader inside(node_[key]);
    describe_members(inside);
  }
  template <class DescribeMembers>
  void object_if_present(const char* key, bool, DescribeMembers describe_members) {
    if (node_.has(key)) object(key, describe_members);
  }
  void expect(const char* key, bool holds, const char* what) {
    if (!holds) node_[key].note_error(what);
  }

 private:
  JsonNode node_;
};

/// The general case: a described struct.
template <class T>
struct JsonValue {
  static Json write(const T& value) {
    JsonWriter form;
    describe(form, value);
    return std::move(form).json();
  }
  static void read(const JsonNode& node, T& value) {
    JsonReader form(node);
    describe(form, value);
  }
};

/// A type that nlohmann's JSON can write; `Read` is the member function of JsonNode that reads it.
template <class T, auto Read>
struct PlainJsonValue {
  static Json write(const T& value) { return value; }
  static void read(const JsonNode& node, T& value) { value = (node.*Read)(); }
};
template <>
struct JsonValue<double> : PlainJsonValue<double, &JsonNode::number> {};
template <>
struct JsonValue<int> : PlainJsonValue<int, &JsonNode::integer> {};
template <>
struct JsonValue<std::int64_t> : PlainJsonValue<std::int64_t, &JsonNode::long_integer> {};
template <>
struct JsonValue<bool> : PlainJsonValue<bool, &JsonNode::boolean> {};
template <>
struct JsonValue<std::uint64_t> : PlainJsonValue<std::uint64_t, &JsonNode::whole> {};
template <>
struct JsonValue<std::string> : PlainJsonValue<std::string, &JsonNode::text> {};
template <>
struct JsonValue<std::vector<double>> : PlainJsonValue<std::vector<double>, &JsonNode::numbers> {};

template <class T>
struct JsonValue<std::vector<T>> {
  static Json write(const std::vector<T>& values) {
    Json array = Json::array();
    for (const T& value : values) array.push_back(make_json(value));
    return array;
  }
  static void read(const JsonNode& node, std::vector<T>& values) {
    values.clear();
    for (const JsonNode& element : node.elements()) read_json(element, values.emplace_back());
  }
};

/// An empty optional is stored as null.
template <class T>
struct JsonValue<std::optional<T>> {
  static Json write(const std::optional<T>& value) { return value ? make_json(*value) : Json(nullptr); }
  static void read(const JsonNode& node, std::optional<T>& value) {
    value.reset();
    if (!node.is_null()) read_json(node, value.emplace());
  }
};

template <>
struct JsonValue<Celsius> {
  static Json write(Celsius temperature) { return temperature.value; }
  static void read(const JsonNode& node, Celsius& temperature) { temperature.value = node.number(); }
};

/// A duration in whole nanoseconds.
template <>
struct JsonValue<Duration> {
  static Json write(Duration time) { return time.count(); }
  static void read(const JsonNode& node, Duration& time) { time = Duration(node.long_integer()); }
};

/// The lower and the upper bound of a range, as an array of two numbers.
template <>
struct JsonValue<std::pair<double, double>> {
  static Json write(const std::pair<double, double>& ends) { return Json::array({ends.first, ends.second}); }
  static void read(const JsonNode& node, std::pair<double, double>& ends) {
    const std::vector<double> both = node.numbers();
    if (both.size() != 2) return node.note_error("wrong length, expected a lower and an upper bound");
    ends = {both[0], both[1]};
  }
};

template <class T>
struct JsonValue<Known<T>> {
  static Json write(const Known<T>& known) { return known.value > 0 ? Json(known.value) : Json(nullptr); }
  static void read(const JsonNode& node, const Known<T>& known) {
    known.value = 0;
    if (!node.is_null()) read_json(node, known.value);
  }
};

template <class T>
struct JsonValue<InRange<T>> {
  static Json write(const InRange<T>& in) { return make_json(in.value); }
  static void read(const JsonNode& node, const InRange<T>& in) {
    read_json(node, in.value);
    const bool holds = (in.low_excluded ? in.value > in.low : in.value >= in.low) && in.value <= in.high;
    if (!holds) node.note_error(in.expected);
  }
};

template <class T>
struct JsonValue<OptionalSeconds<T>> {
  static Json write(const OptionalSeconds<T>& in) { return in.time ? Json(to_seconds(*in.time)) : Json(nullptr); }
  static void read(const JsonNode& node, const OptionalSeconds<T>& in) {
    in.time.reset();
    if (!node.is_null()) in.time = from_seconds(node.number());
  }
};

template <class T>
struct JsonValue<OneOf<T>> {
  static Json write(const OneOf<T>& word) { return name(word.value); }
  static void read(const JsonNode& node, const OneOf<T>& word) {
    const std::string text = node.text();
    std::vector<std::string> names;
    for (const auto value : word.all) {
      names.emplace_back(name(value));
      if (text == names.back()) return void(word.value = value);
    }
    node.note_error(fmt::format("\"{}\", expected {}", text, fmt::join(names, " or ")));
  }
};

template <class T>
struct JsonValue<NamedValues<T>> {
  static Json write(const NamedValues<T>& named) {
    Json object = Json::object();
    for (const auto& [name, value] : named.values) object[name] = make_json(value);
    return object;
  }
  static void read(const JsonNode& node, const NamedValues<T>& named) {
    named.values.clear();
    for (const auto& [name, value] : node.members()) {
      named.values.emplace_back().first = name;
      read_json(value, named.values.back().second);
    }
  }
};

}  // namespace gyrotherm
