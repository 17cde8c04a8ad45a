#include "io/csv_table.h"
#include "base/build_info.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>

#include "io/probes_file.h"
#include "io/result_csv.h"
#include "io/text_file.h"
#include "support/temp_folder.h"

using namespace palpate;
using Catch::Contains;

TEST_CASE("A CSV table is read by the names of its columns", "[io][csv]") {
  const TempFolder folder;
  const CsvTable table = readCsvTable(folder.write("t.csv",
                                                   "\xEF\xBB\xBF# from a spreadsheet\r\n\r\ntime_s, \"Points:0\" "
                                                   ",X,x\r\n0,-1.5e-3,+2,7\r\n 1 ,nan,,8\r\n\n# end\n2,\"4\",5,9"));
  CHECK(table.name == std::vector<std::string>{"time_s", "Points:0", "X", "x"});
  CHECK(table.rowCount() == 3);
  CHECK(table.header.line == 3);
  CHECK(table.line == std::vector<int>{4, 5, 8});
  CHECK(table["time_s"] == std::vector<double>{0, 1, 2});
  CHECK(table["Points:0"][0] == -1.5e-3);
  CHECK(std::isnan(table["Points:0"][1]));
  CHECK(table["Points:0"][2] == 4);
  CHECK(std::isnan(table["X"][1]));
  CHECK(table["X"][2] == 5);
  CHECK(table["x"] == std::vector<double>{7, 8, 9});
  CHECK(table.find("TIME_S") == 0);
  CHECK(table.find("time") == -1);
}

TEST_CASE("Tables of other programs and countries are read", "[io][csv]") {
  const TempFolder folder;
  const CsvTable semicolons = readCsvTable(folder.write("t.csv", "depth_mm;force_N\n0,5;1,25e-2\n1.5; 2\n"));
  CHECK(semicolons["depth_mm"] == std::vector<double>{0.5, 1.5});
  CHECK(semicolons["force_N"] == std::vector<double>{0.0125, 2});
  const CsvTable tabs = readCsvTable(folder.write("t.csv", "x\ty\tz\n1\t\t3\n"));
  CHECK(tabs["z"] == std::vector<double>{3});
  CHECK(std::isnan(tabs["y"][0]));
  // Of thousands or of a decimal: nobody knows.
  CHECK_THAT(refusal([&] { readCsvTable(folder.write("t.csv", "x\ty\n1,000\t3\n")); }),
             Contains("\"1,000\" is not a number"));
  CHECK_THAT(refusal([&] { readCsvTable(folder.write("t.csv", "x,y\n\"1,000\",3\n")); }),
             Contains("\"1,000\" is not a number"));
  const CsvTable needed =
      readCsvTable(folder.write("t.csv", "x,what\n1,touch\n"), {}, [](const std::string& name) { return name == "x"; });
  CHECK(needed["x"] == std::vector<double>{1});
  CHECK(std::isnan(needed["what"][0]));
}

TEST_CASE("Bad CSV tables are refused at their place", "[io][csv][refusal]") {
  const TempFolder folder;
  const auto message = [&](const std::string& text) {
    return refusal([&] { readCsvTable(folder.write("t.csv", text)); });
  };
  CHECK_THAT(message(""), Contains("t.csv: an empty file"));
  CHECK_THAT(message("\n# nothing\n"), Contains("t.csv: an empty file"));
  CHECK_THAT(message("X,,Z\n"), Contains("t.csv:1:3: a column without a name"));
  CHECK_THAT(message("X,Y, X\n"), Contains("t.csv:1:6: two columns are named \"X\""));
  CHECK_THAT(message("X,Y\n1,2\n\n3\n"), Contains("t.csv:4: 1 fields, but 2 columns"));
  CHECK_THAT(message("X,Y\n1,2,3\n"), Contains("t.csv:2: 3 fields, but 2 columns"));
  CHECK_THAT(message("X,Y\n1;2\n"), Contains("t.csv:2: 1 fields") && Contains("separate fields as the names are"));
  CHECK_THAT(message("X,Y\n1, two\n"), Contains("t.csv:2:4: \"two\" is not a number") && Contains("column \"Y\""));
  CHECK_THAT(message("X,Y\n1,2m\n"), Contains("t.csv:2:3: \"2m\" is not a number"));
  CHECK_THAT(message("X,Y\n1,inf\n"), Contains("t.csv:2:3:") && Contains("not finite"));
  CHECK_THAT(message("X,Y\n1,1e999\n"), Contains("t.csv:2:3:") && Contains("beyond what a number can hold"));
  CHECK_THAT(message("\xFF\xFEX"), Contains("t.csv: a table in UTF-16") && Contains("UTF-8"));
  CHECK_THAT(message("X\n\x1b[2J\n"), Contains("t.csv:2:1: \"?[2J\""));
  CHECK_THAT(refusal([&] { readCsvTable(folder.path("none.csv")); }), Contains("none.csv: the file does not exist"));
  CHECK_THAT(refusal([&] {
               readCsvTable(folder.path("none.csv"), {"s.toml", 7, 1});
             }),
             Contains("s.toml:7:1: the file ") && Contains("none.csv does not exist"));
  const CsvTable table = readCsvTable(folder.write("t.csv", "\nX,Y\n"));
  CHECK_THAT(refusal([&] { (void)table["depth_m"]; }),
             Contains("t.csv:2: there is no column \"depth_m\"; the file has \"X\", \"Y\""));
}

TEST_CASE("Every reference table is read", "[io][csv]") {
  int count = 0, probes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sourceFolder() + "/tests/reference")) {
    if (entry.path().extension() != ".csv") continue;
    ++count;
    INFO(entry.path());
    const CsvTable table = readCsvTable(entry.path().string());
    CHECK(table.rowCount() > 3);
    for (const auto& column : table.column) CHECK(column.size() == table.rowCount());
    if (entry.path().string().find("probes") == std::string::npos) continue;
    ++probes;
    CHECK(readProbes(entry.path().string()).X.size() == table.rowCount());
  }
  CHECK(count >= 14);
  CHECK(probes >= 6);
  // Numbers as the file has them.
  const CsvTable force = readCsvTable(sourceFolder() + "/tests/reference/gel_cylinder_force.csv");
  CHECK(force["depth_m"][1] == 0.0005);
  CHECK(force["force_N"][1] == 0.015902);
}

TEST_CASE("Probes are the columns X, Y, Z of a CSV file, in any order and case", "[io][csv]") {
  const TempFolder folder;
  const Probes probes = readProbes(folder.write("p.csv", "id,z,ux,y,x\n1,0.3,9,0.2,0.1\n2,6,nan,5,4\n"));
  REQUIRE(probes.X.size() == 2);
  CHECK(probes.X[0] == Vec3(0.1, 0.2, 0.3));
  CHECK(probes.X[1] == Vec3(4, 5, 6));
  CHECK(probes.table["ux"][0] == 9);  // kept, but not a coordinate
  // Positions at rest beside current ones: the exact spelling counts.
  CHECK(readProbes(folder.write("p.csv", "x,y,z,X,Y,Z\n1,2,3,4,5,6\n")).X[0] == Vec3(4, 5, 6));

  const auto message = [&](const std::string& text) {
    return refusal([&] { readProbes(folder.write("p.csv", text)); });
  };
  CHECK_THAT(message("X,Y,ux\n1,2,3\n"),
             Contains("p.csv:1: there is no column \"Z\"; the file has \"X\", \"Y\", \"ux\""));
  CHECK_THAT(message("X,Y,Z\n"), Contains("p.csv:1: no points below the header"));
  CHECK_THAT(message("X,Y,Z\n1,2,3\n1,,3\n"), Contains("p.csv:3: a coordinate is missing"));
  CHECK_THAT(message("X,Y,Z\n1,2,nan\n"), Contains("p.csv:2: a coordinate is missing"));
  CHECK_THAT(refusal([&] {
               readProbes(folder.path("none.csv"), {"s.toml", 3, 1});
             }),
             Contains("s.toml:3:1: the file "));
}

TEST_CASE("A result CSV reads back bit for bit, and each row is there at once", "[io][csv]") {
  const TempFolder folder;
  const std::string path =
      folder.write("force.csv", "what an earlier run left, longer than what follows below ................");
  ResultCsv csv(path, {"time_s", "base x_N"});
  csv.takePlace();
  CHECK(readWholeFile(path) == "time_s,base x_N\n");
  const double third = 1.0 / 3, tiny = std::numeric_limits<double>::denorm_min();
  csv.add(std::vector<double>{0.1, third});
  CHECK(readWholeFile(path) == "time_s,base x_N\n0.1,0.3333333333333333\n");
  csv.add(std::vector<double>{tiny, -std::numeric_limits<double>::max()});
  csv.add(std::vector<double>{2, std::numeric_limits<double>::quiet_NaN()});
  CHECK_THROWS_AS(csv.add(std::vector<double>{1}), std::invalid_argument);
  csv.finish();
  const CsvTable table = readCsvTable(path);
  CHECK(table["time_s"] == std::vector<double>{0.1, tiny, 2});
  CHECK(table["base x_N"][0] == third);
  CHECK(table["base x_N"][1] == -std::numeric_limits<double>::max());
  CHECK(std::isnan(table["base x_N"][2]));
}

TEST_CASE("A result CSV that can't be written says so, with the reason", "[io][csv][refusal]") {
  const TempFolder folder;
  CHECK_THROWS_WITH(ResultCsv(folder.path("none/force.csv"), {"a"}),
                    Contains("none/force.csv: No such file or directory"));
  CHECK_THROWS_WITH(ResultCsv(folder.path(""), {"a"}), Contains("Is a directory"));
  CHECK_THROWS_WITH(ResultCsv("/dev/full", {"a"}), Contains("can't write /dev/full: No space left on device"));
  CHECK_THROWS_AS(ResultCsv(folder.path("f.csv"), {"a,b"}), std::invalid_argument);
}
