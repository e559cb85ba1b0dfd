// SPDX-License-Identifier: Apache-2.0
/// Descriptions of structs that are stored in files. A function `describe` next to the struct lists its members and
/// their keys in the order of the file. The same function serves to write the struct and to read it:
///
///     void describe(auto& form, Like<Point> auto& point) {
///       form("x_m", point.x_m);
///       form("weight", positive(point.weight));
///       form.derived("length_m", length_m(point));
///     }
///
/// `form` is a JsonWriter or a JsonReader (core/json.hpp, make_json() and read_json()). Both have these members:
///
/// form(key, value)
///     Writes the value, or reads it. When reading, a missing key is an error.
/// form.derived(key, value)
///     Writes a value that can be computed from others, for people and programs that read the file. Ignored when
///     reading; the key may be missing.
/// form.if_present(key, there, value)
///     Writes the value only if `there` is true. When reading, a member whose key is missing keeps its value.
/// form.object(key, describe_members)
///     Stores some members of the struct in a nested object; describe_members(form) lists them.
/// form.object_if_present(key, there, describe_members)
///     Does the same under the conditions of if_present().
/// form.expect(key, holds, what)
///     When reading, notes the error `what` at `key` if `holds` is false. Call it after the members that `holds`
///     depends on. Does nothing when writing.
///
/// Values are double (NaN is null), int, std::int64_t, std::uint64_t, bool, std::string, Celsius, Duration (whole
/// nanoseconds), std::pair of doubles (an array of two), std::vector, std::optional (null if empty) and described
/// structs. The functions below wrap values that are stored in another form or have a narrower range. A range is
/// checked only when the value is read.
///
/// Reading continues after an error. JsonNode::verdict() returns the first error with its path.
#pragma once

#include <concepts>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace gyrotherm {

/// Matches `Described` for reading and `const Described` for writing.
template <class T, class Described>
concept Like = std::same_as<std::remove_const_t<T>, Described>;

/// A number above 0. An unknown value is 0 in the program and null in the file.
template <class T>
struct Known {
  T& value;
};
template <class T>
Known<T> known(T& value) {
  return {value};
}

/// A number from `low` to `high`. `expected` is the error message for any other number and for null.
template <class T>
struct InRange {
  T& value;
  double low, high;
  bool low_excluded;  ///< `low` itself is an error
  const char* expected;
};
template <class T>
InRange<T> positive(T& value, double at_most = 1e300) {
  return {value, 0, at_most, true, "expected a number above 0 that is not implausibly large"};
}
template <class T>
InRange<T> not_negative(T& value) {
  return {value, 0, 1e300, false, "expected 0 or more"};
}

/// An enumerator, stored as the text that name() returns. Any text that does not belong to one of `all` is an error.
template <class T>
struct OneOf {
  T& value;
  std::initializer_list<std::remove_const_t<T>> all;
};
template <class T>
OneOf<T> one_of(T& value, std::initializer_list<std::remove_const_t<T>> all) {
  return {value, all};
}

/// An optional Duration as a number of seconds; null if empty.
template <class T>
struct OptionalSeconds {
  T& time;
};
template <class T>
OptionalSeconds<T> optional_seconds(T& time) {
  return {time};
}

/// Pairs of a name and a value, stored as an object with the names as keys, in their order.
template <class T>
struct NamedValues {
  T& values;  ///< vector of pairs
};
template <class T>
NamedValues<T> named_values(T& values) {
  return {values};
}

}  // namespace gyrotherm
