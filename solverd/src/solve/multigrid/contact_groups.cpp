#include "solve/multigrid/contact_groups.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

namespace lappet {

namespace {

constexpr double kDependent = 1e-6;  // what is left of a column that the others make up

// Columns in proportion to a push along the mean normal and to two tilts, made orthonormal; zero where there is none.
Eigen::MatrixX3d push_and_tilts(const SparseRows& rows, std::span<const SelfContact::Place> places,
                                std::span<const std::size_t> members) {
  const Vec3 normal = places[members.front()].normal;
  const Vec3 first = normal.unitOrthogonal(), second = normal.cross(first);
  Vec3 center = Vec3::Zero();
  for (const std::size_t row : members) center += places[row].at / static_cast<double>(members.size());
  Eigen::MatrixX3d columns(members.size(), 3);
  for (std::size_t m = 0; m < members.size(); ++m) {
    const std::size_t row = members[m];
    double size = 0.0;
    for (std::uint32_t k = rows.start[row]; k < rows.start[row + 1]; ++k) size += rows.factors[k].norm();
    const Vec3 arm = places[row].at - center;
    columns.row(m) << 1.0, arm.dot(first), arm.dot(second);
    columns.row(m) *= places[row].normal.dot(normal) < 0.0 ? -size : size;
  }
  for (int c = 0; c < 3; ++c) {
    const double before = columns.col(c).norm();
    for (int done = 0; done < c; ++done) columns.col(c) -= columns.col(done).dot(columns.col(c)) * columns.col(done);
    const double left = columns.col(c).norm();
    if (left > kDependent * before)
      columns.col(c) /= left;
    else
      columns.col(c).setZero();
  }
  return columns;
}

}  // namespace

std::vector<ContactGroup> group_contacts(const SparseRows& rows, std::span<const SelfContact::Place> places,
                                         std::span<const Index> coarse_of) {
  std::map<std::pair<Index, Index>, std::vector<std::size_t>> members;
  for (std::size_t row = 0; row < places.size(); ++row) {
    if (rows.start[row] == rows.start[row + 1]) continue;
    const auto coarse = [&](Index cell) { return cell < 0 ? -1 : coarse_of[cell]; };  // what does not move has none
    const Index a = coarse(places[row].cell), b = coarse(places[row].other_cell);
    members[{std::min(a, b), std::max(a, b)}].push_back(row);
  }
  std::vector<ContactGroup> result;
  for (const auto& [cells, of_group] : members) {
    const Eigen::MatrixX3d columns = push_and_tilts(rows, places, of_group);
    ContactGroup& group = result.emplace_back();
    for (std::size_t m = 0; m < of_group.size(); ++m)
      for (std::uint32_t k = rows.start[of_group[m]]; k < rows.start[of_group[m] + 1]; ++k)
        group.try_emplace(rows.nodes[k], Eigen::Matrix3d::Zero()).first->second +=
            columns.row(m).transpose() * rows.factors[k].transpose();
  }
  return result;
}

}  // namespace lappet
