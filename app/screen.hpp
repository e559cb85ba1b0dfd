/// What a terminal is sent so that its last lines can be redrawn in place: messages scroll up, the picture below them
/// stays. Pure: it knows what stands on the terminal from what it was asked for.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm {

class Screen {
 public:
  /// The bytes that put whole lines of text above where the picture was; the picture is gone until it is drawn again.
  [[nodiscard]] std::string message(std::string_view text);
  /// The bytes that draw these lines in the place of those drawn before; the cursor stays in the last of them.
  [[nodiscard]] std::string picture(const std::vector<std::string>& lines);

 private:
  [[nodiscard]] std::string erase();
  std::size_t lines_open_ = 0;
};

/// The first characters of a line, as many as fit: one that wraps would leave its rest on the terminal.
[[nodiscard]] std::string cut_to(const std::string& line, std::size_t width);

}  // namespace gyrotherm
