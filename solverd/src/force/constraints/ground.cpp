#include "force/constraints/ground.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

namespace lappet {

namespace {

// The field's nodes are as far apart as the lattice's: an underside has no finer shape that the tissue could follow,
// and one of the radius R is off by h^2 / 4R. It knows heights down to a depth in spacings, in mm at least.
constexpr double kDepth = 3.0, kMinDepth = 3.0;
// The far side of the body must be farther from any point that deep than the sheet is.
constexpr double kThickness = 2.1;

double depth_for(double spacing) { return std::max(kDepth * spacing, kMinDepth); }

// The sheet with a rim of a width in its own plane, so that its edge is no edge of the ground.
Surface widened(const Surface& sheet, double width) {
  std::map<std::pair<Index, Index>, Vec3> sides;  // of each edge, in its direction: outwards
  for (const auto& corners : sheet.triangles) {
    const Vec3 a = sheet.points[corners[0]];
    const Vec3 normal = (sheet.points[corners[1]] - a).cross(sheet.points[corners[2]] - a);
    for (std::size_t k = 0; k < 3; ++k) {
      const Index from = corners[k], to = corners[(k + 1) % 3];
      sides[{from, to}] = (sheet.points[to] - sheet.points[from]).cross(normal).normalized();
    }
  }
  Surface result = sheet;
  std::map<Index, std::pair<Vec3, Index>> rim;  // per point of the edge: outwards, and the rim's point
  for (const auto& [edge, outwards] : sides)
    if (!sides.contains({edge.second, edge.first}))
      for (const Index p : {edge.first, edge.second})
        rim.try_emplace(p, Vec3::Zero(), Index(-1)).first->second.first += outwards;
  for (auto& [p, place] : rim) {
    // Along the corner's middle, so far that both of its edges move by the width, up to twice that.
    const double share = std::max(0.5 * place.first.norm(), 0.5);
    place.second = to_index(result.points.size());
    result.points.push_back(sheet.points[p] + width / share * place.first.normalized());
  }
  for (const auto& [edge, outwards] : sides) {
    const auto& [from, to] = edge;
    if (sides.contains({to, from})) continue;
    result.triangles.push_back({to, from, rim.at(from).second});
    result.triangles.push_back({to, rim.at(from).second, rim.at(to).second});
  }
  return result;
}

}  // namespace

Surface body_below(const Surface& sheet, double thickness) {
  std::vector<Vec3> normals(sheet.points.size(), Vec3::Zero());
  std::map<std::pair<Index, Index>, int> sides;  // of each edge, in its direction
  for (const auto& corners : sheet.triangles) {
    const auto& [a, b, c] = corners;
    const Vec3 normal = (sheet.points[b] - sheet.points[a]).cross(sheet.points[c] - sheet.points[a]);
    for (std::size_t k = 0; k < 3; ++k) {
      normals[corners[k]] += normal;
      ++sides[{corners[k], corners[(k + 1) % 3]}];
    }
  }
  Surface body = sheet;
  const Index count = to_index(sheet.points.size());
  for (std::size_t p = 0; p < sheet.points.size(); ++p)
    body.points.push_back(sheet.points[p] + thickness * normals[p].normalized());
  // The sheet's normals point into the body: its own copy is turned around, the far side is as it was.
  for (auto& corners : body.triangles) std::swap(corners[1], corners[2]);
  for (const auto& [a, b, c] : sheet.triangles) body.triangles.push_back({a + count, b + count, c + count});
  for (const auto& [edge, times] : sides) {
    const auto& [from, to] = edge;
    const auto back = sides.find({to, from});
    for (int k = back == sides.end() ? 0 : back->second; k < times; ++k) {
      body.triangles.push_back({from, to, to + count});
      body.triangles.push_back({from, to + count, from + count});
    }
  }
  return body;
}

Ground::Ground(const Surface& sheet, double spacing, std::size_t memory_budget, const Interrupt& interrupt)
    : distance_(body_below(widened(sheet, depth_for(spacing)), kThickness * depth_for(spacing)), spacing,
                depth_for(spacing), memory_budget, interrupt) {}

}  // namespace lappet
