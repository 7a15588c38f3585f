// The tangent of a pair, positive semidefinite: the Hessian of its barrier to the places of its vertices without what
// is negative of it (Li et al. 2020, sec. 4.3), as rows.
//
// The vector between the closest points is r = sum_k w_k x_k, d its length, n its direction; the weights w depend on
// the closest points' parameters t (two at most: along edges), at which r is orthogonal to the edges e_i = sum_k w_k,i
// x_k. By the implicit function theorem the Hessian of d^2/2 is
//   H = w w^T I - sum_ij (w e_i + d w_,i n) G^-1_ij (w e_j + d w_,j n)^T, G_ij = e_i . e_j,
// and that of b(d) is b'' (w n)(w n)^T + b'/d (H - (w n)(w n)^T). All of it lies in the span of five vectors, w times n
// and two tangents, and w_,i n: a matrix of five rows has its eigenvalues.
#pragma once
#include <array>
#include <vector>

#include "force/self_contact/contact_pairs.h"

namespace lappet {

// Rows c, one vector for each vertex of the pair, sqrt(mN/mm): the tangent is the sum of c c^T. The one that weighs
// most first; those that weigh little are left out. places: of the pair's vertices.
using TangentRow = std::array<Vec3, 4>;
std::vector<TangentRow> tangent_rows(const TouchingPair& pair);

}  // namespace lappet
