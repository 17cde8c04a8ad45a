#include "mtled/report/report_page.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/build_info.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::tools;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

Report sampleReport() {
  CaseResult gel;
  gel.name = "gel_cylinder";
  gel.title = "Compressed gel cylinder";
  gel.reference = "Finite elements, 1.0 mm mesh; tests/reference/gel_cylinder_force.csv";
  gel.text = "A cylinder of gel, 17 mm high, is pressed together by a fifth between rough plates.";
  gel.tables.push_back({"Reaction by spacing",
                        {"Spacing", "Nodes", "Reaction", "Error"},
                        {{"3.40 mm", "412", "1.31 N", "+2.50 %"}, {"1.70 mm", "2711", "1.29 N", "+0.80 %"}},
                        "At full compression."});
  gel.bounds.push_back({"Reaction, relative error", 0.8, 3, true, "%", "the paper's own"});
  gel.bounds.push_back({"Largest distance to the reference", 41e-6, 50e-6, true, "m", ""});
  gel.bounds.push_back({"Order of convergence", 1.9, 1.5, false, "", ""});
  gel.figures.push_back({"gel_cylinder_force.png", "Reaction over compression [measured | computed]"});
  gel.seconds = 12.34;
  CaseResult box;
  box.name = "box";
  box.title = "Extended box";
  box.bounds.push_back({"Error at the probes", 0.002, 0.001, true, "m", ""});
  return {"Verification", "What is held to what.", "mtled verify --report out", buildInfo(), {gel, box}};
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("Numbers have three digits and a fitting prefix", "[report]") {
  CHECK(formatted(0.0012345, "m") == "1.23 mm");
  CHECK(formatted(4.1e-5, "m") == "41.0 \u00b5m");
  CHECK(formatted(45600, "Pa") == "45.6 kPa");
  CHECK(formatted(1, "N") == "1.00 N");
  CHECK(formatted(0.9996, "N") == "1.00 N");  // rounds over a power of a thousand
  CHECK(formatted(0.0009996, "s") == "1.00 ms");
  CHECK(formatted(999.6, "Pa") == "1.00 kPa");
  CHECK(formatted(1e-15, "m") == "1.00e-15 m");  // below the prefixes
  CHECK(formatted(-0.012, "m") == "-12.0 mm");
  CHECK(formatted(12.345, "%") == "12.3 %");
  CHECK(formatted(0.00098765) == "9.88e-04");
  CHECK(formatted(0.001) == "0.00100");
  CHECK(formatted(1234) == "1230");
  CHECK(formatted(99999) == "1.00e+05");
  CHECK(formatted(0, "m") == "0 m");
  CHECK(formatted(not_a_number, "m") == "NaN m");
  CHECK(formatted(-inf) == "-inf");
  CHECK(formattedSigned(0.25, "%") == "+0.250 %");
  CHECK(formattedSigned(-0.25, "%") == "-0.250 %");
  CHECK(formattedPercent(0.0123) == "1.23 %");
}

TEST_CASE("A bound is held at its limit and not beyond - NaN never holds", "[report]") {
  CHECK((Bound{"", 1, 1, true, "", ""}).held());
  CHECK((Bound{"", 1, 1, false, "", ""}).held());
  CHECK_FALSE((Bound{"", 1.001, 1, true, "", ""}).held());
  CHECK_FALSE((Bound{"", 0.999, 1, false, "", ""}).held());
  for (const bool at_most : {true, false}) {
    CHECK_FALSE((Bound{"", not_a_number, 1, at_most, "", ""}).held());
    CHECK_FALSE((Bound{"", 1, not_a_number, at_most, "", ""}).held());
  }
  CHECK_FALSE((Bound{"", inf, 1, true, "", ""}).held());
  CHECK((Bound{"", 0.5, 2, true, "", ""}).use() == 0.25);
  CHECK((Bound{"", 2, 0.5, false, "", ""}).use() == 0.25);
  CHECK((Bound{"", not_a_number, 2, true, "", ""}).use() == inf);
}

TEST_CASE("A case holds when all its bounds do, and not without any", "[report]") {
  const Report report = sampleReport();
  CHECK(report.cases[0].held());
  CHECK_FALSE(report.cases[1].held());
  CHECK_FALSE(report.held());
  CHECK_FALSE(CaseResult().held());
  CHECK_FALSE(Report().held());
  Report whole = report;
  whole.cases.pop_back();
  CHECK(whole.held());
  whole.missing = 1;
  CHECK_FALSE(whole.held());
  CHECK(contains(markdownOf(whole), "1 of 1 case is held; 3 of 3 bounds. The run was ended before its last 1 case."));
  CHECK(CaseResult().worstBound() == nullptr);
  CHECK(report.cases[0].worstBound()->quantity == "Largest distance to the reference");  // 82 % of its limit
  CaseResult one = report.cases[0];
  one.bounds[2].value = not_a_number;
  CHECK_FALSE(one.held());
  CHECK(one.worstBound()->quantity == "Order of convergence");
}

TEST_CASE("A case prints as aligned text with a verdict per bound", "[report]") {
  std::ostringstream out;
  const Report report = sampleReport();
  for (const CaseResult& one : report.cases) printCase(out, one);
  const std::string text = out.str();
  INFO(text);
  CHECK(contains(text, "Spacing  Nodes  Reaction    Error\n"));
  CHECK(contains(text, "3.40 mm    412    1.31 N  +2.50 %\n"));
  CHECK(contains(text, "41.0 \u00b5m  \u2264 50.0 \u00b5m  82 %  held"));
  CHECK(contains(text, "=> held"));
  CHECK(contains(text, "FAILED"));
  CHECK(contains(text, "=> FAILED"));
}

TEST_CASE("The page has a summary, each case, its tables, bounds and pictures, and no date", "[report]") {
  const std::string page = markdownOf(sampleReport());
  INFO(page);
  CHECK(contains(page, "1 of 2 cases are held; 3 of 4 bounds."));
  CHECK(contains(page, "| [Compressed gel cylinder](#gel_cylinder) | held | Largest distance to the reference |"));
  CHECK(contains(page, "| [Extended box](#box) | **FAILED** | Error at the probes | 2.00 mm | \u2264 1.00 mm |"));
  CHECK(contains(page, "<a id=\"gel_cylinder\"></a>\n\n## Compressed gel cylinder\n"));
  CHECK(contains(page, "| Spacing | Nodes | Reaction | Error |\n| ---: | ---: | ---: | ---: |\n"));
  CHECK(contains(page, "| Order of convergence | 1.90 | \u2265 1.50 | 79 % | held |"));
  CHECK(contains(page, "](gel_cylinder_force.png)"));
  CHECK(contains(page, "computed\\]]("));             // brackets in a picture's text don't end it
  CHECK(contains(page, "[measured \\| computed]*"));  // nor does a bar end a cell
  CHECK(contains(page, "```sh\nmtled verify --report out\n```"));
  CHECK(contains(page, buildInfo()));
  CHECK(page == markdownOf(sampleReport()));
  CHECK(page.find("## Compressed") < page.find("## Extended"));
  CHECK(page.find("| Case |") < page.find("## Compressed"));
  CHECK(page.substr(page.size() - 2) != "\n\n");
}

TEST_CASE("A report in JSON tells NaN from infinities", "[report]") {
  Report report = sampleReport();
  report.cases[1].bounds.push_back({"Blown up \"quoted\"", not_a_number, inf, true, "N", "n"});
  const auto cases = nlohmann::json::parse(jsonOf(report)).at("cases");
  REQUIRE(cases.size() == 2);
  CHECK(cases[0].at("bounds")[1].at("value") == 41e-6);
  const auto& blown = cases[1].at("bounds")[1];
  CHECK(blown.at("quantity") == "Blown up \"quoted\"");
  CHECK(blown.at("value") == "nan");
  CHECK(blown.at("limit") == "inf");
  CHECK(blown.at("held") == false);
  CHECK(cases[0].at("tables")[0].at("rows") == report.cases[0].tables[0].rows);
}

TEST_CASE("A report's folder is made - one that can't be is named", "[report]") {
  const TempFolder folder;
  writeReport(folder.path("a/b"), sampleReport());
  CHECK(readAll(folder.path("a/b/README.md")) == markdownOf(sampleReport()));
  CHECK(std::ifstream(folder.path("a/b/results.json")).good());
  const std::string file = folder.write("file", "");
  CHECK_THROWS_WITH(writeReport(file + "/x", sampleReport()), Catch::Contains(file));
}
