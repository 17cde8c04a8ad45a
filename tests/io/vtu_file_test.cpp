#include "io/vtu_file.h"
#include "base/build_info.h"

#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "io/output_file.h"
#include "io/text_file.h"
#include "support/temp_folder.h"

using namespace palpate;
using Catch::Contains;
using nlohmann::json;

namespace {

/// The file as an independent reader sees it.
json readBack(const std::string& path) {
  // Debian's Python: another one would not see Debian's packages.
  const std::string command = "/usr/bin/python3 '" + sourceFolder() + "/tests/io/read_vtu.py' '" + path + "' 2>&1";
  std::string output;
  FILE* pipe = ::popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) output.append(buffer, n);
  const int status = ::pclose(pipe);
  INFO("the reader said: " << output.substr(0, 2000));
  INFO("if Python or meshio is missing, tools/setup installs it");
  REQUIRE(status == 0);
  return json::parse(output);
}

/// Limits the size of files that this process writes, as a full disk would.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

const std::vector<Vec3> points = {{0, 0, 0}, {0.1, 0, 0}, {0, 1.0 / 3, 0}, {0, 0, -1e-300}, {1, 1, 1}};
const std::vector<std::array<int, 4>> cells = {{0, 1, 2, 3}, {4, 2, 1, 3}};

int fileCount(const TempFolder& folder) {
  const std::filesystem::directory_iterator files(folder.path(""));
  return static_cast<int>(std::distance(begin(files), end(files)));
}

}  // namespace

TEST_CASE("An independent reader finds points, tetrahedra and fields of a VTU file bit for bit", "[io][vtu]") {
  const TempFolder folder;
  const std::vector<Vec3> u = {{1, 2, 3}, {4, 5, 6}, {0.1, -0.2, 0.3}, {1e-12, 0, 0}, {7, 8, 9}};
  const std::vector<float> pressure = {0, -1.5F, 3.25e7F, 0.1F, 1e-30F};
  const std::vector<int> region = {3, -7};
  const std::vector<double> stress = {1, 2, 3, 4, 5, 6, 7, 8, 9, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
  const std::vector<VtuField> at_points = {vtuVectors("u_m", u), {"p < \"0\" & p > 1", std::span(pressure)}};
  const std::vector<VtuField> in_cells = {{"region", std::span(region)}, {"P_Pa", std::span(stress), 9}};
  const std::string path = folder.path("frame 1.vtu");
  writeVtu(path, points, cells, at_points, in_cells);
  const json read = readBack(path);

  REQUIRE(read["points"].size() == points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int k = 0; k < 3; ++k) CHECK(read["points"][i][static_cast<std::size_t>(k)].get<double>() == points[i][k]);
  }
  CHECK(read["cells"] == json::array({json::array({"tetra", cells})}));
  CHECK(read["point_data"].size() == 2);
  CHECK(read["point_data"]["u_m"][0] == "float64");
  for (std::size_t i = 0; i < u.size(); ++i) {
    CHECK(read["point_data"]["u_m"][1][i] == json(std::array{u[i].x(), u[i].y(), u[i].z()}));
  }
  const json p = read["point_data"]["p < \"0\" & p > 1"];
  CHECK(p[0] == "float32");
  CHECK(p[1].get<std::vector<float>>() == pressure);
  CHECK(read["cell_data"]["region"] == json::array({"int32", region}));
  CHECK(read["cell_data"]["P_Pa"][1][1][8] == 0.9);
  CHECK(read["cell_data"]["P_Pa"][1][0].get<std::vector<double>>() ==
        std::vector<double>(stress.begin(), stress.begin() + 9));
  CHECK(fileCount(folder) == 1);
}

TEST_CASE("VTU arrays of every length modulo base64's three bytes, and bare points, read back", "[io][vtu]") {
  const TempFolder folder;
  std::mt19937 random(3);
  for (std::size_t count : {1U, 2U, 3U, 1000U}) {
    std::vector<Vec3> X(count);
    std::vector<float> s(count);
    for (std::size_t i = 0; i < count; ++i) {
      s[i] = static_cast<float>(random());
      for (int k = 0; k < 3; ++k) X[i][k] = static_cast<double>(random()) / 7;
    }
    const VtuField field{"s", std::span<const float>(s)};
    writeVtu(folder.path("a.vtu"), X, {}, {&field, 1});
    const json read = readBack(folder.path("a.vtu"));
    CHECK(read["point_data"]["s"][1].get<std::vector<float>>() == s);
    CHECK(read["points"][count - 1][2].get<double>() == X[count - 1].z());
    CHECK(read["cells"][0][0] == "vertex");
    CHECK(read["cells"][0][1].size() == count);
  }
}

TEST_CASE("A PVD file lists times and files", "[io][vtu]") {
  const TempFolder folder;
  const std::vector<PvdFrame> frames = {{0, "a & b.vtu"}, {1.0 / 3, "frames/1.vtu"}};
  writePvd(folder.path("run.pvd"), frames);
  CHECK(readBack(folder.path("run.pvd")) ==
        json::array({json::array({0.0, "a & b.vtu"}), json::array({1.0 / 3, "frames/1.vtu"})}));
}

TEST_CASE("Fields and cells that do not fit are refused before anything is written", "[io][vtu][refusal]") {
  const TempFolder folder;
  const std::vector<double> four(4);
  const VtuField field{"s", std::span(four)};
  const std::string path = folder.path("a.vtu");
  CHECK_THROWS_WITH(writeVtu(path, points, cells, {&field, 1}),
                    Contains("the field s has 4 values, not 1 for each of 5"));
  CHECK_THROWS_AS(writeVtu(path, points, cells, {}, {&field, 1}), std::invalid_argument);
  const std::vector<std::array<int, 4>> beyond = {{0, 1, 2, 5}};
  CHECK_THROWS_WITH(writeVtu(path, points, beyond, {}), Contains("a cell names point 5 of 5"));
  CHECK(fileCount(folder) == 0);
}

TEST_CASE("Results that can't be written say so, with the reason, and leave what was there", "[io][vtu][refusal]") {
  const TempFolder folder;
  CHECK_THROWS_WITH(writeVtu(folder.path("none/a.vtu"), points, cells, {}),
                    Contains("can't write") && Contains("none/a.vtu: No such file or directory"));
  const std::string path = folder.write("a.vtu", "an earlier result");
  CHECK_THROWS_WITH(writeVtu(path + "/b.vtu", points, cells, {}), Contains("a.vtu/b.vtu: Not a directory"));
  std::filesystem::create_directory(folder.path("folder.vtu"));
  CHECK_THROWS_WITH(writeVtu(folder.path("folder.vtu"), points, cells, {}), Contains("folder.vtu: Is a directory"));

  std::string message;
  {
    const FullDisk full(500);  // bytes; the file needs more
    try {
      writeVtu(path, points, cells, {});
    } catch (const std::runtime_error& error) {
      message = error.what();
    }
  }
  CHECK_THAT(message, Contains(path + ": File too large"));
  CHECK(readWholeFile(path) == "an earlier result");
  CHECK(fileCount(folder) == 2);  // no half-written rest

  writeVtu(path, points, cells, {});
  CHECK(readBack(path)["points"].size() == points.size());
}
