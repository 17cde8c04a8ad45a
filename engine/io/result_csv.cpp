#include "io/result_csv.h"

#include <cerrno>
#include <stdexcept>

#include "base/number_text.h"

namespace palpate {

ResultCsv::ResultCsv(const std::string& path, const std::vector<std::string>& columns)
    : path_(path), file_(path), column_count_(columns.size()) {
  errno = 0;
  out_.open(file_.part(), std::ios::binary | std::ios::trunc);
  if (!out_) failWriting(path_, errno);
  std::string header;
  for (const std::string& column : columns) {
    if (column.find_first_of(",\"\r\n") != std::string::npos) {
      throw std::invalid_argument("a column's name with a comma, quote or line end: " + column);
    }
    header += (header.empty() ? "" : ",") + column;
  }
  write(header + "\n");
}

void ResultCsv::add(std::span<const double> values, std::string_view trust) {
  if (values.size() + (trust.empty() ? 0 : 1) != column_count_)
    throw std::invalid_argument("a row of another length than the header: " + path_);
  std::string line;
  for (double value : values) {
    if (!line.empty()) line += ',';
    line += shortest(value);
  }
  if (!trust.empty()) line.append(",").append(trust);
  write(line + "\n");
}

void ResultCsv::finish() {
  errno = 0;
  out_.close();
  if (!out_) failWriting(path_, errno);
  if (file_.pending()) file_.takePlace();
}

void ResultCsv::write(const std::string& line) {
  errno = 0;
  out_ << line << std::flush;
  if (!out_) failWriting(path_, errno);
}

std::string csvQuoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

}  // namespace palpate
