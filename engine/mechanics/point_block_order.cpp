#include "mechanics/point_block_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace palpate {
namespace {

constexpr int group_blocks = 16;  // blocks that exchange points with each other
constexpr int max_sweeps = 6;

/// Cost of a union of `size` nodes: what the kernel executes, then the nodes themselves, since a smaller union is
/// nearer
/// to the next whole group.
int costOf(int size) { return (size + 3) / 4 * 64 + size; }

/// The points of a few blocks, with their supports as sets of bits over the nodes that they have in common.
class BlockGroup {
 public:
  /// @param local  (node_count) scratch, all -1; left so
  BlockGroup(const ShapeTable& shape, int* point, int block_count, std::vector<int>& local)
      : point_(point), block_count_(block_count) {
    std::vector<int> nodes;
    const auto each = [&](int k, auto call) {
      for (int e = point_[k] < 0 ? 0 : shape.begin[point_[k]]; e < (point_[k] < 0 ? 0 : shape.begin[point_[k] + 1]);
           ++e)
        call(shape.node[e]);
    };
    for (int k = 0; k < 4 * block_count_; ++k)
      each(k, [&](int node) {
        if (local[node] >= 0) return;
        local[node] = static_cast<int>(nodes.size());
        nodes.push_back(node);
      });
    words_ = (nodes.size() + 63) / 64;
    support_.assign(static_cast<std::size_t>(4 * block_count_) * words_, 0);
    rest_ = support_;
    for (int k = 0; k < 4 * block_count_; ++k)
      each(k, [&](int node) { set(support_, k)[local[node] / 64] |= std::uint64_t{1} << local[node] % 64; });
    for (int node : nodes) local[node] = -1;
    for (int q = 0; q < block_count_; ++q) update(q);
  }

  /// Exchanges points between the blocks until no exchange of two helps.
  void improve() {
    std::array<bool, group_blocks> changed;
    changed.fill(true);
    for (int sweep = 0; sweep < max_sweeps; ++sweep) {
      std::array<bool, group_blocks> now{};
      for (int a = 0; a < block_count_; ++a)
        for (int b = a + 1; b < block_count_; ++b)
          if ((changed[a] || changed[b] || now[a] || now[b]) && exchange(a, b)) now[a] = now[b] = true;
      changed = now;
      if (std::none_of(changed.begin(), changed.end(), [](bool c) { return c; })) break;
    }
  }

 private:
  std::uint64_t* set(std::vector<std::uint64_t>& sets, int k) { return &sets[static_cast<std::size_t>(k) * words_]; }

  /// The unions of each three of a block's points, and its cost.
  void update(int block) {
    int size = 0;
    for (std::size_t w = 0; w < words_; ++w) {
      std::array<std::uint64_t, 4> s;
      for (int k = 0; k < 4; ++k) s[k] = set(support_, 4 * block + k)[w];
      set(rest_, 4 * block)[w] = s[1] | s[2] | s[3];
      set(rest_, 4 * block + 1)[w] = s[0] | s[2] | s[3];
      set(rest_, 4 * block + 2)[w] = s[0] | s[1] | s[3];
      set(rest_, 4 * block + 3)[w] = s[0] | s[1] | s[2];
      size += std::popcount(s[0] | s[1] | s[2] | s[3]);
    }
    cost_[block] = costOf(size);
  }

  /// Cost of the block of `removed` with `added` in its place.
  int costWith(int removed, int added) {
    const std::uint64_t* rest = set(rest_, removed);
    const std::uint64_t* support = set(support_, added);
    int size = 0;
    for (std::size_t w = 0; w < words_; ++w) size += std::popcount(rest[w] | support[w]);
    return costOf(size);
  }

  /// The exchange of two points of blocks a and b that helps most, if one does.
  bool exchange(int a, int b) {
    int least = cost_[a] + cost_[b], from = -1, to = -1;
    for (int i = 4 * a; i < 4 * a + 4; ++i)
      for (int j = 4 * b; j < 4 * b + 4; ++j) {
        const int cost = costWith(i, j) + costWith(j, i);
        if (cost >= least) continue;
        least = cost;
        from = i;
        to = j;
      }
    if (from < 0) return false;
    std::swap(point_[from], point_[to]);
    std::swap_ranges(set(support_, from), set(support_, from) + words_, set(support_, to));
    update(a);
    update(b);
    return true;
  }

  int* point_;
  int block_count_;
  std::size_t words_;
  std::vector<std::uint64_t> support_, rest_;  // (point)(word)
  std::array<int, group_blocks> cost_{};
};

}  // namespace

std::vector<int> pointBlockOrder(const ShapeTable& shape, std::vector<int> order) {
  int node_count = 0;
  for (int node : shape.node) node_count = std::max(node_count, node + 1);
  std::vector<int> local(node_count, -1);
  const int blocks = static_cast<int>(order.size() / 4);
  // The second time with other blocks, across the borders of the first.
  for (int start : {0, group_blocks / 2})
    for (int q = start; q < blocks; q += group_blocks)
      BlockGroup(shape, &order[static_cast<std::size_t>(q) * 4], std::min(group_blocks, blocks - q), local).improve();
  return order;
}

}  // namespace palpate
