#include "mtled/verify/verify_command.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "mtled/report/report_page.h"
#include "mtled/verify/verification_case.h"
#include "support/captured_output.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::tools;
using Catch::Contains;

namespace {

/// Runs the command; what it prints goes to `said`.
int verify(const VerifyOptions& options, std::string* said = nullptr) {
  const CapturedOutput output;
  const int code = verifyCommand(options);
  if (said) *said = output.said();
  return code;
}

}  // namespace

TEST_CASE("An unknown verification case is refused with the names of all", "[verify_command]") {
  VerifyOptions options;
  options.cases = {"approximation", "box_extenson"};  // refused before the first is run
  const std::string message = refusal([&] { verify(options); });
  CHECK_THAT(message, Contains("box_extenson"));
  for (const auto& c : verificationCases()) CHECK_THAT(message, Contains(c.name));
}

TEST_CASE("verify approximation holds, and writes its results and its page", "[verify_command][whole]") {
  const TempFolder folder;
  VerifyOptions options;
  options.cases = {"approximation"};
  options.quick = true;
  options.json = folder.path("results.json");
  options.report = folder.path("page");
  options.threads = 1;
  std::string said;
  REQUIRE(verify(options, &said) == 0);
  CHECK_THAT(said, Contains("approximation") && Contains("MMLS stands"));

  const Report report = reportFromJson(readAll(options.json));
  REQUIRE(report.cases.size() == 1);
  CHECK(report.held());
  CHECK(report.cases[0].name == "approximation");
  CHECK(report.cases[0].bounds.size() > 5);
  CHECK(report.cases[0].seconds > 0);
  CHECK_THAT(report.command, Contains("verify approximation --quick"));

  CHECK(readAll(folder.path("page/results.json")) == readAll(options.json));
  const std::string page = readAll(folder.path("page/README.md"));
  CHECK(report.cases[0].figures.empty() == !withoutPictures().empty());
  CHECK_THAT(page + said, Contains(withoutPictures()));
  for (const auto& figure : report.cases[0].figures) {
    CHECK_THAT(page, Contains(figure.file));
    CHECK(readAll(folder.path("page/" + figure.file)).substr(1, 3) == "PNG");
  }
}

TEST_CASE("A page or file that can't be written is an error of the system", "[verify_command]") {
  const TempFolder folder;
  folder.write("blocked", "a file stands here");
  VerifyOptions options;
  options.cases = {"approximation"};
  options.quick = true;
  options.report = folder.path("blocked") + "/page";
  CHECK_THROWS_WITH(verify(options), Contains("blocked"));
}
