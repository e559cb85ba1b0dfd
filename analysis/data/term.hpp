/// One input of a model: a temperature, a gradient (the difference of two thermometers) or a temperature rate, or the
/// product of up to three of these.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm {

enum class FactorKind { temperature, gradient, rate };
/// "temperature", "gradient", "rate".
[[nodiscard]] const char* name(FactorKind kind);

/// T_first (°C), T_first − T_second (°C), or the causal dT_first/dt (°C/min).
struct Factor {
  FactorKind kind{};
  std::string first;
  std::string second;  ///< gradient only
  auto operator<=>(const Factor&) const = default;
};

inline constexpr std::size_t kMostFactors = 3;

/// A product of one to kMostFactors factors, in order: A·B and B·A are the same term.
struct Term {
  std::vector<Factor> factors;
  auto operator<=>(const Term&) const = default;
};

[[nodiscard]] Term temperature_term(std::string thermometer);
[[nodiscard]] Term gradient_term(std::string first, std::string second);
[[nodiscard]] Term rate_term(std::string thermometer);
/// Of kMostFactors factors at most in all.
[[nodiscard]] Term operator*(const Term& a, const Term& b);

/// True if it needs the rate of a thermometer.
[[nodiscard]] bool has_rate(const Term& term);

/// "A", "A-B", "rate:A", a power of one like "A^2" ("A-B^2" is the square of the difference), or a product like
/// "A*rate:A" and "A*A-B". A thermometer's name may hold '-', '*' and '^': what can be read as a whole name is. Fails
/// with usage, naming the nearest thermometer.
[[nodiscard]] Result<Term> parse_term(std::string_view text, const std::vector<std::string>& thermometers);
/// What parse_term reads as the same term, unless another thermometer bears that very name.
[[nodiscard]] std::string text(const Term& term);

}  // namespace gyrotherm
