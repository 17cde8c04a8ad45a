#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "approximation/neighbours.h"
#include "approximation/shape_table.h"

namespace palpate {

/// Rows of shape functions that were found before, on a cloud that has many nodes in common with the next one. A row
/// follows from its point and from the nodes whose supports hold the point (their places, radii and groups) alone:
/// where these are the same, to the bit, the row is, and it is copied. No bit of the result depends on what was known.
/// Of rows with values alone: gradients would take half of the memory, and spare a fortieth of the time.
struct KnownRows {
  std::vector<int> number;           // (node_count) of each node among those of all clouds, ascending
  std::vector<Vec3> X;               // (node_count) m
  std::vector<double> radius;        // (node_count) m
  std::vector<std::uint64_t> group;  // (node_count) SupportGroups::node, or empty

  /// Of one kind of points.
  struct Part {
    std::vector<Vec3> at;              // (row_count) m
    std::vector<std::uint64_t> group;  // (row_count) SupportGroups::row, or empty
    ShapeTable rows;
    std::unordered_map<std::uint64_t, int> row;  // by a hash of `at`: the first of them

    Part() = default;
    Part(const std::vector<Vec3>& at, const std::vector<std::uint64_t>& group, const ShapeTable& rows);
    int find(const Vec3& x) const;  // row, or -1
  };
  std::array<Part, 4> part;
};

/// The known rows that hold for another cloud, too.
class RowsAtHand {
 public:
  /// All must outlive this. @param number  of the nodes of this cloud, ascending
  RowsAtHand(const KnownRows& known, const std::vector<int>& number, const std::vector<Vec3>& X,
             const std::vector<double>& radius, const std::vector<std::uint64_t>& group);

  /// Copies the row of a point of a part, its nodes by their place in this cloud. False: it is not known. Any thread.
  bool copy(std::size_t part, const Vec3& at, std::uint64_t group, std::vector<int>& node,
            std::vector<double>& N) const;

 private:
  /// Nodes of this cloud that the known one has not, or with another place, radius or group.
  struct Changed {
    std::vector<Vec3> X;
    std::vector<double> radius;
  };
  static Changed compare(const KnownRows& known, const std::vector<int>& number, const std::vector<Vec3>& X,
                         const std::vector<double>& radius, const std::vector<std::uint64_t>& group,
                         std::vector<int>& now);

  const KnownRows& known_;
  std::vector<int> now_;  // (known node_count) place of each node in this cloud, -1: it is not there as it was
  const Changed changed_;
  const Neighbours near_;  // of the changed
};

}  // namespace palpate
