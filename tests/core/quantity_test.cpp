#include "core/quantity.hpp"

#include <gtest/gtest.h>

#include <type_traits>

namespace gyrotherm {
namespace {

template <class A, class B>
concept Addable = requires(A a, B b) {
  a + b;
};

static_assert(!Addable<Celsius, Celsius>, "points do not add");
static_assert(Addable<Celsius, Kelvins>);
static_assert(std::is_same_v<decltype(Celsius{} - Celsius{}), Kelvins>);

TEST(Quantity, ADifferenceOfPointsIsAnAmount) {
  EXPECT_EQ(Celsius{60} - Celsius{-40}, Kelvins{100});
  EXPECT_EQ(Celsius{-40} + Kelvins{100}, Celsius{60});
  EXPECT_EQ(abs(Celsius{-40} - Celsius{60}), Kelvins{100});
}

TEST(Quantity, ARateTimesATimeIsAnAmountAndBack) {
  EXPECT_EQ(CelsiusPerMinute{5} * std::chrono::minutes(20), Kelvins{100});
  EXPECT_EQ(Kelvins{100} / CelsiusPerMinute{5}, std::chrono::minutes(20));
  EXPECT_EQ(Kelvins{100} / CelsiusPerMinute{3}, std::chrono::seconds(2000));
}

TEST(Quantity, SecondsGoToNanosecondsAndBackExactly) {
  for (const double s : {0.0, 0.25, 1.0, 221600.0, 1e8}) EXPECT_EQ(to_seconds(from_seconds(s)), s);
  EXPECT_EQ(from_seconds(-1.5), std::chrono::milliseconds(-1500));
}

}  // namespace
}  // namespace gyrotherm
