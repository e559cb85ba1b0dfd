// SPDX-License-Identifier: Apache-2.0
/// What a struct says of its own form in a file: a function `describe` names the key of each member, in the order of
/// the file, and the same function writes the struct and reads it back.
///
///     void describe(auto& form, Like<Point> auto& point) {
///       form("x_m", point.x_m);
///       form("weight", positive(point.weight));
///       form.derived("length_m", length_m(point));
///     }
///
/// A form (JsonWriter and JsonReader of core/json.hpp) has these members:
///
/// - `form(key, value)`: a member. Numbers, words, lists, optional values and described structs have a form of their
/// own;
///   what this header declares gives a number or a word a narrower one.
/// - `form.derived(key, value)`: what can be computed again; it is written for whoever reads the file, and not read.
/// - `form.if_there(key, there, value)`: written if it is there, read if its key is.
/// - `form.object(key, describe_members)`: members that stand together in the file and not in the struct;
///   `form.object_if_there(key, there, describe_members)` likewise.
/// - `form.expect(key, holds, what)`: a mistake at that key if it does not hold of what was read.
#pragma once

#include <concepts>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace gyrotherm {

/// A `Described`, to be read into, or a const one, to be written.
template <class T, class Described>
concept Like = std::same_as<std::remove_const_t<T>, Described>;

/// A number that is 0 where it is not known: null in the file.
template <class T>
struct Known {
  T& value;
};
template <class T>
Known<T> known(T& value) {
  return {value};
}

/// A number in a range, which may exclude its lower end.
template <class T>
struct InRange {
  T& value;
  double low, high;
  bool low_excluded;
  const char* expected;
};
template <class T>
InRange<T> positive(T& value, double at_most = 1e300) {
  return {value, 0, at_most, true, "expected a number above 0, of a sane size"};
}
template <class T>
InRange<T> not_negative(T& value) {
  return {value, 0, 1e300, false, "expected a number not below 0"};
}

/// One of few words: the name() of an enumerator.
template <class T>
struct OneOf {
  T& value;
  std::initializer_list<std::remove_const_t<T>> all;
};
template <class T>
OneOf<T> one_of(T& value, std::initializer_list<std::remove_const_t<T>> all) {
  return {value, all};
}

/// An optional time, in seconds.
template <class T>
struct InSeconds {
  T& time;
};
template <class T>
InSeconds<T> in_seconds(T& time) {
  return {time};
}

/// Values under names that the file chooses, in its order: one object.
template <class T>
struct ByName {
  T& values;  ///< a vector of pairs of name and value
};
template <class T>
ByName<T> by_name(T& values) {
  return {values};
}

}  // namespace gyrotherm
