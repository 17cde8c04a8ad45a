#include "io/npz_file.h"

#include <catch2/catch.hpp>
#include <cstring>

#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;

TEST_CASE("An npz file has numpy's header and the numbers, stored", "[io][npz]") {
  const TempFolder folder;
  const std::vector<Vec3> points{{1, 2, 3}, {-0.5, 0, 1e-3}};
  const std::vector<std::array<int, 4>> cells{{0, 1, 2, -3}};
  const std::string path = folder.path("a.npz");
  writeNpz(path, std::vector<NpzArray>{npzVectors("X", points), npzCells("cells", cells)});
  const std::string bytes = readAll(path);
  CHECK(bytes.starts_with("PK\x03\x04"));
  const std::size_t begin = bytes.find("\x93NUMPY");
  CHECK(begin == 30 + std::string("X.npy").size());
  const std::string head = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }";
  CHECK(bytes.substr(begin + 10, head.size()) == head);
  const std::size_t data = bytes.find('\n', begin) + 1;
  CHECK((data - begin) % 64 == 0);
  double numbers[6];
  std::memcpy(numbers, bytes.data() + data, sizeof numbers);
  CHECK(numbers[1] == 2);
  CHECK(numbers[5] == 1e-3);
  int nodes[4];
  std::memcpy(nodes, bytes.data() + bytes.find('\n', bytes.find("<i4")) + 1, sizeof nodes);
  CHECK(nodes[3] == -3);
  writeNpz(folder.path("b.npz"), std::vector<NpzArray>{npzVectors("X", points), npzCells("cells", cells)});
  CHECK(readAll(folder.path("b.npz")) == bytes);
}
