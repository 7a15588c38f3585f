// The tangent of a pair, positive semidefinite, as rows.
//
// The vector between the closest points is r = sum_k w_k x_k, d its length, n its direction; the weights w depend on
// the closest points' parameters t (two at most: along edges), at which r is orthogonal to the edges e_i = sum_k w_k,i
// x_k. By the implicit function theorem the Hessian of d^2/2 is
//   H = w w^T I - sum_ij (w e_i + d w_,i n) G^-1_ij (w e_j + d w_,j n)^T, G_ij = e_i . e_j,
// and that of b(d) is b'' (w n)(w n)^T + b'/d (H - (w n)(w n)^T). Of these b'' (w n)(w n)^T and, as b' < 0, the part
// -b' d sum_ij G^-1_ij (w_,i n)(w_,j n)^T are never negative: surfaces that press on each other and tilt. What couples
// tilting with sliding is indefinite,
//   -b' sum_ij G^-1_ij ((w e_i)(w_,j n)^T + (w_,j n)(w e_i)^T).
// The definite tangent has the positive eigenvalues of both together, the exact one the negative ones too, and the
// pairs that count negatively (contact_pairs.h). Without the coupling the tangent of a flap that slides along a bent
// wall is half of what it should be, and Newton's method steps to and fro about the equilibrium. Sliding around an edge
// or a corner, which is never positive, is left out of both.
#pragma once
#include <array>
#include <vector>

#include "force/self_contact/contact_pairs.h"

namespace lappet {

// Rows c, one vector for each vertex of the pair, sqrt(mN/mm): the definite tangent is the sum of c c^T. That of the
// distance first.
using TangentRow = std::array<Vec3, 4>;
std::vector<TangentRow> definite_rows(const TouchingPair& pair);
// By the sum of c c^T of these the exact tangent is less.
std::vector<TangentRow> negative_rows(const TouchingPair& pair);

}  // namespace lappet
