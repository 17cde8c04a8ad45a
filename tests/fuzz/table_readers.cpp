#include <cmath>
#include <set>

#include "fuzz/memory_file.h"
#include "fuzz/reader.h"
#include "io/csv_table.h"
#include "io/text_file.h"
#include "realtime/recording/recording_file.h"

namespace palpate::fuzz {

namespace {

std::vector<std::string> csvSeeds() {
  return {"X,Y,Z\n0,0,0.015\n0.01,-0.02,3e-2\n",
          "# a curve\n\"time, s\", base_fx_N ,min_J\r\n0.1,nan,1\r\n\r\n0.2,,0.5\r\n"};
}

std::vector<std::string> recordingSeeds() {
  return {R"(palpate-recording 3
scene liver and gall
model 0123456789abcdef
rate_hz 500
0 tool 0 0 0.1  1 0 0 0
12 pull 411 0.01 0 0.12
15 release
20 friction 0.3
21 material 0 neo-hookean young 3000 poisson 0.49 barrier_strength 0 barrier_J0 0.5 density 1060
22 material 0 neo-hookean young 3000 poisson 0.49 barrier_strength 0.1 barrier_J0 0.5 density 1060 relaxation 2 0.3 0.1
30 reset
end 500
)"};
}

void readCsvFrom(const std::string& bytes) {
  static const MemoryFile file;
  const CsvTable table = readCsvTable(file.write(bytes));
  hold(!table.name.empty() && table.name.size() == table.column.size(), "names and columns differ in number");
  hold(std::set<std::string>(table.name.begin(), table.name.end()).size() == table.name.size(),
       "two columns have one name");
  for (std::size_t k = 0; k < table.column.size(); ++k) {
    hold(table.column[k].size() == table.rowCount(), "a column is not as long as the table");
    hold(&table[table.name[k]] == &table.column[k], "a column is not found by its name");
    for (const double x : table.column[k]) hold(!std::isinf(x), "an infinite number");
  }
}

/// What was read can be written, and reads back the same.
void readRecordingFrom(const std::string& bytes) {
  static const MemoryFile file, again, once_more;
  const Recording recording = readRecording(file.write(bytes));
  hold(recording.rate_hz > 0 && recording.ticks >= 0, "a recording that can't be played");
  std::int64_t last = 0;
  for (const TimedRequest& change : recording.changes) {
    hold(change.tick >= last && change.tick <= recording.ticks, "a change out of its turn");
    last = change.tick;
  }
  again.write(toText(recording));
  once_more.write(toText(readRecording(again.path())));
  hold(readWholeFile(again.path()) == readWholeFile(once_more.path()), "written and read it is another recording");
}

}  // namespace

const Reader csv_reader = {"csv", csvSeeds, readCsvFrom};
const Reader recording_reader = {"recording", recordingSeeds, readRecordingFrom};

}  // namespace palpate::fuzz
