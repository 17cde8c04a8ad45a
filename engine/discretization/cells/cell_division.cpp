#include "discretization/cells/cell_division.h"

namespace palpate {
namespace {

void divideInTwo(const Corners& c, std::array<Corners, 8>& children) {
  int p = 0, q = 1;
  double longest = -1;
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      const double length2 = (c[i] - c[j]).squaredNorm();
      if (length2 > longest) {
        longest = length2;
        p = i;
        q = j;
      }
    }
  }
  const Vec3 middle = (c[p] + c[q]) / 2;
  children[0] = children[1] = c;
  children[0][q] = middle;
  children[1][p] = middle;
}

void divideInFour(const Corners& c, int depth, std::array<Corners, 8>& children) {
  const int apex = 3 - depth % 4;
  const int i = (apex + 1) % 4, j = (apex + 2) % 4, k = (apex + 3) % 4;
  const Vec3 ij = (c[i] + c[j]) / 2, jk = (c[j] + c[k]) / 2, ki = (c[k] + c[i]) / 2;
  // A corner that stays keeps its place in the order, so that its turn comes.
  for (int child = 0; child < 4; ++child) children[child] = c;
  children[0][j] = ij, children[0][k] = ki;
  children[1][i] = ij, children[1][k] = jk;
  children[2][i] = ki, children[2][j] = jk;
  children[3][i] = jk, children[3][j] = ki, children[3][k] = ij;
}

void divideInEight(const Corners& c, std::array<Corners, 8>& children) {
  const auto middle = [&](int i, int j) -> Vec3 { return (c[i] + c[j]) / 2; };
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) children[i][j] = i == j ? c[i] : middle(i, j);
  }
  // The octahedron's diagonals join midpoints of opposite edges, (i, j) and (k, l).
  constexpr int pairs[3][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}};
  int shortest = 0;
  double least = (middle(0, 1) - middle(2, 3)).squaredNorm();
  for (int d = 1; d < 3; ++d) {
    const double length2 = (middle(pairs[d][0], pairs[d][1]) - middle(pairs[d][2], pairs[d][3])).squaredNorm();
    if (length2 < least) {
      least = length2;
      shortest = d;
    }
  }
  const auto [i, j, k, l] = pairs[shortest];
  const Vec3 ring[4] = {middle(i, k), middle(i, l), middle(j, l), middle(j, k)};
  for (int r = 0; r < 4; ++r) children[4 + r] = {middle(i, j), middle(k, l), ring[r], ring[(r + 1) % 4]};
}

}  // namespace

void divideCell(const Corners& corners, int division, int depth, std::array<Corners, 8>& children) {
  if (division == 2) {
    divideInTwo(corners, children);
  } else if (division == 4) {
    divideInFour(corners, depth, children);
  } else {
    divideInEight(corners, children);
  }
}

}  // namespace palpate
