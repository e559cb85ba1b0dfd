/// The gyro as a thermal body: what a lumped network, or a reduced finite-element model, must offer to the virtual
/// laboratory.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "core/quantity.hpp"

namespace gyrotherm {

inline constexpr std::size_t kBlockPlaces = 8;    ///< A…H, on the block
inline constexpr std::size_t kThermalPlaces = 9;  ///< and "shell", the air inside the cabinet

/// The names of the places, in their order everywhere in this room.
inline constexpr std::array<std::string_view, kThermalPlaces> kPlaceNames{"A", "B", "C", "D",    "E",
                                                                          "F", "G", "H", "shell"};

using BlockTemperatures = std::span<const double, kBlockPlaces>;    ///< °C
using PlaceTemperatures = std::span<const double, kThermalPlaces>;  ///< °C

class GyroThermal {
 public:
  virtual ~GyroThermal() = default;
  /// Lets one second pass with the chamber's air at `air`.
  virtual void step(Celsius air) = 0;
  /// True temperatures at the places now; the bias depends on the block's.
  [[nodiscard]] virtual PlaceTemperatures temperatures_c() const = 0;
};

}  // namespace gyrotherm
