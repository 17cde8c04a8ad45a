#include "io/point_file.h"

#include <catch2/catch.hpp>

#include "support/temp_folder.h"

using namespace palpate;
using Catch::Matchers::Contains;

TEST_CASE("Points of a CSV file come with their unit and frame", "[io][points]") {
  TempFolder folder;
  const std::string file = folder.write("e.csv", "x0,y0,z0,x,y,z\n10,20,30,11,20,28\n-5,0,1,-5,0,0\n");
  const PointLoad ras = readPoints(file, 1e-3, Frame::Ras);
  REQUIRE(ras.after.size() == 2);
  CHECK((ras.before[0] - Vec3(0.01, 0.02, 0.03)).norm() < 1e-15);
  CHECK((ras.after[1] - Vec3(-0.005, 0, 0)).norm() < 1e-15);
  CHECK(ras.line[1] == 3);
  const PointLoad lps = readPoints(file, 1e-2, Frame::Lps);
  CHECK((lps.after[0] - Vec3(-0.11, -0.2, 0.28)).norm() < 1e-15);
  CHECK(readPoints(folder.write("a.csv", "name,x,y,z\n1,2,3,4\n"), 1.0, Frame::Ras).before.empty());
}

TEST_CASE("Points that don't say where they are are refused", "[io][points]") {
  TempFolder folder;
  const std::string file = folder.write("e.csv", "x,y,z\n1,2,3\n");
  CHECK_THAT(refusal([&] { readPoints(file, 1e-3, {}); }), Contains("frame"));
  CHECK_THAT(refusal([&] { readPoints(file, {}, Frame::Ras); }), Contains("unit"));
  CHECK_THAT(refusal([&] { readPoints(folder.write("f.csv", "x,y\n1,2\n"), 1e-3, Frame::Ras); }), Contains("z"));
  CHECK_THAT(refusal([&] { readPoints(folder.write("g.csv", "x,y,z\n1,,3\n"), 1e-3, Frame::Ras); }),
             Contains("g.csv:2"));
  CHECK_THAT(refusal([&] { readPoints(folder.write("h.csv", "x,y,z\n"), 1e-3, Frame::Ras); }), Contains("no points"));
}

TEST_CASE("Files of 3D Slicer say their frame", "[io][points]") {
  TempFolder folder;
  const std::string fcsv = folder.write("f.fcsv",
                                        "# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n"
                                        "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
                                        "1,10,20,30,0,0,0,1,1,1,0,F-1,,\n");
  CHECK((readPoints(fcsv, {}, {}).after[0] - Vec3(-0.01, -0.02, 0.03)).norm() < 1e-15);
  CHECK_THAT(refusal([&] { readPoints(fcsv, {}, Frame::Ras); }), Contains("lps"));
  CHECK_THAT(refusal([&] { readPoints(fcsv, 1.0, {}); }), Contains("mm"));
  const std::string old = folder.write("o.fcsv", "# CoordinateSystem = 0\n# columns = id,x,y,z\na,1,2,3\n");
  CHECK((readPoints(old, {}, {}).after[0] - Vec3(0.001, 0.002, 0.003)).norm() < 1e-15);
  CHECK_THAT(refusal([&] { readPoints(folder.write("b.fcsv", "# CoordinateSystem = RAS\n1,2,x,3\n"), {}, {}); }),
             Contains("b.fcsv:2"));
  CHECK_THAT(refusal([&] { readPoints(folder.write("c.fcsv", "# CoordinateSystem = IJK\n"), {}, {}); }),
             Contains("IJK"));

  const std::string markups = folder.write(
      "m.mrk.json", R"({"markups": [{"type": "Fiducial", "coordinateSystem": "RAS", "coordinateUnits": "mm",
                        "controlPoints": [{"id": "1", "position": [1, 2, 3]}, {"position": [4.5, 5, 6]}]}]})");
  REQUIRE(readPoints(markups, {}, {}).after.size() == 2);
  CHECK((readPoints(markups, {}, {}).after[1] - Vec3(0.0045, 0.005, 0.006)).norm() < 1e-15);
  CHECK_THAT(refusal([&] { readPoints(folder.write("n.mrk.json", "{}"), {}, {}); }), Contains("markups"));
}
