// SPDX-License-Identifier: Apache-2.0
/// Writes a mesh as an input file of CalculiX, and a field on it as a file for ParaView.
#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <iterator>
#include <ostream>
#include <vector>

#include "simulator/thermal/assembly.hpp"
#include "simulator/thermal/hex20.hpp"
#include "simulator/thermal/mesh.hpp"

namespace gyrotherm::thermal {

namespace {

/// Buffers text and writes it in large pieces.
class Writer {
 public:
  explicit Writer(std::ostream& out) : out_(out) {}
  ~Writer() { flush(); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  template <class... Values>
  void put(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(buffer_), format, std::forward<Values>(values)...);
    if (buffer_.size() > 1 << 20) flush();
  }

 private:
  void flush() {
    out_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    buffer_.clear();
  }
  std::ostream& out_;
  fmt::memory_buffer buffer_;
};

/// An element, numbered from 1 in the order of bricks. Elements are grouped by class, because each class becomes one
/// element set.
struct Element {
  std::size_t number;
  int i, j, k;
};

std::vector<std::vector<Element>> elements_by_class(const GyroMesh& mesh) {
  std::vector<std::vector<Element>> elements(mesh.classes.size());
  std::size_t number = 0;
  each_brick(mesh, [&](int i, int j, int k, const BrickClass&) {
    if (const auto c = mesh.bricks[mesh.brick(i, j, k)]; c != 0) elements[c].push_back({++number, i, j, k});
  });
  return elements;
}

void put_nodes(Writer& writer, const GyroMesh& mesh) {
  writer.put("*NODE,NSET=NALL\n");
  each_node(mesh, [&](int node, int I, int J, int K) {
    writer.put("{},{:.12g},{:.12g},{:.12g}\n", node + 1, doubled_coordinate(mesh.x, I), doubled_coordinate(mesh.y, J),
               doubled_coordinate(mesh.z, K));
  });
}

double density(const GyroModel& model, const BrickClass& brick) {
  double sum = 0;
  for (const auto& [part, share] : brick.shares)
    sum += share * model.materials[static_cast<std::size_t>(part_material(part))].density_kg_per_m3;
  return sum;
}

void put_class(Writer& writer, const GyroModel& model, const GyroMesh& mesh, std::size_t number,
               const std::vector<Element>& elements, const ThermalCoefficients& coefficients) {
  // The first line has the element number and 11 nodes. A line may have at most 16 numbers.
  constexpr int kNodesOnFirstLine = 11;
  const auto& brick = mesh.classes[number];
  writer.put("** class {}:", number);
  for (const auto& [part, share] : brick.shares) writer.put(" {} {:.6g}", kGyroPartNames[index(part)], share);
  writer.put("\n*ELEMENT,TYPE=DC3D20,ELSET=C{}\n", number);
  for (const auto& element : elements) {
    writer.put("{}", element.number);
    const auto nodes = brick_nodes(mesh, element.i, element.j, element.k);
    for (int n = 0; n < 20; ++n) writer.put(",{}{}", n == kNodesOnFirstLine ? "\n" : "", nodes[n] + 1);
    writer.put("\n");
  }
  const double rho = density(model, brick);
  const auto k = conductivity(model, brick, coefficients);
  writer.put("*MATERIAL,NAME=M{}\n", number);
  if (brick.across == std::array<double, 3>{}) writer.put("*CONDUCTIVITY\n{:.12g}\n", k.xx);
  // The entries that mix z with another axis are zero.
  else
    writer.put("*CONDUCTIVITY,TYPE=ANISO\n{:.12g},{:.12g},{:.12g},{:.12g},0.,0.\n", k.xx, k.yy, k.zz, k.xy);
  writer.put("*DENSITY\n{:.12g}\n*SPECIFIC HEAT\n{:.12g}\n", rho, heat_capacity(model, brick) / rho);
  writer.put("*SOLID SECTION,ELSET=C{0},MATERIAL=M{0}\n", number);
}

/// Writes the heat sources of each class, W/m³.
void put_sources(Writer& writer, const GyroModel& model, const GyroMesh& mesh) {
  constexpr std::array<GyroPart, kThermalInputs - 1> kSourceParts{GyroPart::gain_left, GyroPart::gain_right,
                                                                  GyroPart::preamplifier, GyroPart::ballast_left,
                                                                  GyroPart::ballast_right};
  writer.put("*DFLUX\n");
  for (std::size_t c = 1; c < mesh.classes.size(); ++c) {
    double density_w_per_m3 = 0;
    for (std::size_t s = 0; s < kSourceParts.size(); ++s)
      if (const double share = part_share(mesh.classes[c], kSourceParts[s]); share > 0)
        density_w_per_m3 += model.powers_w[s] * share / part_volume(mesh, kSourceParts[s]);
    if (density_w_per_m3 > 0) writer.put("C{},BF,{:.15g}\n", c, density_w_per_m3);
  }
}

struct Cells {
  std::vector<std::int32_t> connectivity;
  std::vector<std::int32_t> offsets;
  std::vector<std::uint8_t> types;
  std::vector<std::uint8_t> parts;
};

std::vector<float> node_points(const GyroMesh& mesh) {
  std::vector<float> points(3 * mesh.node_count);
  each_node(mesh, [&](int node, int I, int J, int K) {
    const auto at = 3 * static_cast<std::size_t>(node);
    points[at] = static_cast<float>(doubled_coordinate(mesh.x, I));
    points[at + 1] = static_cast<float>(doubled_coordinate(mesh.y, J));
    points[at + 2] = static_cast<float>(doubled_coordinate(mesh.z, K));
  });
  return points;
}

Cells make_cells(const GyroMesh& mesh) {
  constexpr std::uint8_t kQuadraticHexahedron = 25;
  Cells cells;
  each_brick(mesh, [&](int i, int j, int k, const BrickClass& brick) {
    if (brick.shares.empty()) return;
    const auto nodes = brick_nodes(mesh, i, j, k);
    cells.connectivity.insert(cells.connectivity.end(), nodes.begin(), nodes.end());
    cells.offsets.push_back(static_cast<std::int32_t>(cells.connectivity.size()));
    cells.types.push_back(kQuadraticHexahedron);
    cells.parts.push_back(static_cast<std::uint8_t>(main_part(brick)));
  });
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

void write_calculix_input(std::ostream& out, const GyroModel& model, const GyroMesh& mesh,
                          const CalculixOptions& options) {
  Writer writer(out);
  writer.put("** {}\n", model.title);
  put_nodes(writer, mesh);
  const auto elements = elements_by_class(mesh);
  std::vector<std::size_t> number_of_brick(mesh.bricks.size());
  for (std::size_t c = 1; c < mesh.classes.size(); ++c) {
    if (elements[c].empty()) continue;
    put_class(writer, model, mesh, c, elements[c], options.coefficients);
    for (const auto& e : elements[c]) number_of_brick[mesh.brick(e.i, e.j, e.k)] = e.number;
  }
  writer.put("*INITIAL CONDITIONS,TYPE=TEMPERATURE\nNALL,{}\n*STEP\n*HEAT TRANSFER,STEADY STATE{}{}\n",
             options.ambient_c, options.solver.empty() ? "" : ",SOLVER=", options.solver);
  put_sources(writer, model, mesh);
  // For −x, +x, −y, +y, −z, +z.
  constexpr std::array<int, kBrickFaces> kFaceName{6, 4, 3, 5, 1, 2};
  const double film = options.coefficients[static_cast<std::size_t>(ThermalCoefficient::film)];
  writer.put("*FILM\n");
  for (const auto& face : mesh.film)
    writer.put("{},F{},{},{:.12g}\n", number_of_brick[face.brick], kFaceName[face.face], options.ambient_c,
               film * face.factor);
  writer.put("*NODE PRINT,NSET=NALL\nNT\n*END STEP\n");
}

void write_vtu(std::ostream& out, const GyroMesh& mesh, const Eigen::VectorXd& field_c) {
  const auto points = node_points(mesh);
  const auto cells = make_cells(mesh);
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

}  // namespace gyrotherm::thermal
