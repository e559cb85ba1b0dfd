#include "tests/thermal/small_bodies.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/file.hpp"
#include "thermal/gyro_file.hpp"

namespace gyrotherm {

std::string gyro_text(const std::string& name) {
  const auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/gyros/" + name + ".toml");
  EXPECT_TRUE(text) << name;
  return text.value_or("");
}

GyroModel shipped_gyro(const std::string& name) {
  const auto model = parse_gyro(gyro_text(name), name);
  EXPECT_TRUE(model) << text(model.error());
  return model.value_or(GyroModel{});
}

std::vector<double> even_lines(double length, int pieces) {
  std::vector<double> lines;
  for (int i = 0; i <= pieces; ++i) lines.push_back(length * i / pieces);
  return lines;
}

GyroMesh box_of(GyroPart part, std::vector<double> x, std::vector<double> y, std::vector<double> z,
                const std::vector<int>& film_faces) {
  GyroMesh mesh;
  mesh.x = std::move(x);
  mesh.y = std::move(y);
  mesh.z = std::move(z);
  mesh.classes = {{}, {{{part, 1.0}}, {}}};
  mesh.bricks.assign(static_cast<std::size_t>(mesh.nx()) * mesh.ny() * mesh.nz(), 1);
  for (int k = 0; k < mesh.nz(); ++k)
    for (int j = 0; j < mesh.ny(); ++j)
      for (int i = 0; i < mesh.nx(); ++i) {
        const bool outer[] = {i == 0, i == mesh.nx() - 1, j == 0, j == mesh.ny() - 1, k == 0, k == mesh.nz() - 1};
        for (const int face : film_faces)
          if (outer[face]) mesh.film.push_back({mesh.brick(i, j, k), face, 1});
      }
  number_nodes(mesh);
  return mesh;
}

GyroModel uniform_model(const MaterialProperties& properties) {
  GyroModel model;
  model.materials.fill(properties);
  return model;
}

}  // namespace gyrotherm
