#include "mtled/batch/batch_command.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/csv_table.h"
#include "mtled/batch/batch_job.h"
#include "support/block_text.h"
#include "support/captured_output.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::tools;
using Catch::Contains;

namespace {

const std::string press_script = R"(name = "press"
from_touch = true
[[keyframe]]
time = 0.02
advance = 0
[[keyframe]]
time = 0.1
advance = 0.002
)";

/// Five short jobs on one small scene, of which two share a model and one can't be run.
struct BatchFolder : TempFolder {
  std::string jobs;
  BatchFolder() {
    const std::string scene = write("block.toml", replaced(test::touched_block_text, "0.012", "0.02")),
                      tool = write("press.toml", press_script);
    const auto job = [&](const std::string& id, const std::string& rest) {
      return R"({"id": ")" + id + R"(", "scene": ")" + scene + R"(", "tool": ")" + tool + "\"" + rest + "}\n";
    };
    jobs =
        write("jobs.jsonl", job("plain", "") + job("soft", R"(, "field": "npz", "set": {"material[0].young": 1500})") +
                                "\n" + job("long", R"(, "seconds": 0.15, "field": "vtu")") +
                                job("bad", R"(, "set": {"material[0].poisson": 7})") +
                                job("damped", R"(, "set": {"dynamics.damping": 60, "tool.friction": 0.3})"));
  }

  int runBatch(const std::string& out, int workers, const std::string& shard = "",
               const std::vector<std::string>& merge = {}) const {
    const CapturedOutput quiet;
    BatchOptions options;
    options.jobs = jobs;
    options.out = path(out);
    options.workers = workers;
    options.shard = shard;
    options.merge = merge;
    return batchCommand(options);
  }
  std::string read(const std::string& name) const { return readAll(path(name)); }
};

}  // namespace

TEST_CASE("A batch gives the same bits with any number of workers, keeps failures, and takes up what is done",
          "[batch]") {
  const BatchFolder folder;
  CHECK(folder.runBatch("one", 1) == 1);  // a job fails
  CHECK(folder.runBatch("three", 3) == 1);
  const std::string results = folder.read("one/results.jsonl");
  CHECK(results == folder.read("three/results.jsonl"));
  for (const char* id : {"plain", "soft", "long", "damped"}) {
    INFO(id);
    const std::string force = folder.read(std::string("one/") + id + "/force.csv");
    CHECK(!force.empty());
    CHECK(force == folder.read(std::string("three/") + id + "/force.csv"));
  }
  CHECK(folder.read("one/long/field.vtu") == folder.read("three/long/field.vtu"));
  CHECK_FALSE(std::filesystem::exists(folder.path("one/plain/field.vtu")));
  CHECK(folder.read("one/soft/field.npz").starts_with("PK"));
  CHECK(folder.read("one/soft/field.npz") == folder.read("three/soft/field.npz"));

  std::vector<BatchResult> result;
  std::istringstream lines(results);
  for (std::string line; std::getline(lines, line);) result.push_back(resultFromLine(line, {}));
  REQUIRE(result.size() == 5);
  CHECK(result[0].last_force > 0);
  CHECK(result[1].last_force > 0.25 * result[0].last_force);  // half as stiff, of the same mass
  CHECK(result[1].last_force < 0.75 * result[0].last_force);
  CHECK(result[2].seconds == 0.15);
  CHECK_FALSE(result[3].done);
  CHECK_THAT(result[3].reason, Contains("block.toml") && Contains("poisson"));
  CHECK(result[4].state_hash != result[0].state_hash);
  CHECK(result[0].state_hash.size() == 16);
  const nlohmann::json report = nlohmann::json::parse(folder.read("three/batch.json"));
  CHECK(report["done"] == 4);
  CHECK(report["failed"] == 1);
  CHECK(report["physics_seconds"].get<double>() > 0.4);

  // Only what is missing, in part, too, failed or of another job is run again.
  std::filesystem::remove(folder.path("one/soft/field.npz"));
  const auto before = std::filesystem::last_write_time(folder.path("one/plain/force.csv"));
  CHECK(folder.runBatch("one", 2) == 1);
  CHECK(nlohmann::json::parse(folder.read("one/batch.json"))["kept_from_before"] == 3);
  CHECK(std::filesystem::last_write_time(folder.path("one/plain/force.csv")) == before);
  CHECK(folder.read("one/results.jsonl") == results);
  folder.write("press.toml", replaced(press_script, "0.002", "0.0015"));
  CHECK(folder.runBatch("one", 2) == 1);
  CHECK(nlohmann::json::parse(folder.read("one/batch.json"))["kept_from_before"] == 0);
  CHECK(folder.read("one/results.jsonl") != results);
}

TEST_CASE("Where a result can't be written its job failed, and the others go on", "[batch]") {
  const BatchFolder folder;
  std::filesystem::create_directories(folder.path("out/plain/result.json"));
  CHECK(folder.runBatch("out", 2) == 1);
  const nlohmann::json report = nlohmann::json::parse(folder.read("out/batch.json"));
  CHECK(report["done"] == 3);
  CHECK(report["failed"] == 2);
  CHECK_THAT(folder.read("out/results.jsonl"), Contains("out/plain/result.json: Is a directory"));
}

TEST_CASE("A job's cloud follows its tool, with the same bits again", "[batch][whole]") {
  TempFolder folder;
  const std::string bar = replaced(replaced(test::touched_block_text, "spacing = 0.012", ""),
                                   "size = [0.06, 0.06, 0.03]", "size = [0.12, 0.04, 0.03]"),
                    way =
                        "name = \"way\"\nfrom_touch = true\n[[keyframe]]\ntime = 0.05\nadvance = 0.003\n"
                        "[[keyframe]]\ntime = 0.3\nadvance = 0.003\nslide = [0.03, 0]\n";
  const std::string scene = folder.write("bar.toml", bar), tool = folder.write("way.toml", way);
  const auto job = [&](const char* id) {
    return std::string("{\"id\": \"") + id + "\", \"scene\": \"" + scene + "\", \"tool\": \"" + tool + "\"}\n";
  };
  BatchOptions options;
  options.jobs = folder.write("jobs.jsonl", job("one") + job("two"));
  options.out = folder.path("out");
  options.workers = 2;
  const CapturedOutput quiet;
  REQUIRE(batchCommand(options) == 0);
  const std::string force = readAll(folder.path("out/one/force.csv"));
  CHECK(force == readAll(folder.path("out/two/force.csv")));
  const CsvTable table = readCsvTable(folder.path("out/one/force.csv"));
  CHECK(table["nodes"].front() != table["nodes"].back());  // another place
  CHECK(table["place_late"] == std::vector<double>(table.rowCount(), 0));
}

TEST_CASE("Shards on many machines make the whole, and a merge refuses what is missing or doubled", "[batch]") {
  const BatchFolder folder;
  CHECK(folder.runBatch("whole", 2) == 1);
  CHECK(folder.runBatch("a", 1, "1/2") == 0);
  CHECK(folder.runBatch("b", 1, "2/2") == 1);
  CHECK(folder.runBatch("merged", 1, "", {folder.path("a"), folder.path("b")}) == 1);
  CHECK(folder.read("merged/results.jsonl") == folder.read("whole/results.jsonl"));

  const auto refused = [&](const std::vector<std::string>& parts) {
    return refusal([&] { folder.runBatch("refused", 1, "", parts); });
  };
  CHECK_THAT(refused({folder.path("a")}), Contains("no folder has a result of \"soft\""));
  CHECK_THAT(refused({folder.path("a"), folder.path("b"), folder.path("a")}),
             Contains("results.jsonl:1") && Contains("second result of \"plain\""));
  folder.write("jobs.jsonl", replaced(folder.read("jobs.jsonl"), "young\": 1500", "young\": 1501"));
  CHECK_THAT(refused({folder.path("a"), folder.path("b")}), Contains("\"soft\" is of no job"));
  CHECK_FALSE(std::filesystem::exists(folder.path("refused")));
  CHECK_THAT(refusal([&] { folder.runBatch("x", 1, "3/2"); }), Contains("K/N"));
}

TEST_CASE("A line that is no job is refused with its place", "[batch]") {
  const TempFolder folder;
  const auto refused = [&](const std::string& line) {
    return refusal([&] { readBatchJobs(folder.write("j.jsonl", "{\"scene\": \"liver\"}\n\n" + line + "\n")); });
  };
  CHECK_THAT(refused("{"), Contains("j.jsonl:3: this line is no JSON"));
  CHECK_THAT(refused("[]"), Contains("j.jsonl:3: a job is no JSON object"));
  CHECK_THAT(refused("{}"), Contains("without a scene"));
  CHECK_THAT(refused(R"({"scene": "liver", "set": {"tool.radius": 0.01, "tool.radius": 0.02}})"),
             Contains("j.jsonl:3: \"tool.radius\" stands there twice"));
  CHECK_THAT(refused(R"({"scene": "liver", "secnods": 1})"), Contains("\"secnods\"") && Contains("seconds"));
  CHECK_THAT(refused(R"({"scene": "liver", "seconds": -1})"), Contains("\"seconds\" is no number above 0"));
  CHECK_THAT(refused(R"({"scene": "liver", "field": "pdf"})"), Contains("\"vtu\" and \"npz\""));
  CHECK_THAT(refused(R"({"scene": "liver", "picture": 1})"), Contains("\"picture\" is neither"));
  CHECK_THAT(refused(R"({"scene": "liver", "id": "../x"})"), Contains("\"../x\" can't be the name of a folder"));
  CHECK_THAT(refused(R"({"scene": "liver", "id": "results.jsonl"})"), Contains("writes itself"));
  CHECK_THAT(refused(R"({"scene": "liver", "id": "job-1"})"), Contains("there is a job \"job-1\" before"));
  CHECK_THAT(refused(R"({"scene": "liver", "set": {"tool.radius": null}})"), Contains("\"tool.radius\" no value"));
  CHECK_THAT(refusal([&] { readBatchJobs(folder.write("empty.jsonl", "\n")); }), Contains("there is no job"));
}

TEST_CASE("What a job names is first looked for beside its file", "[batch]") {
  const TempFolder folder;
  const std::string scene = folder.write("block.toml", test::touched_block_text);
  const std::string jobs = folder.write("jobs.jsonl", "{\"scene\": \"block.toml\", \"tool\": \"press.toml\"}\n");
  const std::vector<BatchJob> read = readBatchJobs(jobs);
  REQUIRE(read.size() == 1);
  CHECK(read[0].scene == scene);
  CHECK(read[0].tool == "press.toml");  // it isn't there
}
