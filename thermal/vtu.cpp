#include "thermal/vtu.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "thermal/assembly.hpp"
#include "thermal/hex20.hpp"

namespace gyrotherm {
namespace {

struct Cells {
  std::vector<std::int32_t> connectivity;
  std::vector<std::int32_t> offsets;
  std::vector<std::uint8_t> types;
  std::vector<std::uint8_t> parts;
};

std::vector<float> points_of(const GyroMesh& mesh) {
  std::vector<float> points(3 * mesh.node_count);
  std::size_t point = 0;
  for (int K = 0; K <= 2 * mesh.nz(); ++K)
    for (int J = 0; J <= 2 * mesh.ny(); ++J)
      for (int I = 0; I <= 2 * mesh.nx(); ++I, ++point) {
        const auto node = mesh.nodes[point];
        if (node < 0) continue;
        points[3 * node] = static_cast<float>(doubled(mesh.x, I));
        points[3 * node + 1] = static_cast<float>(doubled(mesh.y, J));
        points[3 * node + 2] = static_cast<float>(doubled(mesh.z, K));
      }
  return points;
}

Cells cells_of(const GyroMesh& mesh) {
  constexpr std::uint8_t kQuadraticHexahedron = 25;
  Cells cells;
  for (int k = 0; k < mesh.nz(); ++k)
    for (int j = 0; j < mesh.ny(); ++j)
      for (int i = 0; i < mesh.nx(); ++i) {
        const auto& brick = mesh.classes[mesh.bricks[mesh.brick(i, j, k)]];
        if (brick.shares.empty()) continue;
        const auto nodes = nodes_of(mesh, i, j, k);
        cells.connectivity.insert(cells.connectivity.end(), nodes.begin(), nodes.end());
        cells.offsets.push_back(static_cast<std::int32_t>(cells.connectivity.size()));
        cells.types.push_back(kQuadraticHexahedron);
        cells.parts.push_back(static_cast<std::uint8_t>(std::ranges::max(brick.shares, {}, &PartShare::share).part));
      }
  return cells;
}

template <class T>
std::uint64_t bytes(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

template <class T>
void append(std::ostream& out, const std::vector<T>& values) {
  const auto size = bytes(values);
  out.write(reinterpret_cast<const char*>(&size), sizeof size);
  out.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(size));
}

}  // namespace

void write_vtu(std::ostream& out, const GyroMesh& mesh, const Eigen::VectorXd& field_c) {
  const auto points = points_of(mesh);
  const auto cells = cells_of(mesh);
  std::vector<float> temperatures(mesh.node_count);
  for (std::size_t n = 0; n < mesh.node_count; ++n)
    temperatures[n] = static_cast<float>(field_c[static_cast<Eigen::Index>(n)]);
  std::uint64_t offset = 0;
  const auto array = [&](const char* type, const char* name, std::uint64_t size, const char* more = "") {
    auto text = fmt::format("<DataArray type=\"{}\" Name=\"{}\"{} format=\"appended\" offset=\"{}\"/>\n", type, name,
                            more, offset);
    offset += size + sizeof(std::uint64_t);
    return text;
  };
  out << fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{}\" "
      "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
      std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian", mesh.node_count, cells.types.size());
  out << "<Points>\n" << array("Float32", "points", bytes(points), " NumberOfComponents=\"3\"") << "</Points>\n";
  out << "<Cells>\n"
      << array("Int32", "connectivity", bytes(cells.connectivity)) << array("Int32", "offsets", bytes(cells.offsets))
      << array("UInt8", "types", bytes(cells.types)) << "</Cells>\n";
  out << "<PointData Scalars=\"T\">\n" << array("Float32", "T", bytes(temperatures)) << "</PointData>\n";
  out << "<CellData>\n" << array("UInt8", "part", bytes(cells.parts)) << "</CellData>\n";
  out << "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
  append(out, points);
  append(out, cells.connectivity);
  append(out, cells.offsets);
  append(out, cells.types);
  append(out, temperatures);
  append(out, cells.parts);
  out << "\n</AppendedData>\n</VTKFile>\n";
}

}  // namespace gyrotherm
