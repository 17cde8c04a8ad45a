#include "mtled/verify/verify_command.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

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

  const auto report = nlohmann::json::parse(readAll(options.json));
  REQUIRE(report.at("cases").size() == 1);
  CHECK(report.at("held") == true);
  const auto& approximation = report.at("cases")[0];
  CHECK(approximation.at("name") == "approximation");
  CHECK(approximation.at("bounds").size() > 5);
  CHECK(approximation.at("seconds") > 0);
  CHECK_THAT(report.at("command").get<std::string>(), Contains("verify approximation --quick"));

  CHECK(readAll(folder.path("page/results.json")) == readAll(options.json));
  const std::string page = readAll(folder.path("page/README.md"));
  CHECK(approximation.at("figures").empty() == !withoutPictures().empty());
  CHECK_THAT(page + said, Contains(withoutPictures()));
  for (const auto& figure : approximation.at("figures")) {
    const std::string file = figure.at("file");
    CHECK_THAT(page, Contains(file));
    CHECK(readAll(folder.path("page/" + file)).substr(1, 3) == "PNG");
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
