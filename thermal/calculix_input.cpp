#include "thermal/calculix_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <ostream>
#include <vector>

#include "thermal/assembly.hpp"

namespace gyrotherm {
namespace {

/// Gathers text and hands it on in large pieces.
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

/// Elements in the order of bricks, numbered from 1; by class, so that each class is one set.
struct Element {
  std::size_t number;
  int i, j, k;
};

std::vector<std::vector<Element>> elements_by_class(const GyroMesh& mesh) {
  std::vector<std::vector<Element>> elements(mesh.classes.size());
  std::size_t number = 0;
  for (int k = 0; k < mesh.nz(); ++k)
    for (int j = 0; j < mesh.ny(); ++j)
      for (int i = 0; i < mesh.nx(); ++i)
        if (const auto c = mesh.bricks[mesh.brick(i, j, k)]; c != 0) elements[c].push_back({++number, i, j, k});
  return elements;
}

void put_nodes(Writer& writer, const GyroMesh& mesh) {
  writer.put("*NODE,NSET=NALL\n");
  std::size_t point = 0;
  for (int K = 0; K <= 2 * mesh.nz(); ++K)
    for (int J = 0; J <= 2 * mesh.ny(); ++J)
      for (int I = 0; I <= 2 * mesh.nx(); ++I, ++point)
        if (mesh.nodes[point] >= 0)
          writer.put("{},{:.12g},{:.12g},{:.12g}\n", mesh.nodes[point] + 1, doubled(mesh.x, I), doubled(mesh.y, J),
                     doubled(mesh.z, K));
}

double density(const GyroModel& model, const BrickClass& brick) {
  double sum = 0;
  for (const auto& [part, share] : brick.shares)
    sum += share * model.materials[static_cast<std::size_t>(material_of(part))].density_kg_per_m3;
  return sum;
}

void put_class(Writer& writer, const GyroModel& model, const GyroMesh& mesh, std::size_t number,
               const std::vector<Element>& elements, const ThermalCoefficients& coefficients) {
  constexpr int kOnFirstLine = 11;  // a line of the format has room for 16 numbers
  const auto& brick = mesh.classes[number];
  writer.put("** class {}:", number);
  for (const auto& [part, share] : brick.shares) writer.put(" {} {:.6g}", kGyroPartNames[index(part)], share);
  writer.put("\n*ELEMENT,TYPE=DC3D20,ELSET=C{}\n", number);
  for (const auto& element : elements) {
    writer.put("{}", element.number);
    const auto nodes = nodes_of(mesh, element.i, element.j, element.k);
    for (int n = 0; n < 20; ++n) writer.put(",{}{}", n == kOnFirstLine ? "\n" : "", nodes[n] + 1);
    writer.put("\n");
  }
  const double rho = density(model, brick);
  const auto k = conductivity(model, brick, coefficients);
  writer.put("*MATERIAL,NAME=M{}\n", number);
  if (brick.across == std::array<double, 3>{})
    writer.put("*CONDUCTIVITY\n{:.12g}\n", k.xx);
  else  // of the six entries, those that mix z with another are zero
    writer.put("*CONDUCTIVITY,TYPE=ANISO\n{:.12g},{:.12g},{:.12g},{:.12g},0.,0.\n", k.xx, k.yy, k.zz, k.xy);
  writer.put("*DENSITY\n{:.12g}\n*SPECIFIC HEAT\n{:.12g}\n", rho, heat_capacity(model, brick) / rho);
  writer.put("*SOLID SECTION,ELSET=C{0},MATERIAL=M{0}\n", number);
}

/// Watts per m³ of each class that is part of a source.
void put_sources(Writer& writer, const GyroModel& model, const GyroMesh& mesh) {
  constexpr std::array<GyroPart, kThermalInputs - 1> kSourceParts{GyroPart::gain_left, GyroPart::gain_right,
                                                                  GyroPart::preamplifier, GyroPart::ballast_left,
                                                                  GyroPart::ballast_right};
  writer.put("*DFLUX\n");
  for (std::size_t c = 1; c < mesh.classes.size(); ++c) {
    double density_w_per_m3 = 0;
    for (std::size_t s = 0; s < kSourceParts.size(); ++s)
      if (const double share = share_of(mesh.classes[c], kSourceParts[s]); share > 0)
        density_w_per_m3 += model.powers_w[s] * share / volume_of(mesh, kSourceParts[s]);
    if (density_w_per_m3 > 0) writer.put("C{},BF,{:.15g}\n", c, density_w_per_m3);
  }
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
  constexpr std::array<int, kBrickFaces> kFaceName{6, 4, 3, 5, 1, 2};  // of −x, +x, −y, +y, −z, +z
  const double film = options.coefficients[static_cast<std::size_t>(ThermalCoefficient::film)];
  writer.put("*FILM\n");
  for (const auto& face : mesh.film)
    writer.put("{},F{},{},{:.12g}\n", number_of_brick[face.brick], kFaceName[face.face], options.ambient_c,
               film * face.factor);
  writer.put("*NODE PRINT,NSET=NALL\nNT\n*END STEP\n");
}

}  // namespace gyrotherm
