#include "approximation/node_entries.h"

namespace palpate {

NodeEntries nodeEntries(const ShapeTable& shape, std::size_t node_count) {
  NodeEntries of;
  of.begin.assign(node_count + 1, 0);
  for (const int i : shape.node) ++of.begin[i + 1];
  for (std::size_t i = 0; i < node_count; ++i) of.begin[i + 1] += of.begin[i];
  of.entry.resize(shape.node.size());
  of.point.resize(shape.node.size());
  std::vector<int> next(of.begin.begin(), of.begin.end() - 1);
  for (int q = 0; q < shape.rowCount(); ++q)
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) {
      const int k = next[shape.node[e]]++;
      of.entry[k] = e;
      of.point[k] = q;
    }
  return of;
}

}  // namespace palpate
