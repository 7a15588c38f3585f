// A sheet of cells with a Z-shaped cut through its thickness, made without a surface: borders fixed, sutures across the
// central limb.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include "force/constraints/attachments.h"
#include "force/constraints/point_constraint.h"
#include "force/materials/material_parameters.h"
#include "lattice/lattice.h"

namespace lappet {

struct CutSheet {
  Lattice lattice;
  Attachments attachments;
  std::vector<PointConstraint> constraints;
};

// nx x ny x nz cells of edge 1 mm. The Z: a central limb along y of 2 half_limb faces at the middle of x, and from its
// ends a limb of half_limb faces to either side; half_limb 0: no cut. Sutures join nodes half_limb / 2 apart across the
// central limb, on top, every other node; `stiffness` in mN/mm.
inline CutSheet make_cut_sheet(int nx, int ny, int nz, int half_limb, double stiffness) {
  CutSheet sheet;
  Lattice& lattice = sheet.lattice;
  const int cx = nx / 2, cy = ny / 2, s = half_limb;
  const auto is_cut = [&](int axis, int i, int j) {
    if (axis == 0) return i == cx - 1 && j >= cy - s && j < cy + s;
    if (axis == 1) return (j == cy + s - 1 && i >= cx && i < cx + s) || (j == cy - s - 1 && i >= cx - s && i < cx);
    return false;
  };
  const auto cell = [&](int i, int j, int k) { return static_cast<std::size_t>((i * ny + j) * nz + k); };
  const std::size_t cells = cell(nx - 1, ny - 1, nz - 1) + 1;
  std::vector<std::size_t> root(8 * cells);
  std::vector<GridPoint> position;
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t a) {
    while (root[a] != a) a = root[a] = root[root[a]];
    return a;
  };
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int k = 0; k < nz; ++k) {
        position.push_back({i, j, k});
        const std::array<int, 3> next[3] = {{i + 1, j, k}, {i, j + 1, k}, {i, j, k + 1}};
        for (int axis = 0; axis < 3; ++axis) {
          if (next[axis][0] >= nx || next[axis][1] >= ny || next[axis][2] >= nz || is_cut(axis, i, j)) continue;
          const std::size_t a = cell(i, j, k), b = cell(next[axis][0], next[axis][1], next[axis][2]);
          const std::size_t bit = std::size_t{4} >> axis;
          for (std::size_t c = 0; c < 8; ++c)
            if (c & bit) {
              const std::size_t p = find(8 * a + c), q = find(8 * b + (c & ~bit));
              root[std::max(p, q)] = std::min(p, q);
            }
        }
      }
  lattice.cell_nodes.resize(cells);
  lattice.cell_fill.assign(cells, 1.0f);
  std::vector<std::int32_t> number(8 * cells, -1);
  for (std::size_t c = 0; c < cells; ++c)
    for (std::size_t k = 0; k < 8; ++k) {
      auto& id = number[find(8 * c + k)];
      if (id < 0) {
        id = to_index(lattice.node_rest.size());
        const auto& p = position[c];
        lattice.node_rest.push_back({p[0] + int(k >> 2 & 1), p[1] + int(k >> 1 & 1), p[2] + int(k & 1)});
      }
      lattice.cell_nodes[c][k] = id;
    }
  for (const Vec3& p : lattice.node_rest) {
    const bool border = p[0] == 0 || p[0] == nx || p[1] == 0 || p[1] == ny;
    sheet.attachments.node_group.push_back(border ? kFixedGroup : kFree);
  }
  for (int j = std::max(cy - s + 1, 0); j < std::min(cy + s - 1, ny); j += 2) {
    const int other = std::min({j + s / 2, cy + s - 1, ny - 1});
    // corner (1, 0, 1) of the cell left of the limb, corner (0, 0, 1) of the cell right of it
    const std::int32_t left = lattice.cell_nodes[cell(cx - 1, j, nz - 1)][5],
                       right = lattice.cell_nodes[cell(cx, other, nz - 1)][1];
    PointConstraint constraint;
    constraint.pieces = {{{left, right}, {1.0, -1.0}, lattice.node_rest[left] - lattice.node_rest[right]}};
    constraint.stiffness = stiffness;
    constraint.exact = true;
    constraint.id = {ConstraintId::Kind::kSuture, static_cast<std::int32_t>(sheet.constraints.size())};
    sheet.constraints.push_back(constraint);
  }
  return sheet;
}

// A thread that slides back and forth through the nodes which the sutures of a sheet join, drawn to half its length.
inline PointConstraint running_thread(const CutSheet& sheet, double stiffness) {
  PointConstraint thread;
  thread.id = {ConstraintId::Kind::kSuture, static_cast<std::int32_t>(sheet.constraints.size())};
  thread.stiffness = stiffness;
  thread.thread = Thread{};
  Index before = -1;
  for (const PointConstraint& suture : sheet.constraints)
    for (const Index node : suture.pieces[0].nodes) {
      if (before >= 0) {
        const Vec3 apart = sheet.lattice.node_rest[before] - sheet.lattice.node_rest[node];
        thread.pieces.push_back({{before, node}, {1.0, -1.0}, apart});
        thread.thread->length += 0.5 * apart.norm();
      }
      before = node;
    }
  return thread;
}

}  // namespace lappet
